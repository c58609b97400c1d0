"""The classic experiments: five runs that show what a simulator of mobile robots is for, each with its verdict."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
