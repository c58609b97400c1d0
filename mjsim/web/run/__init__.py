"""A run in the browser: its state, messages and pictures, in JSON."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
