"""`include`, `variables`, `repeat` and arithmetic: what a text stands for; and the JSON Schema."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
