"""A recording -> film: plan and figures drawn, 3-D views drawn again from the recorded states."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
