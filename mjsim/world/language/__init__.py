"""Expands `include`, `variables`, `repeat` and arithmetic in a text; and the JSON Schema."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
