"""Places that look alike: what a loop may be closed by, and what free space rules out."""

import itertools

import numpy as np
import pytest

from mjsim.algorithms.scans.free_space import seen_through
from mjsim.algorithms.scans.level_scan import LevelScan
from mjsim.algorithms.scans.loop_closing import KEPT, Loop, confirmed_by, find_loop
from mjsim.algorithms.scans.scan_matching import WallField
from mjsim.algorithms.scans.scan_search import SCORED, search
from mjsim.algorithms.scans.scan_walls import Surface, joined, placed, surface_of
from mjsim.geometry import Pose
from mjsim.interface import Scan

STEP = 0.05
"""Distance between two points of a wall [m]."""


def wall(*corners):
    """Return the elements of a wall through corners, seen from its left."""
    ends = np.array(corners, dtype=float)
    points = [
        a + share * (b - a)
        for a, b in itertools.pairwise(ends)
        for share in np.arange(0.0, 1.0, STEP / np.hypot(*(b - a)))
    ]
    middle = ends.mean(axis=0) + 2.0 * np.array([-(ends[-1] - ends[0])[1], (ends[-1] - ends[0])[0]])
    return surface_of(np.array(points), origin=tuple(middle))


def look(pose, walls, reach=20.0):
    """Return a scan of 181 beams over 180 degrees from a pose, to the first element within half a beam."""
    away = walls.points - (pose.x, pose.y)
    bearings = (np.arctan2(away[:, 1], away[:, 0]) - pose.heading + np.pi) % (2 * np.pi) - np.pi
    beams = np.linspace(-np.pi / 2, np.pi / 2, 181)
    ranges = np.full(181, np.inf)
    for number, beam in enumerate(beams):
        met = np.abs(bearings - beam) < np.radians(0.6)
        if met.any() and np.hypot(*away[met].T).min() < reach:
            ranges[number] = np.hypot(*away[met].T).min()
    return pose.as_array(), LevelScan(Scan(0.0, ranges, -np.pi / 2, np.radians(1.0), 0.05, reach), Pose(0, 0, 0))


ROOM = joined([wall((0, 0), (8, 0)), wall((8, 0), (8, 6)), wall((8, 6), (0, 6)), wall((0, 6), (0, 0))])


def test_walls_that_are_there_are_not_seen_through():
    looks = [look(Pose(2.0, 3.0, 0.0), ROOM), look(Pose(5.0, 2.0, 2.0), ROOM)]
    assert seen_through(ROOM, looks) == 0.0


@pytest.mark.parametrize("side", [0.0, np.pi])
def test_a_wall_across_free_space_is_seen_through_from_either_side(side):
    # It stands one metre before the wall at x = 8, or, from the other side, before that at x = 0.
    across = wall((7, 1), (7, 5)) if side == 0.0 else wall((1, 1), (1, 5))
    looks = [look(Pose(4.0, 3.0, side), ROOM)]
    # Beams at its ends meet the corners of the room.
    assert seen_through(across, looks) > 0.7
    # Behind the walls of the room, nothing is known.
    assert seen_through(across.moved(np.array([4.0 * np.cos(side), 0.0, 0.0])), looks) == 0.0


def test_beams_without_a_return_see_through_nothing():
    pose, seen = look(Pose(4.0, 3.0, 0.0), ROOM, reach=0.5)
    assert not np.isfinite(seen.scan.ranges).any()
    assert seen_through(wall((7, 1), (7, 5)), [(pose, seen)]) == 0.0


def corridor(first, last, niches):
    """Return the wall of a corridor with niches of 0.3 m for doors, 1 m wide."""
    points = [(first, -1.0)]
    for at in niches:
        points += [(at, -1.0), (at, -1.3), (at + 1.0, -1.3), (at + 1.0, -1.0)]
    return wall(*points, (last, -1.0))


def test_a_place_that_overlaps_more_of_the_old_part_does_not_win_by_that_alone():
    old = joined([corridor(0.0, 12.0, [0.3, 2.0, 7.0]), wall((12, 1), (0, 1))])
    # The robot came around a corner six metres before where the old part begins. Its doors at -3 and 2 look like those
    # at 2 and 7, but there is none at 5.3.
    new = joined([wall((-6, 4), (-6, -1)), corridor(-6.0, 6.0, [-3.0, 0.3, 2.0]), wall((6, 1), (-4, 1))])
    arguments = {"share": 0.75, "through": lambda step: 0.0}
    loop = find_loop(0, 20, old, new, np.zeros(3), np.diag([9.0, 1.0, 0.01]), **arguments)
    assert loop is None or np.abs(loop.step).max() < 0.1


def niches_along(rng, length):
    """Return one side of a corridor with niches of 0.12 m at random."""
    pieces, begin, at = [], 0.0, rng.uniform(0.8, 4.0)
    while at + 1.0 < length - 0.5:
        pieces.append(wall((begin, 0.0), (at, 0.0), (at, -0.12), (at + 1.0, -0.12), (at + 1.0, 0.0)))
        begin = at + 1.0
        at = begin + rng.uniform(1.5, 5.0)
    return joined(pieces)


def between(surface, first, last):
    inside = (surface.points[:, 0] > first) & (surface.points[:, 0] < last)
    return Surface(surface.points[inside], surface.normals[inside], surface.noise[inside])


@pytest.mark.slow
def test_the_search_in_a_wide_window_loses_no_place_along_a_corridor():
    window = np.array([8.0, 8.0, 0.4])
    for seed in range(12):
        rng = np.random.default_rng(seed)
        sides = [niches_along(rng, 40.0) for _ in range(2)]
        corridor = placed(sides, np.array([[0.0, -1.0, 0.0], [40.0, 1.0, np.pi]])).moved(np.array([-14.0, 0.0, 0.0]))
        old, new = between(corridor, -10.0, 16.0), between(corridor, -14.0, 8.0)
        guess = np.random.default_rng(seed).uniform(-1.0, 1.0, 3) * (5.0, 5.0, 0.3)
        poses, _ = search(WallField(old), new.thinned(SCORED), guess, window, kept=KEPT)
        assert np.abs(poses[:, :2]).max(axis=1).min() < 0.2


def test_a_loop_through_free_space_is_refused():
    covariance = np.diag([0.04, 0.04, 0.001])
    arguments = {"share": 0.75}
    loop = find_loop(0, 20, ROOM, ROOM, np.array([0.1, 0.05, 0.02]), covariance, **arguments, through=lambda step: 0.0)
    assert loop is not None
    np.testing.assert_allclose(loop.step, 0.0, atol=0.02)
    assert find_loop(0, 20, ROOM, ROOM, np.zeros(3), covariance, **arguments, through=lambda step: 0.3) is None


POSES = np.array([(3.0 * k, 0.0, 0.0) for k in range(60)])
"""Of parts of a map: a straight corridor."""


def loop(old, new, *, off, along=0.03):
    """Return a loop that is off along the corridor by some distance, with a standard deviation."""
    step = POSES[new] - POSES[old] + (off, 0.0, 0.0)
    return Loop(old, new, step, np.diag(np.array([along, 0.03, 0.005]) ** -2.0), False)


def test_loops_of_two_places_confirm_each_other_not_those_of_one():
    first, near, far = loop(0, 40, off=6.0), loop(1, 41, off=6.02), loop(3, 43, off=6.05)
    assert confirmed_by(near, [first], POSES) == []
    assert confirmed_by(far, [first, near], POSES) == [first, near]


def test_loops_that_differ_by_more_than_the_way_between_them_do_not_agree():
    assert confirmed_by(loop(3, 43, off=6.5), [loop(0, 40, off=6.0)], POSES) == []


def test_as_many_places_that_contradict_outweigh_those_that_agree():
    right, wrong = loop(0, 40, off=0.0), [loop(2, 42, off=-6.0), loop(3, 42, off=-6.1)]
    assert confirmed_by(loop(5, 45, off=-6.0), [right, *wrong], POSES) == []
    assert confirmed_by(loop(5, 45, off=0.05), [right, loop(3, 43, off=0.0), *wrong], POSES) != []


def test_a_loop_that_does_not_tell_the_place_along_a_corridor_confirms_nothing():
    assert confirmed_by(loop(3, 43, off=6.0), [loop(0, 40, off=6.0, along=30.0)], POSES) == []


def test_a_loop_needs_no_confirmation_in_a_direction_in_which_it_tells_nothing():
    bare = joined([wall((0, -1), (12, -1)), wall((12, 1), (0, 1))])
    middle = between(bare, 2.0, 10.0)
    arguments = {"share": 0.75, "through": lambda step: 0.0}
    found = find_loop(0, 20, bare, middle, np.zeros(3), np.diag([1.0, 0.01, 1e-4]), **arguments)
    assert found is not None
    assert found.certain
    # Across the corridor it tells much.
    found = find_loop(0, 20, bare, middle, np.zeros(3), np.diag([1.0, 0.09, 1e-4]), **arguments)
    assert found is not None
    assert not found.certain


def test_an_uncertain_heading_at_the_end_of_a_long_way_does_not_rule_out_the_right_place():
    # The robot drove 10 m with an error of the heading of 0.5 rad; it ended 0.6 rad off, on an arc.
    way, heading = 10.0, 0.6
    J = np.array([[0.0], [way], [1.0]])
    covariance = 0.5**2 * J @ J.T + np.diag([0.1, 0.1, 0.02]) ** 2
    guess = np.array([way * (1.0 - np.cos(heading)), -way * np.sin(heading), -heading])
    found = find_loop(0, 20, ROOM, ROOM, guess, covariance, share=0.75, through=lambda step: 0.0)
    assert found is not None
    np.testing.assert_allclose(found.step, 0.0, atol=0.05)


def test_the_uncertainty_of_a_step_has_the_axes_of_the_old_part_whichever_way_the_robot_looks():
    covariance = np.diag([0.01, 0.3, 0.02]) ** 2
    turned = np.array([0.0, 0.0, 0.5 * np.pi])
    for off in (np.array([0.15, 0.0, 0.0]), np.array([0.0, 0.9, 0.0])):
        found = find_loop(
            0, 20, ROOM.moved(turned), ROOM, turned + off, covariance, share=0.75, through=lambda step: 0.0
        )
        assert (found is not None) == (off[1] > 0.0)
