"""Files that mjsim writes: whole or not there, and none of the user's is replaced without word."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
