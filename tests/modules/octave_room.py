"""A room whose robot has functions in .m files, and what tests of them ask."""

import shutil
from pathlib import Path

import pytest

import mjsim

needs_octave = pytest.mark.skipif(
    not (shutil.which("octave-cli") or shutil.which("octave")),
    reason="no Octave here; type: sudo apt-get install --no-install-recommends octave",
)
ROOM = """
mjsim: 1
name: room
beacons: [{name: lion, at: [2, 0.5]}, {name: bear-2, at: [2, -0.5]}]
robots:
  - name: scout
    at: [0, 0]
    odometry: {noise: {distance: 0, turn: 0}}
    sensors:
      - {beacons: ring, range: [0.2, 8], fov_deg: 360, rate_hz: 25}
      - {lidar: 2nd-scan, at: [0, 0, 0.35], beams: 8, fov_deg: 360, rate_hz: 12.5}
run: {seconds: 0.6, map: known, drivers: {scout: {DRIVERS}}}
"""
HEADS = {
    "estimator": "[est, state] = mine(obs, robot, state)",
    "observer": "[z, state] = mine(obs, robot, state)",
    "navigator": "[cmd, state] = mine(obs, est, robot, state)",
    "avoidance": "[cmd, state] = mine(cmd, obs, robot, state)",
}
GOOD = {
    "estimator": "est.pose = robot.prior; est.covariance = eye(3);",
    "observer": "z.id = []; z.range = []; z.bearing = []; z.R = [];",
    "navigator": "cmd.forward = 0.1;",
    "avoidance": "",
}


def written(role: str, body: str) -> str:
    """Return a function that answers well until 0.20 s, and then does as `body` says, from line 4 on."""
    return f"function {HEADS[role]}\n% MINE  A test.\n{GOOD[role]}\nif obs.time > 0.18\n{body}\nend\nend\n"


def world_of(folder: Path, drivers: str, text: str | None = None) -> mjsim.World:
    """Return a world of a folder whose robot has these modules, and 'mine.m' with this text."""
    if text is not None:
        (folder / "mine.m").write_text(text)
    (folder / "room.yaml").write_text(ROOM.replace("DRIVERS", drivers))
    return mjsim.load_world(folder / "room.yaml")


def fault_of(world: mjsim.World, record: Path) -> str:
    """Return the line that ends a run."""
    with mjsim.Simulation(world) as sim, pytest.raises(mjsim.ModuleFault) as caught:
        mjsim.run(sim, record=record)
    assert str(caught.value).isprintable()
    return str(caught.value)
