"""MJCF and URDF files: their contents, and their outlines from above."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
