"""Recordings -> statistics, plots and pages, of one run or of many compared; nothing but files is needed."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
