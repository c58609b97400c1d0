"""Sensors at work, one file a kind: what they measure of the physics, and their errors."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
