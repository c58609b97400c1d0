"""Parts of scan matching that are written for speed, compared with their plain forms."""

import itertools

import numpy as np
import pytest

from mjsim.algorithms.estimation.pose_graph import compose, composed
from mjsim.algorithms.estimation.pose_matrices import inverse, solution
from mjsim.algorithms.scans.scan_matching import WallField, align
from mjsim.algorithms.scans.scan_noise import median
from mjsim.algorithms.scans.scan_search import RADIUS, match_pose, search
from mjsim.algorithms.scans.scan_walls import joined, placed, surface_of


def wall(rng, *, number=60):
    """Return walls of a polygon with corners at random."""
    corners = rng.uniform(-4.0, 4.0, (5, 2))
    return surface_of(np.concatenate([np.linspace(a, b, number)[:-1] for a, b in itertools.pairwise(corners)]))


@pytest.mark.parametrize("scale", [1e-4, 1.0, 1e4])
def test_inverse_and_solution_are_those_of_numpy(scale):
    rng = np.random.default_rng(0)
    for _ in range(200):
        A = rng.normal(size=(3, 3)) * scale
        P = A @ A.T + 1e-3 * scale**2 * np.eye(3)
        right = rng.normal(size=3)
        np.testing.assert_allclose(inverse(P) @ P, np.eye(3), atol=1e-8)
        np.testing.assert_allclose(P @ solution(P.tolist(), right.tolist()), right, atol=1e-8)


@pytest.mark.parametrize("count", [1, 2, 7, 20])
def test_the_median_is_that_of_numpy(count):
    values = np.random.default_rng(count).normal(size=count)
    assert median(values) == np.median(values)


def test_composed_poses_are_those_composed_one_by_one():
    rng = np.random.default_rng(1)
    outers, inners = rng.uniform(-4.0, 4.0, (2, 30, 3))
    each = [compose(outer, inner) for outer, inner in zip(outers, inners, strict=True)]
    np.testing.assert_allclose(composed(outers, inners), each, atol=1e-12)


def test_surfaces_placed_together_are_those_moved_one_by_one():
    rng = np.random.default_rng(2)
    surfaces, poses = [wall(rng) for _ in range(4)], rng.uniform(-3.0, 3.0, (4, 3))
    together = placed(surfaces, poses)
    each = joined([surface.moved(pose) for surface, pose in zip(surfaces, poses, strict=True)])
    for name in ("points", "normals", "noise"):
        np.testing.assert_allclose(getattr(together, name), getattr(each, name), atol=1e-12)


def test_a_scan_aligned_from_several_starts_ends_where_it_does_from_each():
    rng = np.random.default_rng(3)
    surface, information = wall(rng), np.diag([4.0, 4.0, 20.0])
    field, guess = WallField(surface), np.array([0.05, -0.1, 3.1])
    scan = surface.moved(np.array([0.0, 0.0, -3.12]))
    starts = guess + rng.uniform(-1.0, 1.0, (6, 3)) * (0.3, 0.3, 0.1)
    for together, start in zip(align(field, scan, guess, information, starts), starts, strict=True):
        (alone,) = align(field, scan, guess, information, start[None])
        np.testing.assert_allclose(together.pose, alone.pose, atol=1e-9)
        np.testing.assert_allclose(together.information, alone.information, rtol=1e-9)
        assert (together.share, together.conflict) == (alone.share, alone.conflict)
        assert together.cost == pytest.approx(alone.cost)


def test_a_guess_just_below_half_a_turn_is_near_a_start_just_above_it():
    surface = wall(np.random.default_rng(4))
    field, scan = WallField(surface), surface.moved(np.array([0.0, 0.0, -3.14]))
    guess, start = np.array([0.0, 0.0, 3.12]), np.array([0.0, 0.0, -3.13])
    (match,) = align(field, scan, guess, np.diag([1.0, 1.0, 1e4]), start[None])
    assert match.cost < 10.0
    assert abs(match.pose[2]) > 3.1


@pytest.mark.parametrize("window", [(0.3, 0.2, 0.1), (2.0, 1.0, 0.3), (8.0, 8.0, 0.2)])
def test_the_search_scores_poses_by_the_distance_of_the_scan_from_walls(window):
    rng = np.random.default_rng(5)
    field, scan = WallField(wall(rng)), wall(rng).thinned(48)
    guess, window = np.array([0.3, -0.2, 0.4]), np.array(window)
    poses, scores = search(field, scan, guess, window)
    assert (np.diff(scores) <= 0.0).all()
    for pose, score in zip(poses, scores, strict=True):
        # The finest level scores up to half a step beyond `RADIUS`.
        placed_scan = (scan.moved(pose).points - field.lower).T[:, None]
        near = np.maximum(1.0 - field.distance[field.cells(placed_scan)] / (RADIUS + 0.05), 0.0).mean()
        aside = 0.02 * np.abs((pose - guess) / window).max()
        assert score == pytest.approx(near - aside, abs=1e-5)


def test_a_slip_in_a_bare_corridor_is_noticed_whichever_way_the_robot_looks():
    angles = np.linspace(-np.pi, np.pi, 360, endpoint=False)
    reach = np.minimum(1.0 / np.maximum(np.abs(np.sin(angles)), 1e-9), 6.0)
    corridor = surface_of(np.stack([reach * np.cos(angles), reach * np.sin(angles)], axis=-1)[reach < 5.9])
    along = []
    for turn in (0.5, -0.5):
        walls, ahead = corridor.moved(np.array([0.0, 0.0, turn])), np.array([np.cos(turn), np.sin(turn)])
        # By odometry, ten standard deviations into a wall.
        step = np.array([-0.3 * ahead[1], 0.3 * ahead[0], 0.0])
        laid = match_pose(walls, walls, step, np.diag([0.03, 0.03, 0.01]) ** 2)
        np.testing.assert_allclose(laid.pose, 0.0, atol=0.005)
        along.append(np.sqrt(ahead @ laid.own[:2, :2] @ ahead))
    # Odometry has failed: it may be off along the corridor as well.
    assert min(along) > 0.15
