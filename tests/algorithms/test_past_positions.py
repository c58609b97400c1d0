"""Marks on the way of a filter, the frame that they hold, and first estimates that are renewed."""

import math

import numpy as np
import pytest

from mjsim.algorithms.ekf_slam.ekf_slam import EkfSlam, EkfSlamFilter, InvariantEkfSlamFilter, odometry_motion
from mjsim.algorithms.ekf_slam.past_positions import MAX_MARKS
from mjsim.algorithms.estimation.ekf_models import range_bearing
from mjsim.geometry import Array, Pose
from mjsim.interface import Estimate, Observation, Odometry, Sighting
from tests.robots import pioneer

R = np.diag([0.05, np.radians(1.0)]) ** 2
DT = 0.1
POSTS = {"a": (3.0, 1.0), "b": (3.0, -1.0), "c": (-4.0, 3.0), "d": (-5.0, 1.0)}
SLIP = 0.5
"""So much less the robot turns in the dark than odometry says [rad]."""
FILTERS = {
    "standard": lambda **rest: EkfSlamFilter(jacobians="standard", **rest),
    "first-estimates": lambda **rest: EkfSlamFilter(jacobians="first-estimates", **rest),
    "invariant": lambda **rest: InvariantEkfSlamFilter(**rest),
}


@pytest.mark.parametrize("kind", FILTERS)
def test_a_mark_stays_with_a_robot_that_rests(kind):
    slam = FILTERS[kind](covariance=np.diag([0.04, 0.02, 0.01]))
    slam.update(["post"], [[3.0, 0.2]], R)
    slam.predict(odometry_motion(), [1.0, 0.2, 0.3], 0.01 * np.eye(3))
    slam.mark("here")
    for measured in ([2.1, 0.1], [2.0, 0.15], [2.2, 0.05]):
        slam.update(["post"], [measured], R)
    place, spread = slam.landmarks(["here"])["here"]
    np.testing.assert_allclose(place, slam.pose[:2], atol=1e-9)
    np.testing.assert_allclose(spread, slam.covariance[:2, :2], atol=1e-9)


def test_first_estimates_that_are_renewed_tell_nothing_of_the_heading_at_the_start():
    unsure = 0.3
    slam = EkfSlamFilter(jacobians="first-estimates", covariance=np.diag([1e-8, 1e-8, unsure**2]), renew=0.2)
    noise = 1e-4 * np.eye(2)
    slam.update(["near"], [[2.0, 0.0]], noise)
    slam.predict(odometry_motion(), [1.0, 0.0, 1.0], np.diag([1e-4, 1e-4, 1.0]))
    for _ in range(5):
        slam.update(["other"], [[4.0, 0.5]], noise)
    # It turned by a radian less than odometry said: that moves the other landmark by metres.
    pose, places = np.array([1.0, 0.0, 0.0]), np.array([(2.0, 0.0), (1.0 + 4.0 * math.cos(0.5), 4.0 * math.sin(0.5))])
    Z, _, _ = range_bearing(pose, places)
    for _ in range(20):
        slam.update(["near", "other"], Z, noise)
    # Nothing tells how the whole map is turned about the start; noise of the first look allows for a little.
    assert math.sqrt(slam.covariance[2, 2]) > 0.98 * unsure


def drive(slam: EkfSlam) -> tuple[Array, list[Estimate]]:
    """Drive past two posts, turn in the dark by less than odometry says, past two others, and back past all.

    Returns the true poses, shape (N, 3), and the estimates.
    """
    slam.start(pioneer(prior=Pose(0.0, 0.0, 0.0)), {}, np.random.default_rng(0))
    rng, truth, poses, told = np.random.default_rng(1), np.zeros(3), [], []
    for tick in range(700):
        forward, turn = 0.06, 0.0
        if 100 <= tick < 150:
            turn = (math.pi - SLIP) / 50
        if 400 <= tick < 450:
            turn = math.pi / 50
        odometry = turn + (SLIP / 50 if 100 <= tick < 150 else 0.0)
        truth, _, _ = odometry_motion()(truth, np.array([forward, 0.0, turn]))
        covariance = np.diag([1e-5, 1e-9, (0.4**2) * abs(odometry) + 1e-8])
        Z, _, _ = range_bearing(truth, np.array([*POSTS.values()]))
        looks = [
            Sighting(DT * tick, name, float(z[0]), float(z[1]), R)
            for name, z in zip(POSTS, Z + rng.normal(0.0, np.sqrt(np.diag(R)), Z.shape), strict=True)
            if (name in "ab") == (tick < 100 or tick >= 500) or tick >= 600
        ]
        seen = Observation(DT * tick, DT, Odometry(forward, 0.0, odometry, covariance), sightings=tuple(looks))
        told.append(slam.update(seen))
        poses.append(truth)
    return np.array(poses), told


def gaps(belief: Estimate) -> Array:
    """Return the distances between the robot and all landmarks, and among these."""
    places = np.array([belief.pose.as_array()[:2], *(mean for mean, _ in belief.landmarks.values())])
    return np.linalg.norm(places[:, None] - places, axis=-1)


@pytest.mark.slow
@pytest.mark.parametrize("jacobians", ["first-estimates", "invariant"])
def test_places_stay_where_they_were_told_when_a_loop_tells_how_the_map_is_turned_and_nothing_else_changes(jacobians):
    jumps, ends = {}, {}
    for frame in ("map", "start"):
        _, told = drive(EkfSlam(jacobians=jacobians, frame=frame, systematic=math.inf, joint_covariance=True))
        ends[frame] = told[-1]
        jumps[frame] = float(np.hypot(*(told[-1].landmarks["d"][0] - told[490].landmarks["d"][0])))
    assert jumps["map"] < 0.5 * jumps["start"]
    held, plain = ends["map"], ends["start"]
    assert list(held.landmarks) == list(plain.landmarks)
    # Distances within the map do not depend on the frame.
    np.testing.assert_allclose(gaps(held), gaps(plain), atol=1e-6)
    joint = held.joint_covariance
    np.testing.assert_allclose(joint[:3, :3], held.covariance, atol=1e-9)
    for row, (_, spread) in enumerate(held.landmarks.values()):
        at = slice(3 + 2 * row, 5 + 2 * row)
        np.testing.assert_allclose(joint[at, at], spread, atol=1e-9)


def test_a_robot_that_is_sure_of_its_heading_reports_the_solution():
    told = {}
    for frame in ("map", "start"):
        slam = EkfSlam(frame=frame)
        slam.start(pioneer(prior=Pose(0.0, 0.0, 0.0)), {}, np.random.default_rng(0))
        for tick in range(25):
            seen = Observation(
                DT * tick,
                DT,
                Odometry(0.05, 0.0, 0.0, np.diag([1e-6, 1e-9, 1e-8])),
                sightings=(Sighting(DT * tick, "a", 5.0 - 0.05 * tick, 0.0, R),),
            )
            told[frame] = slam.update(seen)
    np.testing.assert_allclose(told["map"].pose.as_array(), told["start"].pose.as_array(), atol=1e-12)
    np.testing.assert_allclose(told["map"].covariance, told["start"].covariance, atol=1e-12)


def test_marks_are_thinned_and_stay_out_of_the_map():
    slam = EkfSlam()
    slam.start(pioneer(prior=Pose(0.0, 0.0, 0.0)), {}, np.random.default_rng(0))
    for tick in range(700):
        belief = slam.update(Observation(DT * tick, DT, Odometry(0.05, 0.0, 0.02, 1e-8 * np.eye(3))))
    assert belief.landmarks == {}
    assert MAX_MARKS / 2 <= len(slam._filter.names()) <= MAX_MARKS


def test_a_frame_that_there_is_not_is_refused():
    with pytest.raises(ValueError, match="frame is 'world'; it must be map or start"):
        EkfSlam(frame="world")
