"""Statistics, plots and pages of one run, or of many in comparison, from recordings alone."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
