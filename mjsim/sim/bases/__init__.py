"""Simulated bases, one file per drive: kinematics, limits and noise of the motors, odometry."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
