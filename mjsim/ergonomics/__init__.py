"""Ergonomics of workplaces: posture, reach, sight and clearance of people, as numbers and as a page."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
