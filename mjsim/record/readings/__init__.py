"""All kinds of readings, as an `Observation` holds them, to messages and back: one file for each kind."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
