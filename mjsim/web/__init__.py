"""The studio's server: shows and steers runs in the browser; displaying never steps the simulation."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
