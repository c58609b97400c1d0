"""What lidars measured, in the world: each point by where the robot was when it was fired."""

import numpy as np
import pytest

from mjsim.geometry import Pose, Pose3
from mjsim.interface import PointCloud, Scan
from mjsim.web.run.measured import MAX_POINTS, lidar_points

MOUNT = np.array([[0.0, -1, 0, 0.2], [1, 0, 0, 0], [0, 0, 1, 0.4], [0, 0, 0, 1]])
POST = np.array([3.0, 1.0, 1.2])
TIMES = np.arange(0.0, 1.01, 0.04)


def pose_at(time):
    """The robot drives 0.5 m/s along x and turns by 2 rad/s."""
    return Pose3.from_planar(Pose(0.5 * time, 0.0, 2.0 * time))


POSES = np.array([pose_at(time).as_array() for time in TIMES])


def seen_at(time):
    """Where the post is in the sensor's frame."""
    return (np.linalg.inv(pose_at(time).matrix() @ MOUNT) @ [*POST, 1.0])[:3]


def cloud_of(times, *, stamp):
    points = np.array([seen_at(stamp + time) for time in times], dtype=np.float32).reshape(-1, 3)
    count = len(times)
    return PointCloud(
        stamp=stamp,
        points=points,
        times=np.asarray(times, dtype=np.float32),
        intensities=np.ones(count, dtype=np.float32),
        rings=np.zeros(count, dtype=np.uint16),
    )


def test_a_post_is_one_place_though_the_robot_turns_while_it_is_measured():
    cloud = cloud_of(np.linspace(-0.3, 0.0, 40), stamp=0.8)
    found = lidar_points(cloud, MOUNT, times=TIMES, poses=POSES)
    # Both ways are straight in time, so nothing but the precision of the numbers of the cloud is lost.
    np.testing.assert_allclose(found, np.tile(POST, (40, 1)), atol=1e-5)
    at_once = lidar_points(cloud, MOUNT, times=TIMES[20:21], poses=POSES[20:21])
    assert np.linalg.norm(at_once - POST, axis=1).max() > 1.0


def test_a_scan_is_placed_by_its_stamp_though_it_came_later():
    x, y, _ = seen_at(0.3)
    scan = Scan(0.3, np.array([np.hypot(x, y), np.inf]), np.arctan2(y, x), 0.1, 0.05, 10.0)
    found = lidar_points(scan, MOUNT, times=TIMES, poses=POSES)
    np.testing.assert_allclose(found, [[POST[0], POST[1], 0.4]], atol=1e-9)


@pytest.mark.parametrize("stamp", [-1.0, 0.0, 5.0])
def test_what_was_measured_before_or_after_the_poses_takes_the_nearest_one(stamp):
    pose = POSES[0 if stamp <= 0.0 else -1]
    found = lidar_points(cloud_of([0.0], stamp=stamp), MOUNT, times=TIMES, poses=POSES)
    expected = Pose3(*pose.tolist()).matrix() @ MOUNT @ [*seen_at(stamp), 1.0]
    np.testing.assert_allclose(found, [expected[:3]], atol=1e-5)


def test_few_of_very_many_points_are_kept_and_none_where_the_pose_is_not_known():
    cloud = cloud_of(np.linspace(-0.1, 0.0, 2 * MAX_POINTS + 1), stamp=0.5)
    assert 0 < len(lidar_points(cloud, MOUNT, times=TIMES, poses=POSES)) <= MAX_POINTS
    assert lidar_points(cloud, MOUNT, times=TIMES, poses=np.full_like(POSES, np.nan)).shape == (0, 3)
    assert lidar_points(cloud_of([], stamp=0.5), MOUNT, times=TIMES, poses=POSES).shape == (0, 3)
