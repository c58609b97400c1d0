"""Scripts of MATLAB in GNU Octave: functions for arms beside them, and their figures drawn by matplotlib."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
