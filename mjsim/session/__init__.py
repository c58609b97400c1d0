"""A run in a background thread that other threads start, pause, slow down, steer and watch."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
