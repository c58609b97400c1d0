"""The room: walls, floor, ceiling, doors, beacons, and the look of furniture."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
