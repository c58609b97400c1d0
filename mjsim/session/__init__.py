"""A run in a thread of its own, which others start, pause, slow, steer and watch."""

from mjsim.session.session import Session, State
from mjsim.session.watcher import Watcher

__all__ = ["Session", "State", "Watcher"]
