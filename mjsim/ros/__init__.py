"""What a robot senses and believes as messages of ROS 2, without ROS: names, frames, types and qualities of service."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
