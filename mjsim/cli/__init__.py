"""The command line, `mjsim`: one file for each group of commands."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
