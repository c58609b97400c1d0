"""Modules in processes of their own: how they are started, asked, bounded, and what becomes of their answers."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
