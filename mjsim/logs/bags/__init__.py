"""Bags of ROS 1 and ROS 2, read without ROS."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
