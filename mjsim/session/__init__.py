"""A run in a thread of its own, which others start, pause, slow, steer and watch."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
