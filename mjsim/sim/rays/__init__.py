"""Rays against the scene: distances to walls, objects and robots."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
