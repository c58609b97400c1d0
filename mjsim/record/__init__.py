"""Ticks to a file and back: the MCAP recording and its exports."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
