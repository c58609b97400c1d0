"""Curves by their length: what the geometry of circles, ellipses and straight lines says."""

import numpy as np
import pytest
from scipy.special import ellipe

from mjsim.mechanics import SpaceCurve

UP = np.array([0.0, 0.0, 1.0])


def test_a_circle_is_as_long_and_as_bent_as_a_circle():
    curve = SpaceCurve.ellipse(0.7, 0.7, UP)
    assert curve.length == pytest.approx(1.4 * np.pi, rel=1e-10)
    for along in (0.0, 1.0, 7.0, -3.0):
        place, slope, bend = curve.at(along)
        turn = along / 0.7
        np.testing.assert_allclose(place, [0.7 * np.cos(turn), 0.7 * np.sin(turn), 0], atol=1e-11)
        np.testing.assert_allclose(slope, [-np.sin(turn), np.cos(turn), 0], atol=1e-9)
        np.testing.assert_allclose(bend, -place / 0.49, atol=1e-5)


def test_an_ellipse_is_as_long_as_the_elliptic_integral():
    assert SpaceCurve.ellipse(3.0, 1.0, UP).length == pytest.approx(12.0 * ellipe(1 - 1 / 9), rel=1e-9)


def test_a_curve_passes_its_points_and_its_tangents_have_length_1():
    points = np.array([[0.0, 0, 0], [1, 0.5, 0.2], [2, 0, 0.9], [2.5, -1, 0]])
    for closed in (False, True):
        curve = SpaceCurve(points, closed=closed, axis=UP)
        for point in points:
            np.testing.assert_allclose(curve.place(curve.nearest(point)), point, atol=1e-9)
        slopes = [np.linalg.norm(curve.at(along)[1]) for along in np.linspace(0, curve.length, 100)]
        np.testing.assert_allclose(slopes, 1.0, atol=2e-4)


def test_an_open_curve_goes_on_straight_beyond_its_ends():
    curve = SpaceCurve(np.array([[0.0, 0, 0], [1, 0, 0]]), closed=False, axis=UP)
    np.testing.assert_allclose(curve.place(-2.0), [-2, 0, 0], atol=1e-12)
    np.testing.assert_allclose(curve.place(3.0), [3, 0, 0], atol=1e-12)
    np.testing.assert_allclose(curve.normals(0.5), [[0, 1, 0], [0, 0, 1]], atol=1e-12)


def test_where_a_curve_crosses_itself_a_point_stays_on_its_branch():
    turn = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    eight = SpaceCurve(np.column_stack([np.sin(turn), np.sin(2 * turn), 0 * turn]), closed=True, axis=UP)
    along, found = 0.2, []
    for start in np.linspace(0.2, eight.length + 0.2, 400):
        along = eight.follow(eight.place(start), along)
        found.append(along - start)
    np.testing.assert_allclose(found, 0.0, atol=1e-9)


def test_directions_across_are_square_to_the_curve_and_to_each_other():
    curve = SpaceCurve(np.array([[0.0, 0, 0], [1, 0.5, 0.2], [2, 0, 0.9], [2.5, -1, 0]]), closed=True, axis=UP)
    for along in np.linspace(0.0, curve.length, 30):
        frame = np.concatenate([curve.normals(along), curve.at(along)[1][None]])
        np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=4e-4)
