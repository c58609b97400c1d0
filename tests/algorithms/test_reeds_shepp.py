"""Shortest curves of a car against sums of small steps, and the laws of a distance."""

import itertools
import math

import numpy as np
import pytest

from mjsim.algorithms.paths.reeds_shepp import curves, length_of, poses_on
from mjsim.geometry import Pose

RADIUS = 0.8


def shortest(start, end):
    return RADIUS * length_of(next(curves(start, end, radius=RADIUS)))


def test_all_curves_lead_to_their_end_by_steps_along_the_heading():
    rng = np.random.default_rng(0)
    for values in rng.uniform(-3.0, 3.0, (20, 6)):
        start, end = Pose(*values[:3]), Pose(*values[3:])
        for curve in itertools.islice(curves(start, end, radius=RADIUS), 4):
            poses, bend, way = poses_on(start, curve, radius=RADIUS, spacing=0.01)
            steps = np.hypot(*np.diff(poses[:, :2], axis=0).T)
            middle = 0.5 * (poses[1:, 2] + poses[:-1, 2])
            x = poses[0, 0] + np.sum(way[1:] * steps * np.cos(middle))
            y = poses[0, 1] + np.sum(way[1:] * steps * np.sin(middle))
            assert [x, y] == pytest.approx([end.x, end.y], abs=1e-6)
            turned = poses[0, 2] + np.sum(way[1:] * steps * bend[1:])
            assert math.remainder(turned - end.heading, 2 * math.pi) == pytest.approx(0.0, abs=1e-3)
            assert steps.sum() == pytest.approx(RADIUS * length_of(curve), abs=1e-3)


def test_lengths_known_from_geometry():
    here = Pose(0.0, 0.0, 0.0)
    assert shortest(here, Pose(-2.0, 0.0, 0.0)) == pytest.approx(2.0)
    assert shortest(here, Pose(0.0, 1.6, math.pi)) == pytest.approx(RADIUS * math.pi)
    # Turned about: three arcs of 60 degrees.
    assert shortest(here, Pose(0.0, 0.0, math.pi)) == pytest.approx(RADIUS * math.pi)
    # Three turns with cusps between them: sin(a / 2) = 1 / 4 of the shift in radii.
    shift = 0.1
    aside = shortest(here, Pose(0.0, shift * RADIUS, 0.0))
    assert aside < RADIUS * 4.0 * math.acos(1.0 - shift / 4.0) + 1e-9


def test_it_is_a_distance_the_same_both_ways_and_never_longer_than_a_detour():
    rng = np.random.default_rng(1)
    for values in rng.uniform(-2.0, 2.0, (40, 9)):
        a, b, c = Pose(*values[:3]), Pose(*values[3:6]), Pose(*values[6:])
        assert shortest(a, b) == pytest.approx(shortest(b, a), abs=1e-9)
        assert shortest(a, c) <= shortest(a, b) + shortest(b, c) + 1e-9
        assert shortest(a, b) >= math.hypot(a.x - b.x, a.y - b.y) - 1e-9
