"""A running world as a ROS 2 robot, for any machine beside it; ROS need not be installed here."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
