"""The ways on which joints of mechanisms are led."""

import math

import numpy as np
import pytest

from mjsim.mechanics import Constant, Ramp, Sine
from mjsim.sim.mechanisms.followers import MAX_JOINT_SPEED, MIN_DURATION, Blend, Course
from mjsim.world import Motion


def ways_of(blend):
    """Return value, speed and acceleration at 300 times, shape (300, 3)."""
    return np.array([blend.at(time) for time in np.linspace(1.0, 1.0 + blend.seconds, 300)])


def test_a_joint_comes_from_where_it_was_without_a_jump_and_rests_at_its_goal():
    rng = np.random.default_rng(0)
    for value, speed, change in rng.uniform([-3.0, -4.0, -9.0], [3.0, 4.0, 9.0], (6, 3)):
        blend = Blend.to(0.0, begin=1.0, value=value, speed=speed, change=change)
        ways = ways_of(blend)
        np.testing.assert_allclose(ways[0], [value, speed, change], atol=1e-9)
        np.testing.assert_allclose(ways[-1], 0.0, atol=1e-9)
        # Speeds are the slopes of the places, by central differences.
        slopes = np.gradient(ways[:, 0], blend.seconds / 299)
        np.testing.assert_allclose(slopes[1:-1], ways[1:-1, 1], atol=2e-2)


def test_a_joint_that_moves_away_from_its_goal_turns_round_no_faster_than_it_was_or_a_radian_a_second():
    rng = np.random.default_rng(1)
    for value, speed in rng.uniform([0.01, 0.0], [3.0, 4.0], (6, 2)):
        ways = ways_of(Blend.to(0.0, begin=1.0, value=value, speed=speed, change=0.0))
        # Its speed is looked at in 101 places; between them it may be greater by less than a thousandth.
        assert np.abs(ways[:, 1]).max() < 1.001 * max(MAX_JOINT_SPEED, speed)


@pytest.mark.parametrize(("way", "far"), [(3.0, 0.0), (-3.0, 0.0), (0.01, 0.0), (0.5, 4.0)])
def test_from_rest_a_joint_comes_up_to_its_largest_speed_or_takes_the_least_time(way, far):
    blend = Blend.to(way, begin=1.0, value=0.0, speed=0.0, change=0.0, far=far)
    # The quintic from rest is fastest in its middle, at 15/8 of its mean.
    assert blend.seconds == pytest.approx(max(MIN_DURATION, 15 / 8 * max(abs(way), far)))
    assert np.abs(ways_of(blend)[:, 1]).max() == pytest.approx(15 / 8 * abs(way) / blend.seconds, rel=1e-3)
    assert blend.fastest() == pytest.approx(15 / 8 * abs(way) / blend.seconds)
    assert blend.at(1.0 + blend.seconds + 5.0) == (pytest.approx(way), 0.0, 0.0)


H = 0.004
SINE = Sine(amplitude=0.7, frequency=0.4, phase=0.3, offset=0.1)


def course(kind, signal, start, *, step=H):
    return Course(Motion(number=0, kind=kind, column=0, ends=None, signal=signal, name="q"), step=step, start=start)


def goals(made, first, last):
    return np.array([made.goal(n) for n in range(first, last)])


def test_a_joint_is_on_its_signal_at_each_step_with_the_differences_of_the_steps():
    made = course("angle", SINE, float(SINE.value(0.0)))
    for n in range(60):
        before, now, after = SINE.value(np.array([n - 1, n, n + 1]) * H)
        assert made.goal(n) == pytest.approx(now)
        # Before the start the motion is that of its speed and acceleration there.
        assert made.speed(n) == pytest.approx((now - before) / H, abs=1e-4)
        assert made.acceleration(n) == pytest.approx((after - 2 * now + before) / H**2, abs=2e-2)
        assert made.middle_speed(n) == pytest.approx((after - before) / (2 * H), abs=1e-4)
    np.testing.assert_allclose(made.slope(0.5), (SINE.rate(0.5), SINE.second(0.5)))


def test_a_speed_is_integrated_from_where_the_joint_is():
    made = course("velocity", SINE, 2.0)
    times = np.arange(500) * H
    w, phase = math.tau * 0.4, 0.3
    exact = 2.0 + 0.1 * times - 0.7 / w * (np.cos(w * times + phase) - math.cos(phase))
    # The trapezoid of a step errs with its square.
    np.testing.assert_allclose(goals(made, 0, 500), exact, atol=1e-5)
    np.testing.assert_allclose(made.slope(0.5), (SINE.value(0.5), SINE.rate(0.5)))


@pytest.mark.parametrize("kind", ["angle", "velocity"])
def test_a_joint_that_is_led_goes_to_its_goal_smoothly_and_back_to_its_signal(kind):
    step = 0.02
    made = course(kind, SINE, float(SINE.value(0.0)), step=step)
    way = [made.goal(n) for n in range(51)]
    speed = made.slope(50 * step)[0]
    made.lead(-1.0, 50)
    assert made.slope(50 * step)[0] == pytest.approx(speed)
    way += [made.goal(n) for n in range(51, 400)]
    assert way[-1] == pytest.approx(-1.0)
    made.release(399, whole=0.0)
    assert made.goal(399) == pytest.approx(-1.0)
    way += [made.goal(n) for n in range(400, 800)]
    # Without a jump: a step in speed of 0.3 rad/s would be an acceleration of 15.
    assert np.abs(np.diff(way, 2)).max() / step**2 < 12.0
    times = np.arange(790, 800) * step
    if kind == "angle":
        np.testing.assert_allclose(way[790:], SINE.value(times), atol=1e-9)
    else:
        np.testing.assert_allclose(np.diff(way[789:]) / step, SINE.value(times - step / 2), atol=1e-3)


@pytest.mark.parametrize(
    ("goal", "whole", "offset"), [(12.0, math.tau, 2 * math.tau), (12.0, 0.0, 0.0), (-4.0, math.tau, -math.tau)]
)
def test_a_joint_without_limits_returns_by_what_is_left_of_whole_turns(goal, whole, offset):
    made = course("angle", Constant(level=0.5), 0.5, step=0.5)
    made.lead(goal, 0)
    assert made.goal(60) == pytest.approx(goal)
    told = made.end(60, whole=whole)
    made.release(60, whole=whole)
    assert made.goal(120) == pytest.approx(0.5 + offset) == told


def test_what_was_not_led_has_nothing_to_return_from():
    for kind in ("angle", "velocity"):
        made = course(kind, Ramp(before=0.0, slope=1.0, start=0.0, seconds=9.0), 0.0)
        assert made.end(10, whole=0.0) is None
        before = made.goal(10)
        made.release(10, whole=0.0)
        assert made.goal(10) == before
        made.lead(1.0, 10)
        assert (made.end(20, whole=0.0) is None) == (kind == "velocity")
