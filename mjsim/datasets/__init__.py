"""Exports recordings to formats of other programs: ROS 2 bags and SLAM data sets."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
