"""Drives and odometry as described in a world file, one file per drive."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
