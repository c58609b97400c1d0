"""A run in a thread of its own, which others start, pause, slow, steer and watch."""

from mjsim.session.gate import State
from mjsim.session.session import Session
from mjsim.session.watcher import Watcher

__all__ = ["Session", "State", "Watcher"]
