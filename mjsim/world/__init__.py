"""The world file: text to a frozen, validated `World`, and back without losing a comment."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
