"""Light of static surfaces, computed once for a compiled world by ray casting and stored as light maps."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
