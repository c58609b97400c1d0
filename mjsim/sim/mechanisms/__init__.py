"""Simulated mechanisms: motions, closed loops, controllers, sensors, holding and pushing by hand."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
