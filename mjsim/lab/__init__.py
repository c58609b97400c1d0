"""The control laboratory: plants made linear, looked at, simulated, identified and controlled."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
