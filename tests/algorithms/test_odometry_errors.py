"""Systematic errors of odometry: their prior by its noise, and how the motion of a tick depends on them."""

import math

import numpy as np
import pytest

from mjsim.algorithms.estimation.odometry_errors import BEGIN, DELAY, LATEST, OdometryErrors
from mjsim.interface import Odometry

NOISE = np.diag([0.02, 0.01, 0.03])


def moves(count: int) -> list[Odometry]:
    return [Odometry(*each, NOISE) for each in np.random.default_rng(1).uniform(-0.1, 0.1, (count, 3)).tolist()]


def test_their_prior_is_the_noise_over_the_way_by_the_length_at_which_both_are_equal():
    model, gained = OdometryErrors(50.0), np.zeros(4)
    way = turns = 0.0
    told = moves(30)
    for moved in told:
        gained += model.step(moved, NOISE, 0.1)[2]
        way, turns = way + math.hypot(moved.forward, moved.left), turns + abs(moved.turn)
        if way <= BEGIN:
            assert not gained.any()
    np.testing.assert_allclose(model.variances, gained)
    # Constant noise: the largest rate of it was at the shortest way, just beyond the beginning.
    assert gained[0] >= len(told) * 0.03 / way / 50.0
    assert gained[1] == gained[2] >= len(told) * 0.03 / (way + turns) / 50.0
    assert gained[3] == pytest.approx(DELAY**2)


def test_the_prior_after_one_long_way_is_a_quotient():
    model = OdometryErrors(20.0, delay=0.2)
    model.step(Odometry(3.0, 4.0, -2.0, NOISE), NOISE, 1.0)
    np.testing.assert_allclose(model.variances, [0.03 / 5 / 20, 0.03 / 7 / 20, 0.03 / 7 / 20, 0.04])
    certain = OdometryErrors(math.inf)
    assert not certain.step(Odometry(3.0, 4.0, -2.0, NOISE), NOISE, 1.0)[2].any()


@pytest.mark.parametrize("delay", [0.0, 0.03, 0.1, 0.25, 0.47, LATEST, 0.9])
def test_a_late_motion_has_its_shares_of_two_ticks_and_its_slope_is_that_of_the_delay(delay):
    dt, told = 0.1, moves(9)

    def motion(late: float) -> np.ndarray:
        """Return the motion in the last tick of the path that odometry tells, as much later [m, m, rad]."""
        ends = np.cumsum([[0.0] * 3, *[[m.forward, m.left, m.turn] for m in told]], axis=0)
        times = dt * np.arange(len(ends))
        path = [np.interp([8 * dt - late, 9 * dt - late], times, column) for column in ends.T]
        return np.diff(path, axis=1)[:, 0]

    model = OdometryErrors(50.0)
    for moved in told:
        control, slopes, _ = model.step(moved, NOISE, dt, delay=delay)
    late = min(delay, LATEST)
    forward, left, turn = motion(late)
    np.testing.assert_allclose(slopes[:, :3], [[forward, 0, 0], [left, 0, 0], [0, forward, turn]], atol=1e-12)
    # Between ticks the motion changes evenly with the delay.
    after = 1e-3 if delay < LATEST else 0.0
    if after:
        np.testing.assert_allclose(slopes[:, 3], (motion(late + after) - motion(late)) / after, atol=1e-9)
    np.testing.assert_allclose(control + slopes[:, 3] * delay, motion(late), atol=1e-12)


def test_before_the_first_tick_the_robot_was_at_rest():
    control, slopes, _ = OdometryErrors(50.0).step(Odometry(0.2, 0.1, 0.3, NOISE), NOISE, 0.1, delay=0.025)
    np.testing.assert_allclose(slopes[:, 3], [-2.0, -1.0, -3.0])
    np.testing.assert_allclose(control, np.array([0.2, 0.1, 0.3]) * 0.75 + 0.025 * np.array([2.0, 1.0, 3.0]))
