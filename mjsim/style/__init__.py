"""The look of a world in a style: skirting, windows, papers, lamps and the like, seen only by cameras."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
