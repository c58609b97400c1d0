"""Views of range sensors against rooms whose distances shapely and closed forms know."""

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely

from mjsim.algorithms.go_to_goal.range_views import Views, rims, touched
from mjsim.geometry import Pose
from mjsim.interface import CameraFrame, Intrinsics, Observation, Odometry, PointCloud, Scan, SensorInfo
from mjsim.mechanics import rotation_of
from tests.algorithms.test_local_navigation import BOX, robot

OPTICAL = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""Axes of a level camera that looks along x: x right, y down, z ahead."""


def mounted(x, y, z, *, yaw=0.0, pitch=0.0, axes=None):
    pose = np.eye(4)
    pose[:3, :3] = rotation_of(np.array([0.0, 0.0, yaw])) @ rotation_of(np.array([0.0, pitch, 0.0]))
    pose[:3, :3] = pose[:3, :3] if axes is None else pose[:3, :3] @ axes
    pose[:3, 3] = x, y, z
    return pose


def views_of(sensor, **readings):
    views = Views(robot(sensors={"s": sensor}))
    odometry = Odometry(0.0, 0.0, 0.0, np.eye(3))
    return views.update(Observation(0.04, 0.04, odometry, proximity=np.full(16, 0.5), **readings))


def test_points_behind_a_lidar_of_270_degrees_are_hidden_and_without_it_none_of_those_between_the_rays():
    views = Views(robot(sensors={"s": SensorInfo("lidar", mounted(0.2, 0.1, 0.3, yaw=0.4), 25.0)}))
    odometry = Odometry(0.0, 0.0, 0.0, np.eye(3))
    points, pose = np.random.default_rng(1).uniform(-3, 3, (300, 2)), Pose(0.7, -0.4, 2.0)
    seen = Observation(0.04, 0.04, odometry, proximity=np.full(16, 0.5))
    views.update(seen)
    assert not views.hidden(pose, points).any()
    scan = Scan(0.04, np.full(271, 2.0), -2.356, 4.712 / 270, range_min=0.05, range_max=8.0)
    views.update(replace(seen, scans={"s": scan}))
    world = Pose(0.7, -0.4, 2.0) @ Pose(0.2, 0.1, 0.4)
    bearings = np.arctan2(points[:, 1] - world.y, points[:, 0] - world.x) - world.heading
    apart = np.abs(np.arctan2(np.sin(bearings), np.cos(bearings)))
    clear = np.abs(apart - 2.356) > 0.02
    np.testing.assert_array_equal(views.hidden(pose, points)[clear], apart[clear] > 2.356)


@pytest.mark.parametrize(("yaw", "pitch"), [(0.0, 0.0), (0.6, 0.0), (-0.5, 0.25)])
def test_a_depth_camera_sees_a_wall_at_its_distance_in_each_bearing(yaw, pitch):
    k = Intrinsics(width=160, height=120, fx=120.0, fy=120.0, cx=79.5, cy=59.5)
    pose = mounted(0.1, 0.05, 0.5, yaw=yaw, pitch=pitch, axes=OPTICAL)
    # A wall across the view 2 m ahead of the camera, from the floor to 3 m; below it the floor.
    v, u = np.mgrid[:120, :160]
    rays = np.stack([(u - k.cx) / k.fx, (v - k.cy) / k.fy, np.ones_like(u, float)], axis=-1) @ pose[:3, :3].T
    ahead = rays[..., 0] * math.cos(yaw) + rays[..., 1] * math.sin(yaw)
    to_floor = np.where(rays[..., 2] < 0, 0.5 / np.maximum(-rays[..., 2], 1e-9), np.inf)
    depth = np.minimum(2.0 / ahead, to_floor)
    depth[:, 80:90] = np.nan
    frame = CameraFrame(0.04, np.zeros((120, 160, 3), np.uint8), k, depth=depth)
    sensor = SensorInfo(kind="camera", robot_from_sensor=pose, rate_hz=5.0, intrinsics=k)
    _, view = views_of(sensor, cameras={"s": frame})
    bearings = view.first + view.step * np.arange(len(view.ranges))
    found = np.isfinite(view.ranges)
    assert found.sum() > 10
    np.testing.assert_allclose(view.ranges[found], 2.0 / np.cos(bearings[found]), rtol=0.012)
    assert view.robot_from_sensor.as_array() == pytest.approx([0.1, 0.05, yaw])
    assert view.farthest == 4.0
    assert view.step == pytest.approx(2 * math.atan2(80.5, 120.0) / len(bearings))
    assert bearings[0] == pytest.approx(-bearings[-1])
    # Nearer than where the lowest row meets the floor something may lie below the view.
    lowest = math.atan2(120 - 59.5, 120.0) + pitch
    assert view.nearest == pytest.approx(0.5 / math.tan(lowest))


def test_a_cloud_is_sorted_into_bearings_by_what_stands_between_floor_and_sensor():
    pose = mounted(-0.1, 0.0, 0.4, yaw=0.7)
    points = np.array([[1, 0, 0], [0.8, 0.01, 0.2], [0, 2, -0.3], [-1, 0, -0.35], [0, -1, 0.11], [3, 3, 0]], np.float32)
    cloud = PointCloud(0.04, points, *np.zeros((2, 6), np.float32), np.zeros(6, np.uint16))
    sensor = SensorInfo(kind="lidar3d", robot_from_sensor=pose, rate_hz=5.0, range=(0.1, 5.0))
    _, view = views_of(sensor, clouds={"s": cloud})
    # Of the robot 0.06 m to 0.5 m above the floor: not the fourth, which lies at 0.05 m, nor the fifth.
    seen = view.points()
    expected = (points[[0, 2, 5]] @ pose[:3, :3].T + pose[:3, 3])[:, :2]
    assert len(seen) == 3
    assert np.hypot(*(seen[:, None] - expected).T).min(axis=1).max() < 0.04
    assert (view.farthest, view.nearest, view.robot_from_sensor.heading) == (5.0, 1.0, pytest.approx(0.7))
    sensor = SensorInfo(kind="lidar3d", robot_from_sensor=pose, rate_hz=5.0)
    assert views_of(sensor, clouds={"s": cloud})[1].farthest == 8.0


@pytest.mark.parametrize("increment", [0.1, -0.1])
def test_a_level_lidar_is_a_view_in_either_direction_of_its_beams(increment):
    ranges = np.linspace(1.0, 2.0, 21)
    ranges[3:6] = math.inf, -math.inf, math.nan
    scan = Scan(0.04, ranges, -10 * increment, increment, 0.05, 8.0)
    sensor = SensorInfo(kind="lidar", robot_from_sensor=mounted(0.2, 0.1, 0.3, yaw=0.4), rate_hz=5.0, range=(0.05, 8.0))
    _, view = views_of(sensor, scans={"s": scan})
    bearings = -10 * increment + increment * np.arange(21)
    order = np.argsort(bearings)
    expected = np.where(np.isinf(ranges), np.where(ranges > 0, math.inf, 0.0), np.nan_to_num(ranges))
    np.testing.assert_allclose(view.ranges, expected[order])
    np.testing.assert_allclose(view.first + view.step * np.arange(21), bearings[order], atol=1e-9)
    assert (view.farthest, view.nearest) == (8.0, 0.0)
    place = Pose(0.2, 0.1, 0.4)
    hit = np.isfinite(ranges)
    points = place.transform((ranges * [np.cos(bearings), np.sin(bearings)]).T[hit])
    seen = view.points()
    np.testing.assert_allclose(seen[np.argsort(seen[:, 1])], points[np.argsort(points[:, 1])], atol=1e-9)


def test_proximity_counts_from_the_rim_of_the_body():
    for outline in (BOX, BOX + np.array([0.1, -0.05]), None):
        found = rims(robot(outline=outline), np.arange(16) * (math.pi / 8))
        for bearing, distance in zip(np.arange(16) * math.pi / 8, found.tolist(), strict=True):
            if outline is None:
                assert distance == pytest.approx(math.hypot(0.25, 0.2))
                continue
            ray = shapely.LineString([(0, 0), (9 * math.cos(bearing), 9 * math.sin(bearing))])
            met = shapely.get_coordinates(ray.intersection(shapely.Polygon(outline).exterior))
            assert distance == pytest.approx(float(np.hypot(*met.T).max()))
    (view,) = views_of(SensorInfo(kind="imu", robot_from_sensor=np.eye(4), rate_hz=5.0))
    np.testing.assert_allclose(view.ranges, 0.5 + rims(robot(), np.arange(16) * (math.pi / 8)))
    assert (view.first, view.step) == (0.0, pytest.approx(math.pi / 8))


def test_rays_that_meet_nothing_are_free_only_as_far_as_they_have_ever_met_something():
    views, away = Views(robot()), np.array([[0.8, 0.0], [1.4, 0.0], [2.4, 0.0]])
    for nearest, expected in ((math.inf, [False] * 3), (1.0, [True, False, False]), (2.0, [True, True, False])):
        ranges = np.full(16, math.inf)
        ranges[4] = nearest
        odometry = Odometry(0.0, 0.0, 0.0, np.eye(3))
        (view,) = views.update(Observation(0.04, 0.04, odometry, proximity=ranges))
        assert len(view.points()) == np.isfinite(nearest)
        # The rim is at least 0.2 m from the origin.
        assert view.is_free(away, 0.025).tolist() == expected


def test_what_is_touched_is_a_flat_piece_beside_the_rim():
    points = touched(robot(), np.array([0.0, math.pi / 2]))
    ahead, left = np.split(points, 2)
    np.testing.assert_allclose(ahead[:, 0], 0.25 + 0.02)
    np.testing.assert_allclose(left[:, 1], 0.2 + 0.02)
    half = 0.5 * math.hypot(0.25, 0.2)
    np.testing.assert_allclose([ahead[:, 1].min(), ahead[:, 1].max()], [-half, half])
    assert np.diff(np.sort(left[:, 0])).max() <= 0.02
