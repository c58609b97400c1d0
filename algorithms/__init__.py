"""Reference modules, written like a user's own: with only the public names of mjsim."""

from mjsim.faces import face

# A class loads its module when it is first used; `__init__.pyi` says which.
__getattr__, __dir__, __all__ = face(__name__, __file__)
