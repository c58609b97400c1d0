from .program_host import ProgramHost as ProgramHost
