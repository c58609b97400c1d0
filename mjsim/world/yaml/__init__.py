"""YAML 1.2 text to plain values that know where they were written, and back to places in the text."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
