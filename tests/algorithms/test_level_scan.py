"""Scans of a lidar that is not level, brought level."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mjsim import Command, Simulation, parse_world
from mjsim.algorithms.balance import Lqr
from mjsim.algorithms.scans.level_scan import LevelLidar, leaning, level_scan
from mjsim.interface import Scan

HALL = """
mjsim: 1
name: hall
walls: [{points: [[0, 0], [14, 0], [14, 4], [0, 4]], closed: true, thickness: 0.1}]
robots:
  - name: joe
    preset: balancer
    at: [2, 2]
    sensors:
      - {imu: imu, rate_hz: 250, at: [0, 0, 0.105]}
      - {lidar: scan, at: [0, 0, 0.45], beams: 180, fov_deg: 270, range: [0.05, 20]}
run: {rate_hz: 12.5, seconds: 3, map: known}
"""


def seen_by(level_from_lidar: np.ndarray, angles: np.ndarray, *, wall: float) -> Scan:
    """Return the scan of a lidar in front of a wall on a floor, by planes that its beams meet."""
    away = np.full(len(angles), math.inf)
    for k, angle in enumerate(angles):
        beam = Rotation.from_euler("z", angle).apply([1.0, 0.0, 0.0])
        aim = Rotation.from_matrix(level_from_lidar[:3, :3]).apply(beam)
        x, _, z = level_from_lidar[:3, 3]
        meets = [(wall - x) / aim[0] if aim[0] > 1e-9 else math.inf, -z / aim[2] if aim[2] < -1e-9 else math.inf]
        away[k] = min(meets)
    away[away > 20.0] = math.inf
    return Scan(0.0, away, float(angles[0]), float(angles[1] - angles[0]), 0.05, 20.0)


def mounted(pitch: float, roll: float = 0.0) -> np.ndarray:
    """Return level_from_lidar of one at (0.1, 0, 0.8) [m] on a body that leans."""
    mount = np.eye(4)
    mount[:3, 3] = 0.1, 0.0, 0.8
    tilt = np.eye(4)
    tilt[:3, :3] = Rotation.from_euler("yx", [pitch, roll]).as_matrix()
    return np.asarray(tilt @ mount)


@pytest.mark.parametrize("pitch", [-0.06, 0.0, 0.06])
@pytest.mark.parametrize("roll", [0.0, 0.05])
def test_a_wall_lies_where_it_is_however_the_lidar_is_tilted(pitch, roll):
    pose = mounted(pitch, roll)
    points = level_scan(seen_by(pose, np.linspace(-0.7, 0.7, 29), wall=4.0), pose).points()
    assert len(points) == 29
    # A beam's angle is off by a quarter of the tilt squared, 0.0015 rad, which at 3.4 m aside is 5 mm ahead.
    np.testing.assert_allclose(points[:, 0], 4.0, atol=0.006)


def test_what_comes_back_from_the_floor_tells_nothing():
    pose = mounted(0.06)
    scan = seen_by(pose, np.linspace(-0.7, 0.7, 29), wall=30.0)
    assert np.isfinite(scan.ranges).all()
    level = level_scan(scan, pose).scan
    assert np.isneginf(level.ranges).all()


def test_what_nothing_came_back_from_stays_as_it_was():
    scan = Scan(0.0, np.array([math.inf, -math.inf, math.inf]), -0.1, 0.1, 0.05, 20.0)
    np.testing.assert_array_equal(level_scan(scan, mounted(0.06)).scan.ranges, scan.ranges)


def test_leaning_forward_brings_the_top_ahead():
    np.testing.assert_allclose(leaning(0.1) @ [0, 0, 1, 1], [math.sin(0.1), 0, math.cos(0.1), 1], atol=1e-12)


def test_a_balancing_robot_that_speeds_up_sees_the_walls_where_they_are():
    world = parse_world(HALL)
    with Simulation(world, seed=1) as sim:
        sim.control("joe", {"drive": Lqr()})
        lidar, off, lean = LevelLidar(sim.robots["joe"], None), [], []
        for tick in range(30):
            seen = sim.sense("joe")
            if (looked := lidar.update(seen)) is not None:
                x, y = sim.truth("joe").transform(looked.points()).T
                off.append(np.min(np.abs([x - 0.05, x - 13.95, y - 0.05, y - 3.95]), axis=0).max())
                lean.append(abs(float(np.arcsin(sim.pose("joe")[0, 2]))))
            sim.apply("joe", Command(forward=0.8 if tick > 5 else 0.0))
            sim.step()
    assert max(lean) > math.radians(2.5)
    # Not levelled, what comes back from the floor is up to 1.9 m off. The pitch is told to a tenth of a degree.
    assert max(off) < 0.02


def test_a_level_lidar_of_a_robot_that_does_not_lean_costs_nothing():
    text = HALL.replace("balancer", "pioneer3dx").replace("      - {imu: imu, rate_hz: 250, at: [0, 0, 0.105]}\n", "")
    with Simulation(parse_world(text), seed=1) as sim:
        seen = sim.sense("joe")
        looked = LevelLidar(sim.robots["joe"], "scan").update(seen)
    assert looked is not None
    assert looked.scan is seen.scans["scan"]


def test_a_lidar_that_is_not_there_is_named():
    with Simulation(parse_world(HALL), seed=1) as sim, pytest.raises(ValueError, match="no lidar 'top'"):
        LevelLidar(sim.robots["joe"], "top")


@pytest.mark.parametrize("deskew", [True, False])
def test_the_motion_of_the_robot_is_undone_in_scans_of_a_lidar_that_rotates(deskew):
    lidar = "{lidar: scan, at: [0.1, 0, 0.3], beams: 360, fov_deg: 360, range: [0.1, 20], rotating: true}"
    robot = f"{{name: scout, preset: pioneer3dx, at: [4, 2], sensors: [{lidar}]}}"
    with Simulation(parse_world(HALL[: HALL.index("robots")] + f"robots: [{robot}]")) as sim:
        lidars = LevelLidar(sim.robots["scout"], None, deskew=deskew)
        for _ in range(24):
            lidars.update(sim.sense("scout"))
            sim.apply("scout", Command(0.3, 0.0, 1.0))
            sim.step()
        seen = lidars.update(sim.sense("scout"))
        assert seen is not None
        _, y = sim.truth("scout").transform(seen.points()).T
    side = np.minimum(np.abs(y - 0.05), np.abs(y - 3.95))[(y < 0.4) | (y > 3.6)]
    # A revolution takes 80 ms, in which the robot turns by 4.6 degrees; odometry errs by 0.2 degrees meanwhile.
    assert np.median(side) < 0.01 if deskew else np.median(side) > 0.03
