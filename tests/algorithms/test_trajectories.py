"""Paths and motions on problems with known answers."""

import numpy as np
import pytest

from mjsim.algorithms.paths.trajectories import SplinePath, fastest_profile, minimum_jerk

LIMITS = {"speed": 1.0, "turn": 2.0, "acceleration": 0.5, "turn_acceleration": 3.0}


def circle_path(radius=2.0):
    angles = np.linspace(0, 1.5 * np.pi, 40)
    return SplinePath(radius * np.stack([np.cos(angles), np.sin(angles)], axis=-1))


def test_a_path_through_points_on_a_line_is_that_line():
    path = SplinePath([(0, 0), (1, 0.5), (4, 2)])
    assert path.length == pytest.approx(np.hypot(4, 2), rel=1e-6)
    np.testing.assert_allclose(path.at(path.length / 2), (2, 1), atol=1e-6)
    np.testing.assert_allclose(path.heading([0, 1, 2]), np.arctan2(2, 4), atol=1e-9)
    np.testing.assert_allclose(path.curvature([0, 1, 2]), 0.0, atol=1e-9)


def test_a_path_through_points_of_a_circle_has_its_length_and_curvature():
    path = circle_path()
    assert path.length == pytest.approx(3 * np.pi, rel=1e-4)
    np.testing.assert_allclose(path.curvature(np.linspace(1, 8, 20)), 0.5, rtol=0.01)
    np.testing.assert_allclose(np.hypot(*path.at(np.linspace(0, path.length, 50)).T), 2.0, rtol=1e-3)


def test_least_jerk_from_rest_to_rest_is_the_known_polynomial():
    p = minimum_jerk((0, 0, 0), (1, 0, 0), 2.0)
    t = np.linspace(0, 2, 9)
    np.testing.assert_allclose(p(t), 10 * (t / 2) ** 3 - 15 * (t / 2) ** 4 + 6 * (t / 2) ** 5, atol=1e-12)
    # Flash and Hogan: the top speed is 1.875 times the mean.
    assert p.deriv()(1.0) == pytest.approx(1.875 / 2)


def test_least_jerk_meets_any_two_states():
    start, end = (1.0, -0.5, 0.3), (2.0, 0.7, -0.2)
    p = minimum_jerk(start, end, 1.7)
    np.testing.assert_allclose([p(0), p.deriv()(0), p.deriv(2)(0)], start, atol=1e-12)
    np.testing.assert_allclose([p(1.7), p.deriv()(1.7), p.deriv(2)(1.7)], end, atol=1e-12)


def test_the_fastest_motion_on_a_line_is_the_trapezoid():
    profile = fastest_profile(SplinePath([(0, 0), (10, 0)]), **LIMITS)
    # 2 s up to 1 m/s over 1 m, 8 m at 1 m/s, 2 s down.
    assert profile.duration == pytest.approx(12.0, rel=0.01)
    np.testing.assert_allclose(profile.speed([0.25, 5.0, 9.75]), [0.5, 1.0, 0.5], rtol=0.02)


def test_a_way_too_short_for_the_top_speed_is_bang_bang():
    profile = fastest_profile(SplinePath([(0, 0), (1, 0)]), **LIMITS)
    # Half the way faster and faster, half slower and slower: 2 sqrt(length / acceleration), at most sqrt(length a).
    assert profile.duration == pytest.approx(2 * np.sqrt(1 / 0.5), rel=0.01)
    assert profile.speeds.max() == pytest.approx(np.sqrt(0.5), rel=0.01)


def test_on_a_tight_circle_the_turn_rate_bounds_the_speed():
    profile = fastest_profile(circle_path(0.3), **LIMITS)
    assert profile.speed(0.7) == pytest.approx(2.0 * 0.3, rel=0.03)


def test_no_limit_is_broken_on_a_winding_path():
    path = SplinePath([(0, 0), (1, 0), (1.5, 0.8), (1, 1.5), (2.5, 2), (4, 0)])
    profile = fastest_profile(path, **LIMITS)
    turns = profile.speeds * path.curvature(profile.along)
    acceleration = np.diff(profile.speeds) / np.diff(profile.times)
    turn_acceleration = np.diff(turns) / np.diff(profile.times)
    assert profile.speeds.max() <= 1.0 + 1e-6
    assert np.abs(turns).max() <= 2.0 * 1.02
    assert np.abs(acceleration).max() <= 0.5 * 1.01
    # As fast as can be: nearly everywhere one of the limits is reached.
    at_limit = (profile.speeds[1:] > 0.98) | (np.abs(turns[1:]) > 1.95) | (np.abs(acceleration) > 0.48)
    assert np.mean(at_limit | (np.abs(turn_acceleration) > 2.7)) > 0.9


def test_repeated_points_are_errors():
    with pytest.raises(ValueError, match="consecutive ones different"):
        SplinePath([(0, 0), (0, 0)])
