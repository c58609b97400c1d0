"""Sensors as described in a world file, and their presets."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
