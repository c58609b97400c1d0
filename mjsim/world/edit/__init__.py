"""`World` to text, and changes in a text that leave everything else as people wrote it."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
