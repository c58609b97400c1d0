"""Files of people, MJCF and URDF: what they consist of, and what they look like from above."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
