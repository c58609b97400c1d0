"""A robot that falls over is an event of its recording and a figure of its statistics, once a fall."""

import math

import mjsim
from mjsim.geometry import Pose3
from mjsim.run.loop import Falls

LEANS = """
mjsim: 1
robots:
  - {name: joe, preset: balancer, at: [0, 0], lean_deg: %s}
  - {name: rover, preset: pioneer3dx, at: [0, 9]}
run: {seconds: 2}
"""


def leaning(degrees: float) -> Pose3:
    half = math.radians(degrees) / 2
    return Pose3(0.0, 0.0, 0.1, 0.0, math.sin(half), 0.0, math.cos(half))


def test_a_robot_that_cannot_be_caught_falls_once(tmp_path):
    with mjsim.Simulation(mjsim.parse_world(LEANS % 40)) as sim:
        recording = mjsim.run(sim, record=tmp_path / "run.mcap")
    (fall,) = recording.robots["joe"].events
    assert (fall.kind, fall.text) == ("fall", "joe fell over")
    assert 0.0 < fall.time < 1.0
    figures = mjsim.statistics(recording)
    assert (figures["joe"]["falls"], figures["rover"]["falls"]) == (1, 0)


def test_one_that_stands_does_not_fall():
    with mjsim.Simulation(mjsim.parse_world(LEANS % 10)) as sim:
        assert mjsim.statistics(mjsim.run(sim))["joe"]["falls"] == 0


def test_a_fall_ends_when_the_robot_stands_again():
    falls = Falls()
    found = [falls._falls("joe", leaning(degrees)) for degrees in (0, 44, 46, 60, 30, 80, 19, 50, -170)]
    assert found == [False, False, True, False, False, False, False, True, False]
