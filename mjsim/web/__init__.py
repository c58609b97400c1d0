"""Watching a run in the browser; what is shown never steps the simulation."""

from mjsim.web.live import LiveView

__all__ = ["LiveView"]
