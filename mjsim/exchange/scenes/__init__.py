"""Worlds from scenes of other simulators: SDF of Gazebo and MJCF of MuJoCo."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
