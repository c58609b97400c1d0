"""Safety: the bump reaction, always on, and the built-in obstacle avoidance."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
