"""Strict readers of text files, tables and pictures of logs."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
