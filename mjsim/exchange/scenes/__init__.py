"""Worlds from scenes of other simulators: SDF of Gazebo, MJCF of MuJoCo and worlds of Webots."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
