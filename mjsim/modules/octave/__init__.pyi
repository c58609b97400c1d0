from .installed import TOOLBOX as TOOLBOX
from .installed import find_octave as find_octave
from .installed import octave_found as octave_found
from .octave_host import OctaveHost as OctaveHost
