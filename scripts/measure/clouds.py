#!/usr/bin/env python3
"""Drive through the office and the warehouse with a 3-D lidar: points a second, and how far KISS-ICP is off.

For instance `.venv/bin/python scripts/measure/clouds.py`; the project asks for 300,000 points a second through `sense`
in the office with motion, noise, intensity and recording, and for an error of KISS-ICP below 0.1 % of the way.

Poses are compared when a cloud is complete, which is the time that KISS-ICP straightens it to. The error is told three
ways: where the drive ends and where it is largest, both from the true first pose on without alignment, and as the root
of the mean square after rigid alignment (ATE).

References:
    Vizzo et al., KISS-ICP: In Defense of Point-to-Point ICP, RA-L 8(2), 2023.
"""

import argparse
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from kiss_icp.config import KISSConfig
from kiss_icp.kiss_icp import KissICP
from scipy.spatial.transform import Rotation

import mjsim
from mjsim.geometry import Array
from mjsim.world import sensors

WORLDS = Path(__file__).resolve().parents[2] / "worlds"
FARTHEST, VOXEL = 50.0, 0.5
"""What KISS-ICP looks at, and how coarse its map is [m]; its authors advise this for rooms (PRBonn/kiss-slam #17)."""


@dataclass(frozen=True, slots=True, eq=False)
class Drive:
    """What one drive gave."""

    clouds: list[mjsim.PointCloud]
    poses: Array
    """world_from_sensor when each cloud was complete, shape (n, 4, 4) [m]."""
    seconds: float
    """The processor's time of the loop, all threads [s]."""


def world_with(name: str, *lidars: sensors.Lidar3d) -> mjsim.World:
    """Return a shipped world whose first robot carries these in place of its cameras."""
    world = mjsim.load_world(WORLDS / f"{name}.yaml")
    robot, *others = world.robots
    kept = [sensor for sensor in robot.sensors if not isinstance(sensor, sensors.Camera)]
    return world.model_copy(update={"robots": (robot.model_copy(update={"sensors": (*kept, *lidars)}), *others)})


def drive(world: mjsim.World, seconds: float | None) -> Drive:
    """Run a world as it says, with a recording, and keep the clouds."""
    clouds: list[mjsim.PointCloud] = []
    poses: list[Array] = []
    robot = world.robots[0].name
    with mjsim.Simulation(world, seed=1) as sim, tempfile.TemporaryDirectory() as place:
        info = sim.robots[robot].sensors.get("top")

        def keep(tick: mjsim.Tick) -> None:
            for cloud in tick.seen[robot].clouds.values():
                clouds.append(cloud)
                poses.append(sim.pose(robot) @ info.robot_from_sensor)

        began = time.process_time()
        mjsim.run(sim, seconds=seconds, record=Path(place) / "run.mcap", watch=keep)
        return Drive(clouds, np.array(poses), time.process_time() - began)


def straightened(found: Drive) -> list[Array]:
    """Return the points of each cloud as the true motion since the last cloud has them, frame of its stamp [m]."""
    clouds = [found.clouds[0].points.astype(float)]
    for cloud, now, before in zip(found.clouds[1:], found.poses[1:], found.poses, strict=False):
        now_from_before = np.linalg.inv(now) @ before
        share = (cloud.times / cloud.times.min())[:, None]
        turned = Rotation.from_rotvec(share * Rotation.from_matrix(now_from_before[:3, :3]).as_rotvec())
        clouds.append(turned.apply(cloud.points.astype(float)) + share * now_from_before[:3, 3])
    return clouds


def kiss_errors(found: Drive, *, voxel: float, straighten: str) -> tuple[float, float, float, float]:
    """Return the length of the way, and the error of KISS-ICP with voxels of a size: largest, last, ATE [m].

    Args:
        found: The drive.
        voxel: Of its map [m].
        straighten: Who straightens the clouds: `kiss` itself, the `truth`, or `nobody`.
    """
    config = KISSConfig()
    config.data.max_range, config.mapping.voxel_size = FARTHEST, voxel
    config.data.deskew, config.registration.max_num_threads = straighten == "kiss", 1
    kiss, poses = KissICP(config), []
    clouds = straightened(found) if straighten == "truth" else [cloud.points.astype(float) for cloud in found.clouds]
    for points, cloud in zip(clouds, found.clouds, strict=True):
        kiss.register_frame(points, cloud.times.astype(float))
        poses.append(kiss.last_pose)
    places = found.poses[0] @ np.array(poses)
    errors = np.linalg.norm(places[:, :3, 3] - found.poses[:, :3, 3], axis=1)
    way = np.linalg.norm(np.diff(found.poses[:, :2, 3], axis=0), axis=1).sum()
    return float(way), float(errors.max()), float(errors[-1]), aligned_error(places[:, :3, 3], found.poses[:, :3, 3])


def aligned_error(found: Array, truth: Array) -> float:
    """Return the root mean square between points, shape (n, 3), and true ones after rigid alignment [m]."""
    centred, true = found - found.mean(axis=0), truth - truth.mean(axis=0)
    turn, _ = Rotation.align_vectors(true, centred)
    return float(np.sqrt(np.mean(np.sum((turn.apply(centred) - true) ** 2, axis=1))))


def main() -> None:
    """Print a row a world."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("worlds", nargs="*", default=["office", "warehouse"])
    parser.add_argument("--lidar", default="velodyne-vlp16", help="preset of the 3-D lidar; 2 m above the floor")
    parser.add_argument("--seconds", type=float, help="how long each drive is; as its world says unless given")
    parser.add_argument("--voxel", type=float, default=VOXEL, help="of the map of KISS-ICP [m]")
    parser.add_argument(
        "--straighten", choices=["kiss", "truth", "nobody"], default="kiss", help="who straightens the clouds"
    )
    given = parser.parse_args()
    lidar = sensors.Lidar3d(lidar3d="top", preset=given.lidar, at=(0.0, 0.0, 2.0))
    for name in given.worlds:
        found, without = drive(world_with(name, lidar), given.seconds), drive(world_with(name), given.seconds)
        points = sum(len(cloud.points) for cloud in found.clouds)
        pace = points / (found.seconds - without.seconds)
        way, largest, last, ate = kiss_errors(found, voxel=given.voxel, straighten=given.straighten)
        print(
            f"{name:10s} {points:,} points, {pace:,.0f} a second of the processor with recording   KISS-ICP: way "
            f"{way:.1f} m, largest error {1e3 * largest:.0f} mm, last {1e3 * last:.0f} mm: {last / way:.3%} of the way,"
            f" ATE {1e3 * ate:.0f} mm: {ate / way:.3%}",
            flush=True,
        )


if __name__ == "__main__":
    main()
