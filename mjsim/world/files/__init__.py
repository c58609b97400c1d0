"""Where a world came from, the files that it names, and the worlds that come with mjsim."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
