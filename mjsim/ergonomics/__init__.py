"""How people fit their workplaces: posture, reach, sight and clearance, as numbers and as a page."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
