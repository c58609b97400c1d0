"""EKF-SLAM with beacons: the filter, its variants, association, and the management of its map."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
