"""Estimators as the textbook prints them, one short file each, to read first and to compare others with.

Formulas, names and tables are those of Thrun, Burgard, Fox, Probabilistic Robotics (2005). Nothing is gated, learnt or
made robust: `EkfSlam`, `FastSlam` and `MonteCarloLocalization` show what that takes.
"""

from mjsim.faces import face

# A class loads its module when it is first used; `__init__.pyi` says which.
__getattr__, __dir__, __all__ = face(__name__, __file__)
