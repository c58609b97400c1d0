"""Runs many seeds and settings on many cores or machines, and writes one table."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
