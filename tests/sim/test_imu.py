"""Readings of an IMU, held to closed forms of how the robot moves."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mjsim.errors import WorldError
from mjsim.geometry import Array, wrap_angle
from mjsim.interface import Command, ImuReading
from mjsim.sim import Simulation
from mjsim.world import parse_world

GRAVITY = 9.81


def drive(keys: str, command: Command, seconds: float, *, robot: str = "") -> tuple[list[ImuReading], Simulation]:
    """Return the readings of an IMU while the robot follows a command from rest, and the simulation at the end."""
    sim = Simulation(
        parse_world(f"mjsim: 1\nrobots: [{{name: r, at: [0, 0], {robot} sensors: [{{imu: imu, {keys}}}]}}]\n")
    )
    readings: list[ImuReading] = []
    for _ in range(round(seconds / sim.dt)):
        sim.apply("r", command)
        sim.step()
        readings += sim.sense("r").imu
    return readings, sim


def columns(readings: list[ImuReading]) -> tuple[Array, Array]:
    return np.array([each.acceleration for each in readings]), np.array([each.turn for each in readings])


def test_at_rest_it_feels_what_holds_it_up_in_its_own_frame():
    for keys, up in (
        ("at: [0.1, 0.1, 0.2]", (0, 0, 1)),
        ("pitch_deg: 30", (math.sin(math.pi / 6), 0, math.cos(math.pi / 6))),
        ("pitch_deg: 30, yaw_deg: 90", (math.sin(math.pi / 6), 0, math.cos(math.pi / 6))),
    ):
        acceleration, turn = columns(drive(keys, Command(), 2.0)[0])
        # The robot has settled on its wheels after a second.
        np.testing.assert_allclose(acceleration[125:].mean(axis=0), GRAVITY * np.array(up), atol=0.005)
        np.testing.assert_allclose(turn[125:], 0.0, atol=1e-4)


def test_stamps_are_whole_steps_and_a_batch_comes_with_each_tick():
    sim = Simulation(
        parse_world(
            "mjsim: 1\nrobots: [{name: r, at: [0, 0], sensors: [{imu: a, rate_hz: 125}, {imu: b, rate_hz: 62.5}]}]\n"
        )
    )
    assert sim.sense("r").imu == ()
    stamps: dict[str, list[float]] = {"a": [], "b": []}
    for _ in range(10):
        sim.step()
        batch = sim.sense("r").imu
        for reading in batch:
            assert sim.time - sim.dt < reading.stamp <= sim.time + 1e-12
            stamps[reading.name].append(reading.stamp)
    np.testing.assert_allclose(stamps["a"], 0.008 * np.arange(1, 51), atol=1e-12)
    np.testing.assert_allclose(stamps["b"], 0.016 * np.arange(1, 26), atol=1e-12)


@pytest.mark.slow
def test_turns_add_up_to_the_heading_and_accelerations_to_the_speed():
    readings, sim = drive("rate_hz: 250, at: [0, 0, 0], yaw_deg: 35", Command(0.5, turn=0.6), 4.0)
    acceleration, turn = columns(readings)
    assert wrap_angle(turn[:, 2].sum() * 0.004 - sim.truth("r").heading) == pytest.approx(0.0, abs=1e-4)
    # Dead reckoning as strapdown systems do it: orientation first, then velocity, gravity taken off.
    world_from_sensor, velocity = Rotation.from_euler("z", 35, degrees=True), np.zeros(3)
    for force, rate in zip(acceleration, turn, strict=True):
        halfway = world_from_sensor * Rotation.from_rotvec(rate * 0.002)
        velocity += 0.004 * (halfway.apply(force) - [0, 0, GRAVITY])
        world_from_sensor *= Rotation.from_rotvec(rate * 0.004)
    np.testing.assert_allclose(velocity, sim.data.qvel[:3], atol=2e-3)


@pytest.mark.slow
def test_on_a_circle_it_feels_the_centripetal_acceleration_of_where_it_is():
    speed, turn = 0.5, 1.0
    for at in ([0, 0, 0.1], [0.2, 0.1, 0.1]):
        acceleration, turns = columns(drive(f"at: {at}", Command(speed, turn=turn), 6.0)[0])
        late_turn = turns[-250:, 2].mean()
        # v^2/r towards the middle is v w to the left; an arm adds -w^2 times itself.
        expected = [-(late_turn**2) * at[0], speed * late_turn - late_turn**2 * at[1]]
        np.testing.assert_allclose(acceleration[-250:, :2].mean(axis=0), expected, atol=0.01)
        assert late_turn == pytest.approx(turn, rel=0.02)


@pytest.mark.slow
def test_white_noise_bias_and_walk_are_as_the_data_sheet_says():
    quiet = columns(drive("rate_hz: 250", Command(), 8.0)[0])
    noisy = columns(drive("rate_hz: 250, noise: {acceleration: 0.05, turn: 0.01}", Command(), 8.0)[0])
    errors = [(a - b)[250:] for a, b in zip(noisy, quiet, strict=True)]
    # 1750 readings of three axes: the standard deviation is known to 1 %.
    assert errors[0].std() == pytest.approx(0.05, rel=0.04)
    assert errors[1].std() == pytest.approx(0.01, rel=0.04)
    walking = columns(drive("rate_hz: 250, walk: {acceleration: 0.1, turn: 0.02}", Command(), 8.0)[0])
    for told, exact, density in zip(walking, quiet, (0.1, 0.02), strict=True):
        steps = np.diff((told - exact)[250:], axis=0)
        assert steps.std() == pytest.approx(density * math.sqrt(0.004), rel=0.04)


@pytest.mark.slow
def test_the_bias_is_constant_in_a_run_and_another_with_another_seed():
    world = "mjsim: 1\nrobots: [{name: r, at: [0, 0], sensors: [{imu: imu, bias: {acceleration: 0.3, turn: 0.02}}]}]\n"
    biases = []
    for seed in range(40):
        sim = Simulation(parse_world(world), seed=seed)
        for _ in range(2):
            sim.step()
        turns = np.array([reading.turn for reading in sim.sense("r").imu])
        biases.append(turns.mean(axis=0))
        np.testing.assert_allclose(turns - turns[0], 0.0, atol=5e-3)
    # 120 values: the standard deviation is known to 6.5 %.
    assert np.std(biases) == pytest.approx(0.02, rel=0.26)


def test_what_is_beyond_the_range_reads_as_its_end():
    acceleration, turn = columns(drive("range: {acceleration: 5, turn: 0.3}", Command(turn=1.0), 2.0)[0])
    assert acceleration[:, 2] == pytest.approx(5.0)
    assert turn[-100:, 2] == pytest.approx(0.3)


def test_readings_do_not_change_when_ticks_pass_unasked_and_come_late_by_whole_ticks():
    keys = "noise: {acceleration: 0.1, turn: 0.1}, walk: {turn: 0.1}"
    world = "mjsim: 1\nrobots: [{{name: r, at: [0, 0], sensors: [{{imu: imu, {}}}]}}]\n"
    runs = []
    for more, every in (("", 1), ("", 3), (", latency: 2", 1)):
        sim, told = Simulation(parse_world(world.format(keys + more))), {}
        for tick in range(12):
            if tick % every == 0:
                told[tick] = [(r.stamp, *r.acceleration, *r.turn) for r in sim.sense("r").imu]
            sim.step()
        runs.append(told)
    always, seldom, late = runs
    assert all(always[tick] == batch for tick, batch in seldom.items())
    assert all(always[tick] == late[tick + 2] for tick in range(10))


def test_a_rate_that_is_no_whole_number_of_steps_is_refused_with_the_nearest_that_is():
    with pytest.raises(WorldError, match=r"rate_hz is 100 Hz; .* the nearest rate is (125|83.3333) Hz"):
        parse_world("mjsim: 1\nrobots: [{name: r, at: [0, 0], sensors: [{imu: imu, rate_hz: 100}]}]\n")
