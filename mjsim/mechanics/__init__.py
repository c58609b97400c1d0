"""Joints: arms from DH tables, their kinematics and dynamics, paths of joints and tools; without MuJoCo and files."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
