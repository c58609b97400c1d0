"""Valid but implausible: robots in walls, hidden beacons, movers through walls, modules that are missing."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
