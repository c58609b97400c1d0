"""Drives to goals by what it sees: obstacles remembered, paths planned, motions sampled."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
