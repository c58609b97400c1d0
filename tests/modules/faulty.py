"""Modules that do something wrong after a few ticks, written for a test."""

import textwrap

DT, TICKS = 0.04, 5
ROOM = """
mjsim: 1
name: room
beacons: [{name: lion, at: [2, 0.5]}, {name: bear, at: [2, -0.5]}]
robots:
  - name: scout
    at: [0, 0]
    odometry: {noise: {distance: 0, turn: 0}}
    sensors:
      - {beacons: ring, range: [0.2, 8], fov_deg: 360, rate_hz: 25}
      - {lidar: scan, at: [0, 0, 0.35], beams: 8, fov_deg: 360, rate_hz: 25}
run: {seconds: 0.6, map: known, drivers: {scout: {ROLE: {use: "bad.py:Bad"}}}}
"""
HEAD = "import asyncio, dataclasses, sys, threading, warnings\nimport numpy as np\nimport mjsim\n"
HEAD += "ORIGIN, EYE = mjsim.Pose(0.0, 0.0, 0.0), np.eye(3)\n"
ASKED = {
    "observer": ("start(self, robot, catalogue, rng)", "observe(self, seen)", "[]"),
    "estimator": ("start(self, robot, catalogue, rng)", "update(self, seen)", "mjsim.Estimate(ORIGIN, EYE)"),
    "navigator": ("start(self, robot, map, rng)", "command(self, seen, belief)", "mjsim.Command(0.1)"),
    "avoidance": ("start(self, robot, rng)", "adjust(self, command, seen)", "command"),
}
"""Role -> how it is started and asked, and an answer that is right."""


def written(role: str, body: str, *, start: str = "self.robot = robot", above: str = "") -> str:
    """Return a module that answers well for TICKS ticks, and then does as `body` says."""
    begins, asked, good = ASKED[role]
    lines = [
        HEAD + textwrap.dedent(above),
        "class Bad:",
        f"    def {begins}:",
        textwrap.indent(start, " " * 8),
        f"    def {asked}:",
        f"        if seen.time < {(TICKS - 0.5) * DT}:",
        f"            return {good}",
        textwrap.indent(textwrap.dedent(body), " " * 8),
    ]
    return "\n".join(lines) + "\n"


def made(module: str):
    """Return an instance of the class that a module holds, as a file named bad.py."""
    names = {"__name__": "bad"}
    exec(compile(module, "bad.py", "exec"), names)
    return names["Bad"]()
