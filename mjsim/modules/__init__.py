"""User modules: their roles, and the boundary at which whatever they do wrong becomes one line."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
