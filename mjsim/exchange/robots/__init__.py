"""Robots from their makers' files: wheels, casters, steering and sensors found, measured and written as a preset."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
