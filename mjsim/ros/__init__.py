"""Readings and estimates of robots as ROS 2 messages, without ROS: names, frames, types and qualities of service."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
