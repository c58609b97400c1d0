from .host import OctaveHost as OctaveHost
from .installed import octave_found as octave_found
