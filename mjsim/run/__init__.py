"""The control loop (sense, decide, apply, step) and its modules."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
