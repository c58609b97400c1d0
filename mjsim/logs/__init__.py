"""Logs of real robots -> recordings, so that one class runs in simulation and on real data."""

from mjsim.logs.mrclam import import_mrclam
from mjsim.logs.victoria_park import import_victoria_park

__all__ = ["import_mrclam", "import_victoria_park"]
