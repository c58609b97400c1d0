"""User modules: their roles, and the boundary that reports each of their faults in one line."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
