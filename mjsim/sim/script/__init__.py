"""Scripted motions of a world: events, movers, doors and other joints, shoves."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
