"""Pictures and markers recognised in a camera's image, and measured."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
