"""Simulated mechanisms: motions, closed loops, controllers, sensors, and what holds and pushes them."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
