"""Drawing a compiled scene: what is in view, baked light, shadows, images and instances."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
