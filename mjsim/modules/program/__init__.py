"""Modules that are programs in any language: JSON lines on standard input and output."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
