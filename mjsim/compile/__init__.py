"""Compiles a World for MuJoCo: a scene in memory, or a folder that MuJoCo loads without mjsim."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
