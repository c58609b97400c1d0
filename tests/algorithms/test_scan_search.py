"""Where a scan lies among older walls, when most of it is new."""

import numpy as np
import pytest

from mjsim.algorithms.scans.scan_search import match_pose
from mjsim.algorithms.scans.scan_walls import joined, surface_of

NOISE = np.diag([0.05, 0.05, 0.06]) ** 2


def wall(begin, end):
    """Return a wall seen from the origin."""
    return surface_of(np.linspace(begin, end, 1 + int(np.hypot(*np.subtract(end, begin)) / 0.05)))


DOOR = [wall((0.5, 1.0), (3.5, 1.0)), wall((-1.0, -2.5), (-1.0, 0.5))]
"""Walls of a room, 3 m each."""
BEHIND = [wall((4.0, -6.0), (4.0, 9.0)), wall((-4.0, 9.0), (4.0, 9.0))]
"""What is seen only from its door."""


def test_a_scan_that_shows_mostly_new_walls_is_laid_on_the_few_known_ones():
    step = np.array([0.06, -0.05, 0.08])
    found = match_pose(joined([*DOOR, *BEHIND]), joined(DOOR), step, NOISE)
    np.testing.assert_allclose(found.pose, 0.0, atol=0.01)
    assert np.sqrt(found.own[2, 2]) < 0.01


@pytest.mark.parametrize("old", [[wall((0.5, 1.0), (2.0, 1.0))], [wall((0.5, 1.15), (3.5, 1.15)), *DOOR[:1]]])
def test_it_is_not_where_known_walls_are_few_or_others_contradict(old):
    step = np.array([0.06, -0.05, 0.08])
    found = match_pose(joined([*DOOR, *BEHIND]), joined(old), step, NOISE)
    np.testing.assert_array_equal(found.pose, step)
