"""The world seen from above: outlines of solid things, corners of walls, doors, routes, positions of beacons."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
