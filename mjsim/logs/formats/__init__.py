"""Logs and data sets of known formats, and the user's own tables."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
