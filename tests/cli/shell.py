"""The command line as a person types it, and a folder with a world."""

import contextlib
import sys
import time

import pytest

import mjsim
from mjsim.cli import main
from tests.children import child

ROOM = """
mjsim: 1
name: room
walls: [{points: [[0, 0], [4, 0], [4, 3], [0, 3]], closed: true}]
beacons: [{name: lion, image: posters/lion.jpg, at: [3.94, 1.5], heading_deg: 180}]
robots:
  - {name: scout, preset: pioneer3dx, at: [1, 1.5], odometry: {noise: {distance: 0, turn: 0}},
     sensors: [{camera: front, width: 160, height: 120, noise: 0}]}
run:
  seconds: 1
  drivers: {scout: {navigator: {use: "forward.py:Forward", speed: 0.3}}}
"""
FORWARD = """
import mjsim

class Forward:
    def __init__(self, speed):
        self.speed = speed
    def start(self, robot, map, rng):
        pass
    def command(self, seen, belief):
        return mjsim.Command(self.speed)
"""


def typed(*words, capsys):
    """Run the command line in this process; return exit code, stdout and stderr."""
    with pytest.raises(SystemExit) as ended:
        main(words)
    out, err = capsys.readouterr()
    return ended.value.code, out, err


def shell(*words):
    return child([sys.executable, "-m", "mjsim.cli", *words])


def wait_for_ticks(path):
    """Wait until a recording that is being written holds some; return what it holds."""
    until = time.monotonic() + 60.0
    while True:
        with contextlib.suppress(mjsim.UsageError, mjsim.RecordingError):
            return mjsim.read_recording(path)
        assert time.monotonic() < until, f"no tick ever came into {path}"
        time.sleep(0.05)
