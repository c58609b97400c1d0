"""Logs of real robots -> recordings, so that one class runs in simulation and on real data."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
