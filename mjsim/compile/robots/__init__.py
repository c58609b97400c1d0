"""Robots as MuJoCo bodies: wheels and running gear, sensors, checks of stability."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
