"""Occupancy grids of ROS, and walls and objects traced from their cells."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
