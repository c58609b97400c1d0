"""Modules in separate processes: start, requests, limits and responses."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
