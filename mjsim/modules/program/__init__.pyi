from .host import ProgramHost as ProgramHost
