"""Readings with times of their own become ticks of a recording."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
