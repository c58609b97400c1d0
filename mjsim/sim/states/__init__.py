"""A compiled world in given states, drawn or exported without simulation."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
