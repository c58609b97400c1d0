"""Bases at work, one file a drive: kinematics, limits and noise of the motors, odometry."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
