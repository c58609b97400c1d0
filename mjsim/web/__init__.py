"""Watching a run in the browser; what is shown never steps the simulation."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
