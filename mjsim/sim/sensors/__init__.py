"""Simulated sensors, one file per kind: measurements of the physics, and their errors."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
