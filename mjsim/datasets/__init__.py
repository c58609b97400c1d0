"""A recording in the forms of other programs: bags of ROS 2, and the data sets of SLAM."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
