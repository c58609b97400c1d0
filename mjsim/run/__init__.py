"""The loop: sense, decide, apply, step; and the modules of the user's that decide."""

from mjsim.run.loop import drivers_of, run, ticks
from mjsim.run.pilot import Driver

__all__ = ["Driver", "drivers_of", "run", "ticks"]
