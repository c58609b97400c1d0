"""The loop: sense, decide, apply, step; and the modules of the user's that decide."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
