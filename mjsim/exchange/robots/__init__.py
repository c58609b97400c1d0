"""Imports robots from manufacturers' files: finds and measures wheels, casters, steering, sensors; writes presets."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
