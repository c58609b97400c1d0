"""Shared by all parts of a world: the strict model, its types of values, names, and texts of errors."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
