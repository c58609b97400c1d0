"""What happens during a run, as described in a world file: events and signals."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
