from .host import OctaveHost as OctaveHost
