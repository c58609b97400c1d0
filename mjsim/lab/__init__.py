"""The control laboratory: linearises, analyses, simulates, identifies and controls plants."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
