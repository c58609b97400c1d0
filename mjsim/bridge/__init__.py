"""Connects a running world to ROS 2, for any machine in the network, without a ROS installation."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
