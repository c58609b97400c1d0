"""Requests of the page for recordings: overview, moments, comparison, films."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
