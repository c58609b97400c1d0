"""SLAM with a camera and odometry: features, landmarks, loops by appearance, and a graph of poses."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
