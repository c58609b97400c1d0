"""The models of the world file: walls, objects, robots, sensors, drives, events, and `World`."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
