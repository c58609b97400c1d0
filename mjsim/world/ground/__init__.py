"""What all parts of a world share: the strict model and its kinds of values, names, sentences about faults."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
