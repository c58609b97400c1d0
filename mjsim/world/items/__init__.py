"""The models of the world file: walls, things, robots, sensors, drives, events, and the `World` of them."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
