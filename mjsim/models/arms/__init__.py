"""Arms in MJCF, URDF and xacro files, as plain numbers."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
