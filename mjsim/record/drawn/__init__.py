"""Messages from which Foxglove draws a recording: the map, frames, pictures, scans, items of modules."""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
