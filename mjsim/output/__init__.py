"""Writes files: completely or not at all, and replaces one of the user only on request."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
