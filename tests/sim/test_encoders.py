"""Wheel encoders: counts held to the hinges of MuJoCo, and to the odometry that is computed from them."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

import mjsim
from mjsim.env import GymEnvironment, Task
from mjsim.errors import WorldError
from mjsim.interface import Command, WheelTicks
from mjsim.record import export_csv, export_npz
from mjsim.sim import Simulation
from mjsim.world import parse_world

TICKS = 1000
RADIUS, TRACK = 0.1, 0.4


def world_of(keys: str = "", *, drive: str = f"wheel_radius: {RADIUS}, track: {TRACK}", odometry: str = ""):
    return parse_world(f"""
mjsim: 1
robots:
  - name: r
    at: [0, 0]
    drive: {{{drive}}}
    odometry: {{ticks: {TICKS}{odometry}}}
    sensors: [{{encoders: wheels{keys}}}]
""")


def hinges(sim: Simulation) -> np.ndarray:
    """Return how far MuJoCo has turned each driven wheel, shape (wheels,) [rad]."""
    return np.array([sim.data.joint(f"r/{wheel}").qpos[0] for wheel in sim.robots["r"].wheels])


def readings(sim: Simulation, ticks: int, *, turn: float = 0.4):
    """Drive an arc ahead, then back; yield the counts of each tick that has some."""
    for tick in range(ticks):
        ahead = 1.0 if tick < ticks // 2 else -0.6
        sim.apply("r", Command(0.5 * ahead, 0.0, turn))
        sim.step()
        seen = sim.sense("r")
        if seen.encoders:
            yield seen, seen.encoders["wheels"]


@pytest.mark.parametrize("drive", ["differential", "skid_steer", "ackermann", "tricycle", "omni3", "mecanum"])
def test_the_counts_are_the_whole_steps_that_the_wheels_have_turned(drive):
    with Simulation(world_of(drive=f"type: {drive}")) as sim:
        start = hinges(sim)
        assert sim.sense("r").encoders["wheels"].counts == (0,) * len(start)
        for seen, ticks in readings(sim, 40):
            turned = (hinges(sim) - start) * TICKS / math.tau
            assert ticks.stamp == seen.time
            assert ticks.resolution == TICKS
            # Sums of the steps of all ticks round otherwise than one product.
            assert np.all(np.abs(np.array(ticks.counts) + 0.5 - turned) < 0.5 + 1e-6)
        assert max(ticks.counts) > 100


def test_odometry_without_errors_is_computed_from_the_differences_of_the_counts():
    with Simulation(world_of(odometry=", noise: {distance: 0, turn: 0}")) as sim:
        before = sim.sense("r").encoders["wheels"]
        for seen, ticks in readings(sim, 60):
            left, right = ticks.rotations(before) * RADIUS
            turn = (right - left) / TRACK
            chord = (left + right) / 2 * np.sinc(turn / 2 / np.pi)
            told = seen.odometry
            assert told.turn == pytest.approx(turn, abs=1e-15)
            assert told.forward == pytest.approx(chord * math.cos(turn / 2), abs=1e-15)
            assert told.left == pytest.approx(chord * math.sin(turn / 2), abs=1e-15)
            before = ticks


def test_errors_of_the_odometry_are_not_in_the_counts():
    def counts(errors: str) -> list[tuple[int, ...]]:
        with Simulation(world_of(odometry=errors)) as sim:
            return [ticks.counts for _, ticks in readings(sim, 30)]

    assert counts(
        ", noise: {distance: 0.1, turn: 0.1}, scale: 1.2, track_error: 0.2, wheel_errors: [0, 0.1]"
    ) == counts("")


def test_a_narrow_counter_wraps_around_and_the_difference_is_right_across_it():
    with Simulation(world_of(", bits: 8")) as narrow, Simulation(world_of()) as wide:
        old, first = narrow.sense("r").encoders["wheels"], wide.sense("r").encoders["wheels"]
        for (_, ticks), (_, whole) in zip(readings(narrow, 80), readings(wide, 80), strict=True):
            assert all(-128 <= count < 128 for count in ticks.counts)
            assert [count % 256 for count in ticks.counts] == [count % 256 for count in whole.counts]
            assert ticks.since(old) == whole.since(first)
            old, first = ticks, whole
        assert max(map(abs, whole.counts)) > 128
    assert WheelTicks(0.0, (-128,), 10, 8).since(WheelTicks(0.0, (127,), 10, 8)) == (1,)


def test_readings_come_at_their_rate_and_as_late_as_asked_for():
    with Simulation(world_of(", rate_hz: 5, latency: 2")) as late, Simulation(world_of()) as now:
        counts = {round(seen.time, 6): ticks.counts for seen, ticks in readings(now, 40)}
        told = list(readings(late, 40))
        assert [round(seen.time, 6) for seen, _ in told] == [0.08, 0.28, 0.48, 0.68, 0.88, 1.08, 1.28, 1.48]
        assert [round(seen.time - ticks.stamp, 6) for seen, ticks in told] == [0.08] * 8
        assert [ticks.counts for _, ticks in told[1:]] == [counts[round(ticks.stamp, 6)] for _, ticks in told[1:]]
        assert late.robots["r"].sensors["wheels"].latency == 2


def test_a_robot_whose_wheels_do_not_count_in_steps_cannot_carry_encoders():
    text = "mjsim: 1\nrobots:\n  - name: r\n    at: [0, 0]\n    sensors:\n      - {encoders: wheels}\n"
    with pytest.raises(WorldError) as caught:
        parse_world(text, file="room.yaml")
    assert str(caught.value) == (
        "room.yaml:6:20: encoders need the counts per revolution of a wheel, such as odometry: {ticks: 2048}"
    )


def test_a_rate_that_does_not_divide_that_of_the_tick_is_refused():
    with pytest.raises(WorldError, match=r"rate_hz is 10 Hz; it must divide the 25 Hz of the tick"):
        world_of(", rate_hz: 10")


class Counting:
    """An estimator whose covariance tells of the counts that it was given."""

    def start(self, robot, catalogue, rng):
        self._given = []

    def update(self, seen):
        self._given += [ticks.counts for ticks in seen.encoders.values()]
        tail = sum(7 * left + right for left, right in self._given) % 1000
        return mjsim.Estimate(pose=mjsim.Pose(0.0, 0.0, 0.0), covariance=np.eye(3) * (1.0 + tail))


class Ahead:
    def start(self, robot, map, rng):
        pass

    def command(self, seen, belief):
        return Command(0.4, 0.0, 0.3)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "run.mcap"
    with Simulation(world_of(", rate_hz: 12.5, bits: 8")) as sim:
        return mjsim.run(
            sim, drivers={"r": mjsim.Driver(estimator=Counting(), navigator=Ahead())}, seconds=2, record=path
        )


def test_counts_are_recorded_exactly_and_left_out_where_there_are_none(run):
    with Simulation(run.world, seed=run.seed) as sim:
        given = []
        for _ in run.time:
            given.append(sim.sense("r").encoders)
            sim.apply("r", Command(0.4, 0.0, 0.3))
            sim.step()
    assert [dict(seen.encoders) for seen in run.observations("r")] == given
    messages = [json.loads(data) for data in run.messages("/r/observation")]
    assert ["encoders" in message for message in messages[:4]] == [True, False, True, False]


def test_a_replay_is_given_the_same_counts(run):
    again = mjsim.replay(run, robot="r", estimator=Counting())
    np.testing.assert_array_equal(again.robots["r"].covariance, run.robots["r"].covariance)
    assert len(set(run.robots["r"].covariance[:, 0, 0])) > 10


def test_counts_are_exported_as_a_table_and_as_arrays(run, tmp_path):
    given = [seen for seen in run.observations("r") if seen.encoders]
    export_csv(run, tmp_path)
    header, *rows = (tmp_path / "r_encoders_wheels.csv").read_text().splitlines()
    assert header == "time,stamp,count_0,count_1"
    told = [(seen.time, seen.encoders["wheels"].stamp, *seen.encoders["wheels"].counts) for seen in given]
    assert [tuple(map(float, row.split(","))) for row in rows] == told
    with np.load(export_npz(run, tmp_path / "run.npz")) as arrays:
        assert arrays["r/encoders_wheels/counts"].dtype == np.int64
        np.testing.assert_array_equal(arrays["r/encoders_wheels/counts"], [counts for _, _, *counts in told])
        assert arrays["r/encoders_wheels/resolution"] == TICKS


def test_an_environment_observes_the_newest_counts():
    env = GymEnvironment(Task(world=world_of(), robots="r", observations=["wheels"], seconds=1))
    env.reset(seed=1)
    for _ in range(5):
        seen, *_ = env.step(np.array([1.0, 0.0], dtype=np.float32))
    assert env.observation_space["wheels"].shape == (2,)
    assert env.observation_space.contains(seen)
    assert seen["wheels"].min() > 0
    env.close()


def test_counters_of_other_widths_and_lengths_are_refused():
    with pytest.raises(WorldError, match="bits is 64"):
        world_of(", bits: 64")
    one = WheelTicks(0.0, (1, 2), 100)
    with pytest.raises(ValueError, match="zip"):
        one.since(replace(one, counts=(1,)))
