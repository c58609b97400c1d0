"""Events and signals during a run, as described in a world file."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
