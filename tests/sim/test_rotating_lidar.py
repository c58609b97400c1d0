"""Scans of a lidar that rotates, held to the poses of the robot while it did, and to MuJoCo's rays where it stands."""

import math
from dataclasses import replace

import numpy as np
import pytest

import mjsim
from mjsim.geometry import Pose3
from mjsim.interface import Command, Scan, swept
from mjsim.sim import Simulation
from mjsim.sim.rays import batch_rays
from mjsim.world import parse_world, with_settings

WALLS = "walls: [{points: [[0, 0], [8, 0], [8, 6], [0, 6]], closed: true, thickness: 0.1}]"
ROUND = "obstacles: [{name: pillar, cylinder: [0.25, 2.0], at: [5, 1.2]}]"
STEP = 0.004
"""Of the physics [s]."""


def room(keys: str, *, more: str = "") -> mjsim.World:
    lidar = f"{{lidar: scan, at: [0.1, 0.05, 0.3], {keys}}}"
    robot = f"robots: [{{name: scout, preset: pioneer3dx, at: [3, 2], heading_deg: 20, sensors: [{lidar}]}}]"
    return parse_world(f"mjsim: 1\n{WALLS}\n{more}\n{robot}\n")


def driven(world: mjsim.World, *, ticks: int, turn: float = 1.2) -> tuple[Scan, np.ndarray, np.ndarray]:
    """Return the newest scan of a robot that drives an arc; after each step, the time and world_from_lidar (4, 4)."""
    with Simulation(with_settings(world, ["run.rate_hz=250"])) as sim:
        mount, poses = sim.robots["scout"].sensors["scan"].robot_from_sensor, []
        for _ in range(ticks):
            sim.apply("scout", Command(forward=0.5, turn=turn))
            sim.step()
            poses.append(sim.pose("scout") @ mount)
        return sim.sense("scout").scans["scan"], STEP * np.arange(1, ticks + 1), np.array(poses)


def off_the_walls(scan: Scan, times: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Return how far the points of a scan are from the walls, from where the lidar was at the time of each [m]."""
    hit = np.isfinite(scan.ranges)
    moments, angles = (scan.stamp + scan.times())[hit], scan.angles()[hit]
    at = np.apply_along_axis(lambda column: np.interp(moments, times, column), 0, poses.reshape(-1, 16))
    at = at.reshape(-1, 4, 4)
    along = at[:, :3, 0] * np.cos(angles)[:, None] + at[:, :3, 1] * np.sin(angles)[:, None]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    x, y, _ = (at[:, :3, 3] + scan.ranges[hit, None] * along).T
    return np.min(np.abs([x - 0.05, x - 7.95, y - 0.05, y - 5.95]), axis=0)


@pytest.mark.parametrize("fov", [360, 270])
def test_each_beam_meets_the_wall_from_where_the_lidar_is_at_its_time(fov):
    scan, times, poses = driven(room(f"beams: 360, fov_deg: {fov}, rate_hz: 12.5, rotating: true"), ticks=60)
    # A revolution takes 80 ms, whatever part of it is measured.
    assert scan.time_increment == pytest.approx(0.08 * math.degrees(scan.angle_increment) / 360.0)
    assert scan.times()[-1] == 0.0
    assert off_the_walls(scan, times, poses).max() < 1e-6
    assert off_the_walls(replace(scan, time_increment=None), times, poses).max() > 0.1


def test_where_the_robot_stands_it_measures_as_one_that_does_not_rotate():
    keys = "beams: 90, mixed_pixels: 0.5, spot_deg: 3, noise: {range: 0.02}, missed: 0.1, intensity: true"
    scans = []
    for rotating in ("false", "true"):
        with Simulation(room(f"{keys}, rotating: {rotating}", more=ROUND), seed=3) as sim:
            scans.append(sim.sense("scout").scans["scan"])
    still, turning = scans
    np.testing.assert_allclose(turning.ranges, still.ranges, atol=1e-6)
    np.testing.assert_allclose(turning.intensities, still.intensities, atol=1e-6)
    assert still.time_increment is None


def test_before_its_first_revolution_is_over_a_resting_lidar_measures_as_later():
    scans = []
    with Simulation(with_settings(room("beams: 90, fov_deg: 360, rotating: true"), ["run.rate_hz=250"])) as sim:
        for _ in range(2):
            sim.step()
        sim.data.qvel[:] = 0.0
        kept = sim.data.qpos.copy()
        for _ in range(40):
            scans += sim.sense("scout").scans.values()
            sim.step()
            sim.data.qpos[:] = kept
    assert len(scans) == 2
    # The robot settles on its wheels by less than a tenth of a millimetre.
    np.testing.assert_allclose(scans[0].ranges, scans[1].ranges, atol=2e-4)


def test_embree_and_mujoco_give_one_scan(monkeypatch):
    found = []
    for has_embree in (True, False):
        monkeypatch.setattr(batch_rays, "has_embree", lambda has=has_embree: has)
        found.append(driven(room("beams: 90, fov_deg: 360, rotating: true", more=ROUND), ticks=40)[0].ranges)
    # MuJoCo casts all rays of a step from one place.
    np.testing.assert_allclose(*found, atol=0.5 * STEP)


def test_a_scan_as_from_one_place_meets_the_walls_from_there():
    scan, times, poses = driven(room("beams: 360, fov_deg: 360, rotating: true"), ticks=60)
    track = np.column_stack([times, [Pose3.from_matrix(pose).planar().as_array() for pose in poses]])
    still = swept(scan, scan.times(), track, mjsim.Pose(0.0, 0.0, 0.0))
    assert still.time_increment is None
    off = off_the_walls(still, times, poses)
    # At corners, the two beams beside a direction are on two walls.
    assert np.quantile(off, 0.98) < 0.002
    assert off.max() < 0.05
