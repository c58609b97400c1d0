"""Imports logs of real robots as recordings, so that the same class runs in simulation and on real data."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
