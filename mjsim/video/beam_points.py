"""Points hit by lidar beams, for plans."""

from collections.abc import Iterator, Mapping

import numpy as np

from mjsim.compile import robot_from_sensor
from mjsim.geometry import Array, Pose
from mjsim.interface import Scan
from mjsim.record import Recording
from mjsim.world import Lidar, World


def mounts_of(world: World, robot: str) -> dict[str, Array]:
    """Return robot_from_sensor of each lidar of a robot, shape (4, 4) [m]."""
    return {
        sensor.lidar: robot_from_sensor(sensor.at, yaw_deg=sensor.yaw_deg, pitch_deg=sensor.pitch_deg)
        for each in world.robots
        if each.name == robot
        for sensor in each.sensors
        if isinstance(sensor, Lidar)
    }


def scan_points(scan: Scan, robot_from_lidar: Array, pose: Array) -> Array:
    """Return the points of a scan, seen from above.

    Args:
        scan: Scan of one lidar.
        robot_from_lidar: Shape (4, 4) [m].
        pose: Pose of the robot, (x, y, heading), world frame, shape (3,) [m, m, rad].

    Returns:
        World frame, shape (n, 2) [m].
    """
    points = scan.points() @ robot_from_lidar[:2, :2].T + robot_from_lidar[:2, 3]
    return Pose.from_array(pose).transform(points)


def newest_points(
    scans: Mapping[str, Scan], mounts: Mapping[str, Array], pose: Array, before: Mapping[str, Array]
) -> dict[str, Array]:
    """Return the points of each lidar's newest scan; lidars without a new scan keep their previous points."""
    return {**before, **{name: scan_points(scan, mounts[name], pose) for name, scan in scans.items() if name in mounts}}


def recorded_points(recording: Recording, robot: str) -> Iterator[dict[str, Array]]:
    """Yield for each row of a recording the points of each lidar's newest scan, placed by the estimated pose."""
    track, mounts = recording.robots[robot], mounts_of(recording.world, robot)
    points: dict[str, Array] = {}
    if not mounts:
        yield from (points for _ in track.time)
        return
    poses = np.where(np.isfinite(track.estimate), track.estimate, track.truth)
    for seen in recording.observations(robot):
        for name, scan in seen.scans.items():
            row = int(np.searchsorted(track.time, scan.stamp - 1e-9))
            points = newest_points({name: scan}, mounts, poses[row], points)
        yield points
