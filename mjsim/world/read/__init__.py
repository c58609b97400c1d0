"""Text to `World`, all faults at once; and worlds with single values changed."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
