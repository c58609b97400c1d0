"""Mechanisms as a world file describes them: bodies, joints, constraints, actuators and sensors."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
