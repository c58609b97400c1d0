"""How notebooks show worlds, simulations, recordings and results; plots with pyplot, and tables for pandas."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
