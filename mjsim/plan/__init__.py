"""One plan, one look: a world and its runs as shapes, and the colours in which all pictures show them."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
