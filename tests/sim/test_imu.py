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
from tests.sim.devices import device_of, moved

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


def test_on_a_circle_it_feels_the_centripetal_acceleration_of_where_it_is():
    speed, turn = 0.5, 1.0
    for at in ([0, 0, 0.1], [0.2, 0.1, 0.1]):
        acceleration, turns = columns(drive(f"at: {at}", Command(speed, turn=turn), 6.0)[0])
        late_turn = turns[-250:, 2].mean()
        # v^2/r towards the middle is v w to the left; an arm adds -w^2 times itself.
        expected = [-(late_turn**2) * at[0], speed * late_turn - late_turn**2 * at[1]]
        np.testing.assert_allclose(acceleration[-250:, :2].mean(axis=0), expected, atol=0.01)
        assert late_turn == pytest.approx(turn, rel=0.02)


def imu(keys: str) -> Simulation:
    return Simulation(parse_world(f"mjsim: 1\nrobots: [{{name: r, at: [0, 0], sensors: [{{imu: imu, {keys}}}]}}]\n"))


@pytest.fixture(scope="module")
def mounted():
    with imu("rate_hz: 250, at: [0.3, -0.2, 0.5], yaw_deg: 40, pitch_deg: 25") as sim:
        yield sim


SENSOR = Rotation.from_euler("ZY", [40, -25], degrees=True)
ARM = np.array([0.3, -0.2, 0.5])


def test_a_body_that_turns_and_gains_speed_is_felt_where_the_sensor_sits_and_along_its_axes(mounted):
    rng, step = np.random.default_rng(8), mounted.model.opt.timestep
    for _ in range(6):
        w, start, change, first = (*rng.uniform(-2.0, 2.0, (3, 3)), Rotation.random(rng=rng))
        batch, each, pulled = device_of(mounted), device_of(mounted), []
        for device in (batch, each):
            for number in range(9):
                time = number * step
                moved(mounted, rotation=first * Rotation.from_rotvec(w * time), velocity=start + change * time, turn=w)
                device.after_step()
                if device is each:
                    pulled += device.pull(time)
        acceleration, turn = columns(batch.take(8 * step)[1:])
        halfway = first * Rotation.from_rotvec(np.outer((np.arange(8) + 0.5) * step, w))
        held = halfway.inv().apply(change - [0.0, 0.0, -GRAVITY])
        # Within a step of 8 mrad, the mean of both orientations is short by 1e-5.
        np.testing.assert_allclose(acceleration, SENSOR.inv().apply(held + np.cross(w, np.cross(w, ARM))), atol=1e-3)
        np.testing.assert_allclose(turn, np.broadcast_to(SENSOR.inv().apply(w), turn.shape), atol=1e-12)
        at_once = each.take(8 * step)
        assert at_once == tuple(pulled), "what was pulled comes again at the tick, and nothing else"
        for values, others in zip(columns(pulled[1:]), (acceleration, turn), strict=True):
            np.testing.assert_allclose(values, others, atol=1e-9)


def test_a_turn_that_changes_is_that_at_the_end_of_each_step_and_a_slower_sensor_takes_their_mean():
    with imu("rate_hz: 62.5") as sim:
        device, turns = device_of(sim), np.random.default_rng(2).uniform(-1.0, 1.0, (11, 3))
        for turn in turns:
            moved(sim, rotation=Rotation.identity(), velocity=np.zeros(3), turn=turn)
            device.after_step()
        readings = device.take(0.044)
        np.testing.assert_allclose(columns(readings)[1], turns[:8].reshape(2, 4, 3).mean(axis=1), atol=1e-12)
        assert [reading.stamp for reading in readings] == pytest.approx([0.016, 0.032])
        device.after_step()
        (last,) = device.take(0.048)
        np.testing.assert_allclose(last.turn, turns[[8, 9, 10, 10]].mean(axis=0), atol=1e-12)
        assert last.stamp == pytest.approx(0.048)


def test_held_at_rest_it_feels_what_holds_it_up_and_no_turn(mounted):
    moved(mounted, rotation=Rotation.from_euler("x", 0.2), velocity=np.ones(3), turn=np.ones(3))
    reading = device_of(mounted).at_rest(3.0)
    up = SENSOR.inv().apply(Rotation.from_euler("x", -0.2).apply([0.0, 0.0, GRAVITY]))
    np.testing.assert_allclose(reading.acceleration, up)
    assert (reading.stamp, reading.turn.tolist()) == (3.0, [0.0, 0.0, 0.0])


def errors_of(keys: str, count: int, *, pull: bool = False, seed: int = 0) -> tuple[Array, Array]:
    """Return the errors of acceleration and turn of a sensor at rest."""
    with imu(keys) as sim:
        device, readings = device_of(sim, seed=seed), []
        for number in range(count):
            device.after_step()
            if pull:
                readings += device.pull(0.004 * number)
        acceleration, turn = columns(readings or [*device.take(0.0)])
    return acceleration - [0.0, 0.0, GRAVITY], turn


@pytest.mark.parametrize("pull", [False, True])
def test_white_noise_and_walk_are_as_the_data_sheet_says(pull):
    errors = errors_of("rate_hz: 250, noise: {acceleration: 0.05, turn: 0.01}", 1500, pull=pull)
    for values, sigma in zip(errors, (0.05, 0.01), strict=True):
        # 4500 numbers: the standard deviation is known to 1 %.
        assert values.std() == pytest.approx(sigma, rel=0.045)
        assert abs(values.mean()) < 4.0 * sigma / math.sqrt(4500)
        assert abs(np.corrcoef(values[1:, 0], values[:-1, 0])[0, 1]) < 0.11
    walks = errors_of("rate_hz: 250, walk: {acceleration: 0.1, turn: 0.02}", 1500, pull=pull)
    for values, density in zip(walks, (0.1, 0.02), strict=True):
        steps = np.diff(values, axis=0)
        assert steps.std() == pytest.approx(density * math.sqrt(0.004), rel=0.045)
        assert abs(np.corrcoef(steps[1:, 0], steps[:-1, 0])[0, 1]) < 0.11


def test_readings_are_the_same_however_often_they_are_taken():
    told = []
    with imu("rate_hz: 125, noise: {acceleration: 0.1, turn: 0.1}, walk: {acceleration: 0.1, turn: 0.1}") as sim:
        for every in (1, 3, 24):
            device, readings = device_of(sim), []
            for number in range(1, 25):
                device.after_step()
                if number % every == 0:
                    readings += device.take(0.004 * number)
            told.append(np.hstack([[[reading.stamp] for reading in readings], *columns(readings)]))
    assert len(told[0]) == 12
    for each in told[1:]:
        np.testing.assert_allclose(each, told[0], atol=1e-9)


def test_the_walk_of_a_second_does_not_depend_on_the_rate():
    for rate in (250, 12.5):
        ends = []
        with imu(f"rate_hz: {rate}, walk: {{acceleration: 0.1, turn: 0.02}}") as sim:
            for seed in range(60):
                device = device_of(sim, seed=seed)
                for _ in range(250):
                    device.after_step()
                last = device.take(1.0)[-1]
                ends.append((last.acceleration - [0.0, 0.0, GRAVITY], last.turn))
        # 180 values: the standard deviation is known to 5.3 %.
        np.testing.assert_allclose(np.std(ends, axis=(0, 2)), [0.1, 0.02], rtol=0.21)


def test_the_bias_is_constant_in_a_run_and_another_with_another_seed():
    with imu("bias: {acceleration: 0.3, turn: 0.02}") as sim:
        biases = []
        for seed in range(60):
            device = device_of(sim, seed=seed)
            for _ in range(8):
                device.after_step()
            acceleration, turn = columns([*device.take(0.0), device.at_rest(0.0)])
            felt = np.hstack([acceleration - [0.0, 0.0, GRAVITY], turn])
            np.testing.assert_allclose(felt, np.broadcast_to(felt[0], felt.shape), atol=1e-9)
            biases.append(felt[0])
    # 180 values: the standard deviation is known to 5.3 %.
    assert np.std(np.array(biases)[:, :3]) == pytest.approx(0.3, rel=0.21)
    assert np.std(np.array(biases)[:, 3:]) == pytest.approx(0.02, rel=0.21)


def test_what_is_beyond_the_range_reads_as_its_end():
    acceleration, turn = columns(drive("range: {acceleration: 5, turn: 0.3}", Command(turn=1.0), 2.0)[0])
    assert acceleration[:, 2] == pytest.approx(5.0)
    assert turn[-100:, 2] == pytest.approx(0.3)
    with imu("rate_hz: 250, range: {acceleration: 5, turn: 0.3}") as sim:
        moved(sim, rotation=Rotation.identity(), velocity=np.zeros(3), turn=np.array([1.0, -1.0, 0.1]))
        alone, one, batch = (device_of(sim) for _ in range(3))
        for device in (alone, one, batch, batch):
            device.after_step()
        for reading in (*alone.pull(0.004), *one.take(0.004), *batch.take(0.008)):
            np.testing.assert_allclose(reading.turn, [0.3, -0.3, 0.1])
            assert max(abs(reading.acceleration)) == 5.0


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
