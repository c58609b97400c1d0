"""Many runs on many cores or many machines -> one table."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
