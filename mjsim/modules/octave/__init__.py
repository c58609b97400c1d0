"""Modules written for Octave and MATLAB: one Octave process per module."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
