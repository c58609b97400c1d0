"""Ticks to a file and back: the MCAP recording and its exports."""

from mjsim.record.file import numeric_topics, same_run
from mjsim.record.reader import read_recording
from mjsim.record.recorder import Recorder
from mjsim.record.recording import Landmarks, Recording, Track
from mjsim.record.tick import Event, Order, Tick

__all__ = [
    "Event",
    "Landmarks",
    "Order",
    "Recorder",
    "Recording",
    "Tick",
    "Track",
    "numeric_topics",
    "read_recording",
    "same_run",
]
