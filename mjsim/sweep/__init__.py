"""Many runs on many cores or many machines -> one table."""

from mjsim.sweep.sweep import Sweep, run_plan, sweep

__all__ = ["Sweep", "run_plan", "sweep"]
