"""Postures by inverse kinematics: contacts that hold exactly, joint limits, and preferred joint angles."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
