"""Expands xacro: expressions only compute, and elements read only files of the robot.

References:
    https://wiki.ros.org/xacro
    https://github.com/ros/xacro, with which results agree
"""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
