"""Drives to goals with sensed obstacles: it remembers them, plans paths and samples motions."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
