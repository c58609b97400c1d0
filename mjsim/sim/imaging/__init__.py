"""From rendered light to the picture of a camera: lens, shutter, exposure, noise, depth."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
