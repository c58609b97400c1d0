"""Figures of people: body measures of a survey, and the body that has them; arrays in, arrays out, no MuJoCo."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
