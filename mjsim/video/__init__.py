"""Videos of recordings: plan and charts, and 3-D views rendered again from the recorded states."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
