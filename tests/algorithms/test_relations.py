"""Relations between scans at revisited places, by which maps of real logs are judged."""

from itertools import pairwise

import numpy as np

from mjsim.algorithms.estimation.pose_graph import step_between
from mjsim.algorithms.scans.scan_walls import surface_of
from mjsim.bench.relations import LATER, errors_of, relations


def test_relations_are_the_true_steps_whatever_the_path_that_chose_them_says():
    corners = np.array([(-3, -2), (4, -2), (4, 1), (2, 1), (2, 3), (-3, 3), (-3, -2)], dtype=float)
    sides = pairwise(corners)
    room = surface_of(np.concatenate([np.linspace(one, other, 60, endpoint=False) for one, other in sides]))
    ring = 2.0 * np.pi * np.arange(LATER + 2) / LATER
    truth = np.column_stack([np.cos(ring), np.sin(ring), ring - np.pi])
    scans = [room.moved(step_between(pose, np.zeros(3))) for pose in truth]
    bent = truth + np.outer(np.arange(len(truth)) / LATER, [0.3, 0.0, 0.1])
    found = list(relations(scans, bent))
    assert [(each.one, each.other) for each in found] == [(0, LATER), (1, LATER + 1)]
    np.testing.assert_allclose(errors_of(found, truth), 0.0, atol=0.01)
    np.testing.assert_allclose(errors_of(found, bent), [[0.3, 0.1]] * 2, atol=0.05)
