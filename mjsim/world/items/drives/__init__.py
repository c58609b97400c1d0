"""Drives as a world file describes them: how a robot moves, and what its wheels tell of it. One file a drive."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
