"""Recordings: ticks to an MCAP file and back, and exports."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
