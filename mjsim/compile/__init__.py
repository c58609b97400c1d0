"""World -> MuJoCo: a scene in memory, or a folder that plain MuJoCo loads."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
