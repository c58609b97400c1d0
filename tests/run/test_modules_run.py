"""Every module on the page of algorithms runs from a world file and from Python, and does the same there."""

import ast
import importlib
import itertools
import os
import pty
import re
import sys
from pathlib import Path

import numpy as np
import pytest

import mjsim
from mjsim.run import drivers_of

PAGE = Path(__file__).parents[2] / "docs" / "algorithms.md"
KEYS = {
    "BeaconVision": {"camera": "front"},
    "PathTracking": {"points": [[2, 1.5], [3, 1.2]]},
    "Waypoints": {"points": [[2, 1], [3, 1.5]]},
    "Crab": {"points": [[1.5, 1.5]]},
    "GoToGoal": {"goals": [3, 1]},
    "ConstantCommand": {"forward": 0.2},
    "Signal": {"forward": {"sine": {"amplitude": 0.3, "frequency_hz": 0.5}}},
    "SpeedLoop": {"num": [0.2, 1], "den": [1, 0], "reference": {"constant": {"value": 0.2}}},
}
"""What a module must be told, where it must."""
ELSEWHERE = {"PickUp"}
"""Needs a robot with an arm; the world `manipulator` has one."""
NEEDS = {"GraphSlam": "gtsam", "PathTracking": "toppra"}
"""Extras."""
ROOM = """
mjsim: 1
walls: [{points: [[0, 0], [4, 0], [4, 3], [0, 3]], closed: true}]
obstacles: [{box: [0.4, 0.4, 0.6], at: [2.5, 2.4]}]
beacons:
  - {name: lion, image: posters/lion.jpg, at: [3.94, 1], heading_deg: 180, width: 0.6, center: 0.4}
  - {name: tag, marker: {id: 3}, at: [3.94, 2], heading_deg: 180, width: 0.3, center: 0.4}
  - {name: north, at: [1, 2.9]}
robots:
  - name: scout
    preset: PRESET
    at: [1, 1]
    sensors:
      - {lidar: scan, at: [0, 0, 0.35], beams: 90, fov_deg: 360, rate_hz: 5}
      - {beacons: ring, range: [0.2, 8], fov_deg: 360, rate_hz: 5}
run: {map: known, drivers: {scout: {avoidance: true}}}
"""


def rows():
    """Return (role, module, class) of every row of the page's tables."""
    found, role = [], ""
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        if line.startswith("## "):
            role = line[3:].rstrip("s").lower()
        if line.startswith("| `"):
            names = re.findall(r"`(?:(\w+):)?([A-Z]\w+)`", line.split("|")[1])
            found += [(role, names[0][0], name) for _, name in names]
    return [row for row in found if row[0] in ("observer", "estimator", "navigator")]


def world_for(name: str, **driver: object) -> mjsim.World:
    text = ROOM.replace("PRESET", "robotino" if name == "Crab" else "pioneer3dx")
    if name in ("BeaconVision", "VisualSlam"):
        camera = "{camera: front, at: [0.1, 0, 0.4], width: 320, height: 240, fov_deg: 70, rate_hz: 5}"
        text = text.replace("    sensors:\n", f"    sensors:\n      - {camera}\n")
    lines = "".join(f", {key}: {value}" for key, value in driver.items())
    return mjsim.parse_world(text.replace("{avoidance: true}", f"{{avoidance: true{lines}}}"))


def driven(world: mjsim.World, drivers=None):
    """Return true and believed poses of a second, shape (n, 6)."""
    with mjsim.Simulation(world, seed=3) as sim:
        passing = itertools.takewhile(lambda tick: tick.time < 1.0, mjsim.ticks(sim, drivers or drivers_of(world)))
        return np.array(
            [[*tick.truth["scout"].as_array(), *tick.orders["scout"].estimate.pose.as_array()] for tick in passing]
        )


def test_no_module_is_missing_from_the_page():
    named = {name for _, _, name in rows()}
    for path in (PAGE.parents[1] / "algorithms").glob("*.py"):
        for kind in ast.parse(path.read_text(encoding="utf-8")).body:
            methods = {part.name for part in getattr(kind, "body", ()) if isinstance(part, ast.FunctionDef)}
            module = (
                isinstance(kind, ast.ClassDef) and "start" in methods and methods & {"observe", "update", "command"}
            )
            if module and not kind.name.startswith("_"):
                assert kind.name in named, f"docs/algorithms.md has no row of {kind.name}"


@pytest.mark.slow
@pytest.mark.parametrize(("role", "module", "name"), [row for row in rows() if row[2] not in ELSEWHERE])
def test_it_runs_from_a_world_file_as_from_python(role, module, name, monkeypatch):
    if name in NEEDS:
        pytest.importorskip(NEEDS[name], reason="an extra")
    ours, theirs = pty.openpty()
    with os.fdopen(theirs) as terminal, os.fdopen(ours):
        monkeypatch.setattr(sys, "stdin", terminal)  # for the one that listens to keys
        keys = KEYS.get(name, {})
        told = ", ".join([f'use: "mjsim.algorithms.{module}:{name}"', *(f"{k}: {v}" for k, v in keys.items())])
        from_file = driven(world_for(name, **{role: "{" + told + "}"}))
        made = getattr(importlib.import_module(f"mjsim.algorithms.{module}"), name)(**keys)
        from_python = driven(world_for(name), {"scout": mjsim.Driver(**{role: made}, avoidance=True)})
    np.testing.assert_array_equal(from_file, from_python)
