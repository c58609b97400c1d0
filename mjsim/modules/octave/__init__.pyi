from .host import OctaveHost as OctaveHost
from .installed import TOOLBOX as TOOLBOX
from .installed import find_octave as find_octave
from .installed import octave_found as octave_found
