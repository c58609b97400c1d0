"""What the profiles of the drives ask of their servos, held to ramps, to servos that lag, and to white noise."""

import math

import numpy as np
import pytest
from scipy.stats import chi2

from mjsim.geometry import Array
from mjsim.interface import Command, WheelCommand
from mjsim.sim.bases import RunningGear, gear_of
from mjsim.sim.bases.balancing import SetPointProfile
from mjsim.sim.bases.differential import DifferentialKinematics
from mjsim.world import BalancingDrive, DriveNoise, parse_world

DT = 0.04
LAGS = {"differential": 0.1, "skid_steer": 0.05, "omni3": 0.05, "mecanum": 0.05}
"""Drives without steering, and the time constants of their servos [s]."""


def gear(drive: str, *, seed: int = 1) -> RunningGear:
    world = parse_world(f"mjsim: 1\nrobots: [{{name: r, at: [0, 0], drive: {{{drive}}}}}]\n")
    return gear_of(world.robots[0], dt=DT, seed=seed, source=world.source, clock=lambda: 0.0)


def asked(base: RunningGear, ticks: int) -> tuple[Array, Array]:
    """Return the twists of the wheel speeds that servos are asked for, and the angles, (ticks, 3) and (ticks, n)."""
    count, rows = len(base.wheels), [tuple(base.profile.advance()) for _ in range(ticks)]
    twists = [base.motion(row[:count], (row[count], row[count]) if len(row) > count else (0.0, 0.0)) for row in rows]
    return np.array(twists), np.array([row[count:] for row in rows])


def followed(points: Array, lag: float) -> Array:
    """Return the value of first-order servos at the end of each tick, from rest."""
    now, values = np.zeros(points.shape[1]), []
    for point in points:
        now = point + (now - point) * math.exp(-DT / lag)
        values.append(now)
    return np.array(values)


def ramp(target: float, step: float, ticks: int) -> Array:
    return np.sign(target) * np.minimum(np.arange(1, ticks + 1) * step, abs(target))


@pytest.mark.parametrize("kind", LAGS)
def test_servos_that_lag_follow_the_ramps_of_both_accelerations_to_the_tick(kind):
    base = gear(f"type: {kind}, max_acceleration: 0.8, max_turn_acceleration_deg: 50, max_speed: 1")
    for forward, turn in ((0.4, -0.3), (-0.2, 0.5)):
        base.profile.command(Command(0.0))
        asked(base, 60)
        base.profile.command(Command(forward, turn=turn))
        expected = np.stack([ramp(forward, 0.8 * DT, 20), ramp(turn, math.radians(50) * DT, 20)], axis=-1)
        np.testing.assert_allclose(followed(asked(base, 20)[0], LAGS[kind])[:, ::2], expected, atol=1e-9)


@pytest.mark.parametrize("kind", ["omni3", "mecanum"])
def test_a_drive_that_goes_sideways_gathers_speed_along_the_way_that_it_is_told(kind):
    base = gear(f"type: {kind}, max_acceleration: 0.8, max_speed: 1")
    base.profile.command(Command(0.3, 0.4))
    values = followed(asked(base, 20)[0], 0.05)
    np.testing.assert_allclose(values[:, :2], ramp(0.5, 0.8 * DT, 20)[:, None] * [0.6, 0.8], atol=1e-9)
    base.profile.command(Command(-3.0, 0.4))
    most = values[-1] + followed(asked(base, 60)[0] - values[-1], 0.05)[-1]
    np.testing.assert_allclose(most, [-1.0, 0.4 / 3.0, 0.0], atol=1e-9)


@pytest.mark.parametrize("kind", [*LAGS, "ackermann", "tricycle"])
@pytest.mark.parametrize("twist", [(1.2, 1.2), (-1.2, 1.2), (0.9, -0.1), (0.3, 0.3)])
def test_a_twist_beyond_both_limits_is_scaled_until_it_keeps_both(kind, twist):
    base = gear(f"type: {kind}, max_speed: 0.5, max_turn_deg: 20")
    base.profile.command(Command(twist[0], turn=twist[1]))
    twists, angles = asked(base, 400)
    excess = max(1.0, abs(twist[0]) / 0.5, abs(twist[1]) / math.radians(20))
    np.testing.assert_allclose(twists[-1, [0, 2]], np.array(twist) / excess, atol=1e-9)
    if kind == "ackermann":
        # The front wheels, 0.33 m ahead of the rear axle, stand across lines from the centre of the turn on that axle.
        assert (1.0 / np.tan(angles[-1])).sum() == pytest.approx(2.0 * twist[0] / twist[1] / 0.33)


@pytest.mark.parametrize("kind", LAGS)
def test_wheel_speeds_are_the_twist_that_they_stand_for_and_are_limited_as_one(kind):
    told, wheeled = gear(f"type: {kind}, max_speed: 0.5"), gear(f"type: {kind}, max_speed: 0.5")
    forward, turn = np.random.default_rng(3).uniform(-1.0, 1.0, 2)
    columns = told.twist_from_wheels()
    speeds = np.linalg.pinv(columns) @ [forward, 0.0, turn]
    told.profile.command(Command(forward, turn=turn))
    wheeled.profile.command(WheelCommand(tuple(speeds)))
    twists = asked(told, 40)[0]
    np.testing.assert_allclose(asked(wheeled, 40)[0], twists, atol=1e-9)
    assert abs(twists[-1, 0]) <= 0.5 + 1e-9


NOISY = "noise: {speed: 0.02, turn: 0.03}"


@pytest.mark.parametrize("kind", [*LAGS, "ackermann", "tricycle", "tricycle, driven: front"])
def test_noise_of_each_direction_is_white_and_of_the_density_of_the_world_file(kind):
    base, count = gear(f"type: {kind}, {NOISY}"), 1500
    base.profile.command(Command(0.5))
    asked(base, 60)
    twists = asked(base, count)[0] - [0.5, 0.0, 0.0]
    sideways = kind in ("omni3", "mecanum")
    densities = [0.02, *([0.02] if sideways else []), 0.03]
    for errors, density in zip(twists[:, [0, 1, 2] if sideways else [0, 2]].T, densities, strict=True):
        # The steering of 1500 ticks is small: its cosine shortens the way by less than a percent.
        assert chi2.ppf(0.001, count) < np.sum(errors**2) * DT / density**2 < chi2.ppf(0.999, count)
        assert abs(errors.mean()) < 4.0 * density / math.sqrt(DT * count)
        assert abs(np.corrcoef(errors[1:], errors[:-1])[0, 1]) < 4.0 / math.sqrt(count)


def test_noise_may_change_while_it_drives():
    for kind in (*LAGS, "ackermann", "tricycle"):
        base = gear(f"type: {kind}, {NOISY}")
        base.profile.retune(DriveNoise(speed=0.0, turn=0.0))
        base.profile.command(Command(0.5))
        np.testing.assert_array_equal(np.diff(asked(base, 60)[0][-5:], axis=0), 0.0, err_msg=kind)


def middle(angles: Array) -> Array:
    """Return the angle of a wheel midway between two steered ones: cotangents are their distances from the centre."""
    left, right = np.tan(angles).T
    return np.asarray(np.arctan(2.0 * left * right / (left + right)))


def test_a_car_steers_and_gathers_speed_at_its_rates_and_its_wheels_turn_as_its_steering_asks():
    keys = "type: ackermann, max_acceleration: 1.5, max_speed: 2, max_steer_rate_deg: 60, wheelbase: 0.4, track: 0.3"
    base, target = gear(keys), math.atan(0.4 * 0.8)
    base.profile.command(Command(1.0, turn=0.8))
    twists, angles = asked(base, 40)
    np.testing.assert_allclose(followed(twists[:, :1], 0.05)[:, 0], ramp(1.0, 1.5 * DT, 40), atol=1e-9)
    steer = middle(angles)
    np.testing.assert_allclose(followed(steer[:, None], 0.05)[:, 0], ramp(target, math.radians(60) * DT, 40), atol=1e-9)
    np.testing.assert_allclose(twists[:, 2], twists[:, 0] * np.tan(steer) / 0.4, atol=1e-9)
    # Both wheels stand across the way to one centre.
    left, right = 0.4 / np.tan(angles[-1])
    assert left + 0.15 == pytest.approx(right - 0.15)


def test_a_car_that_stands_keeps_its_steering_and_wheel_speeds_are_a_twist():
    base = gear("type: ackermann, wheelbase: 0.4, track: 0.3, wheel_radius: 0.1")
    base.profile.command(WheelCommand((3.6, 4.4)))
    twists, angles = asked(base, 60)
    turn = 0.1 * 0.8 / 0.3
    np.testing.assert_allclose(twists[-1], [0.4, 0.0, turn], atol=1e-9)
    base.profile.command(Command(5e-4, turn=-1.0))
    twists, kept = asked(base, 60)
    np.testing.assert_allclose(twists[-1], 0.0, atol=1e-9)
    np.testing.assert_allclose(kept, np.broadcast_to(angles[-1], kept.shape), atol=1e-9)
    for speed in (0.5, -0.5):
        base.profile.command(Command(speed, turn=1.7))
        most = middle(asked(base, 80)[1][-1:])[0]
        assert math.degrees(most) == pytest.approx(math.copysign(24.0, speed)), "no sharper than its steering lets it"


@pytest.mark.parametrize(("driven", "place"), [("rear", -0.6), ("front", 0.6)])
def test_a_tricycle_turns_its_wheel_at_its_rate_and_goes_as_fast_as_that_is_aligned(driven, place):
    base = gear(f"type: tricycle, driven: {driven}, max_acceleration: 100, max_steer_rate_deg: 60, max_speed: 2")
    base.profile.command(Command(0.3, turn=0.4))
    target = math.atan(0.4 * place / 0.3)
    count = len(base.wheels)
    rows = np.array([base.profile.advance() for _ in range(40)])
    steer = followed(rows[:, count:], 0.05)[:, 0]
    np.testing.assert_allclose(steer, ramp(target, math.radians(60) * DT, 40), atol=1e-9)
    rim = followed(rows[:, :1] * 0.1, 0.05)[:, 0]
    np.testing.assert_allclose(rim, np.hypot(0.3, 0.24) * np.cos(target - steer), atol=1e-9)
    np.testing.assert_allclose(base.motion(rows[-1, :1], (steer[-1], steer[-1])), [0.3, 0.0, 0.4], atol=1e-9)


def test_a_tricycle_that_cannot_turn_as_sharply_keeps_its_speed_and_one_that_stands_its_steering():
    base = gear("type: tricycle, max_steer_deg: 30")
    for speed, turn in ((0.2, 1.5), (-0.2, 1.5), (-0.2, -1.5)):
        base.profile.command(Command(speed, turn=turn))
        last = asked(base, 80)[0][-1]
        sharpest = math.tan(math.radians(30)) * 0.2 / 0.6
        np.testing.assert_allclose(last, [speed, 0.0, math.copysign(sharpest, turn)], atol=1e-9)
    base.profile.command(Command(0.0))
    _, angles = asked(base, 60)
    np.testing.assert_allclose(np.diff(angles, axis=0), 0.0, atol=1e-9)
    base.profile.command(WheelCommand((1.0,)))
    twists, again = asked(base, 60)
    np.testing.assert_allclose(again[-1], angles[-1], atol=1e-9)
    assert twists[-1, 0] == pytest.approx(0.1 * math.cos(angles[-1, 0])), "a wheel speed leaves the steering alone"


def balancing(noise: DriveNoise, seed: int = 0) -> SetPointProfile:
    drive = BalancingDrive.model_validate(
        {"type": "balancing", "max_speed": 1, "max_acceleration": 0.8, "max_turn_acceleration_deg": 50, "noise": noise}
    )
    wheels = DifferentialKinematics(0.1, 0.5)
    return SetPointProfile(drive, kinematics=wheels, dt=DT, stream=np.random.default_rng(seed))


def test_set_points_of_a_balancing_base_ramp_at_any_rate_and_its_wheels_are_to_turn_by_their_sum():
    profile, step = balancing(DriveNoise()), 0.01
    profile.command(Command(-0.4, turn=0.5))
    wanted = np.array([(each.forward, each.turn) for each in (profile.wanted(step) for _ in range(101))])
    np.testing.assert_allclose(wanted[1:, 0], ramp(-0.4, 0.8 * step, 100), atol=1e-9)
    np.testing.assert_allclose(wanted[1:, 1], ramp(0.5, math.radians(50) * step, 100), atol=1e-9)
    forward, turn = wanted.sum(axis=0) * step
    np.testing.assert_allclose(profile.goal(), [(forward - 0.25 * turn) / 0.1, (forward + 0.25 * turn) / 0.1])
    profile.command(WheelCommand((4.0, 8.0)))
    profile.command(WheelCommand((4.0, 8.0)))
    after = [profile.wanted(step) for _ in range(400)][-1]
    assert (after.forward, after.turn) == pytest.approx((0.6, 0.8))


def test_noise_of_a_balancing_base_is_constant_within_a_tick_and_of_the_density_of_the_world_file():
    profile, count, rows = balancing(DriveNoise(speed=0.02, turn=0.03)), 1500, []
    for _ in range(count):
        assert profile.advance() == ()
        first, second = profile.wanted(0.004), profile.wanted(0.004)
        assert first == second
        rows.append((first.forward, first.turn))
    for errors, density in zip(np.array(rows).T, (0.02, 0.03), strict=True):
        assert chi2.ppf(0.001, count) < np.sum(errors**2) * DT / density**2 < chi2.ppf(0.999, count)
    assert not any(profile.goal()), "noise is no goal"
