"""Models of Gazebo (SDF): frames, shapes, and objects."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
