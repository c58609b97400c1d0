"""OpenGL without a screen: contexts, and the calls that MuJoCo does not wrap."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
