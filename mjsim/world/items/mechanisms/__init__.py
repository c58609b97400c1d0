"""Mechanisms in a world file: bodies, joints, constraints, actuators and sensors."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
