"""Scans of a part of the map are fixed to each other: what is doubtful lies between parts."""

import numpy as np
import pytest

from mjsim.algorithms.scans.level_scan import LevelScan
from mjsim.algorithms.scans.map_parts import PartsMap
from mjsim.algorithms.scans.odometry_bias import COUNT, OdometryBias
from mjsim.algorithms.scans.scan_search import MatchedPose
from mjsim.algorithms.scans.scan_walls import surface_of
from mjsim.geometry import Pose
from mjsim.interface import Scan

SCAN = LevelScan(Scan(0.0, np.full(10, 3.0), -1.0, 0.2, 0.05, 10.0), Pose(0.0, 0.0, 0.0))
STEP = np.array([0.4, 0.0, 0.0])


@pytest.mark.parametrize(("doubt", "length", "parts"), [(0.1, 6.0, 2), (0.01, 6.0, 1), (0.1, 1.5, 1)])
def test_a_doubtful_turn_to_a_scan_with_walls_begins_a_part(doubt, length, parts):
    walls = surface_of(np.linspace((1.0, 1.0), (1.0 + length, 1.0), 100))
    found = PartsMap(np.zeros(3), np.zeros((3, 3)), OdometryBias(), loop_distance=3.0, loop_share=0.75)
    for turn in (0.01, 0.01, 0.01, doubt, 0.01):
        covariance = np.diag([0.01, 0.01, turn]) ** 2
        matched = MatchedPose(STEP, covariance, covariance, covariance, np.eye(3))
        found.add(SCAN, walls, matched, np.zeros((3, COUNT)))
    found.finish()
    assert len(found.graph.poses) == parts
    np.testing.assert_allclose(found.poses()[:, 0], 0.4 * np.arange(1, 6), atol=1e-9)
