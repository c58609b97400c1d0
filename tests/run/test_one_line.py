"""A world runs in one line of Python, with the spelling of settings that the command line has."""

from pathlib import Path

import numpy as np
import pytest

import mjsim
from mjsim.errors import UsageError, WorldError
from mjsim.world import with_settings

ROOM = """
mjsim: 1
name: room
robots: [{name: r, preset: pioneer3dx, at: [1, 1]}]
run:
  {seconds: 0.2, seed: 3, drivers: {r: {navigator: {use: "mjsim.algorithms.constant:ConstantCommand", forward: 0.3}}}}
"""


@pytest.fixture
def room(tmp_path):
    (tmp_path / "room.yaml").write_text(ROOM)
    return tmp_path / "room.yaml"


def test_a_simulation_and_a_run_take_a_file_a_world_or_a_simulation(room):
    recordings = []
    for given in (room, str(room), mjsim.load_world(room), mjsim.Simulation(room), mjsim.Simulation(str(room))):
        recordings.append(mjsim.run(given))
    assert all(np.array_equal(each.qpos, recordings[0].qpos) for each in recordings)
    assert [each.seed for each in recordings] == [3] * 5
    assert len(recordings[0].time) == 5
    assert recordings[0].qvel[-1].any()  # The world's own driver moved it.


def test_a_run_of_a_world_takes_a_seed_and_one_of_a_simulation_has_its_own(room):
    assert mjsim.run(room, seed=7).seed == 7
    with mjsim.Simulation(room, seed=5) as sim, pytest.raises(UsageError, match="a simulation already has its seed"):
        mjsim.run(sim, seed=7)


SETTINGS = {"run.seconds": 5, "robots.r.at": [2, 1.5], "robots.r.odometry.scale": 1.1, "name": "hall"}
TEXTS = ["run.seconds=5", "robots.r.at=[2, 1.5]", "robots.r.odometry.scale=1.1", "name=hall"]


def test_settings_are_those_of_the_command_line(room):
    world = mjsim.load_world(room, settings=SETTINGS)
    assert world == mjsim.load_world(room, settings=TEXTS) == with_settings(mjsim.load_world(room), TEXTS)
    assert (world.run.seconds, world.robots[0].at, world.name) == (5.0, (2.0, 1.5), "hall")
    assert mjsim.load_world(str(room)).run.seconds == 0.2


@pytest.mark.parametrize(
    ("settings", "line"),
    [
        ({"run.second": 5}, "did you mean 'seconds'"),
        ({"run.seconds": -1}, "--set run.seconds=-1"),
        ({"run.seconds": Path()}, "--set run.seconds: a value of type PosixPath cannot be in a world file"),
        ({"run.seconds": np.float64(np.nan)}, "--set run.seconds"),
        (["run.seconds"], "write it as KEY=VALUE"),
    ],
)
def test_a_wrong_setting_is_one_line(room, settings, line):
    with pytest.raises(UsageError, match=line) as caught:
        mjsim.load_world(room, settings=settings)
    assert "\n" not in str(caught.value)


def test_what_cannot_be_run_is_told_as_on_the_command_line(tmp_path, room):
    with pytest.raises(UsageError, match=r"no file 'none\.yaml'"):
        mjsim.Simulation("none.yaml")
    room.write_text(ROOM.replace("name: room", "nam: room"))
    with pytest.raises(WorldError, match=r"room\.yaml:3:1: unknown key 'nam'"):
        mjsim.run(room)
    room.write_text(ROOM.replace("mjsim.algorithms.constant:ConstantCommand", "none.py:None1"))
    with pytest.raises(WorldError, match=r"no file 'none\.py' beside the world file"):
        mjsim.run(room)
