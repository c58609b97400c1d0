#!/usr/bin/env python3
"""Drive through the office and the warehouse with a 3-D lidar: points a second, and how far KISS-ICP is off.

For instance `.venv/bin/python scripts/measure/clouds.py`; the project asks for 300,000 points a second through `sense`
in the office with motion, noise, intensity and recording, and for an error of KISS-ICP below 0.1 % of the way.

Poses are compared when a cloud is complete, which is the time that KISS-ICP straightens it to. The error is told four
ways: where the drive ends and where it is largest, both from the true first pose on without alignment; as the root of
the mean square after rigid alignment (ATE); and over parts of the way, as KITTI and KISS-ICP's authors do.

References:
    Vizzo et al., KISS-ICP: In Defense of Point-to-Point ICP, RA-L 8(2), 2023.
    Koide, small_gicp: Efficient and parallel algorithms for point cloud registration, JOSS 9(100), 2024.
"""

import argparse
import tempfile
import time
from collections.abc import Iterator
from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from unittest.mock import patch

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

import mjsim
from mjsim.geometry import Array
from mjsim.sim.batch_rays import BatchRays
from mjsim.sim.rays import RayHits
from mjsim.world import sensors, with_settings

WORLDS = Path(__file__).resolve().parents[2] / "worlds"
ROUND = [
    "run.drivers.post.navigator.goals=[[8.5, 3.2], [16, 9.2], [22, 6], [30.3, 9.2], [33.5, 6.2], [1.2, 6.2]]",
    "run.seconds=165",
]
"""The office's drive goes on into another room, to the far end of the corridor and back along it."""
FARTHEST, VOXEL = 50.0, 0.5
"""What KISS-ICP looks at, and how coarse its map is [m]; its authors advise this for rooms (PRBonn/kiss-slam #17)."""
WAYS = ("itself", "odometry", "truth", "nobody")
"""Who straightens the clouds of KISS-ICP."""
PARTS = (10.0, 25.0, 50.0, 100.0)
"""Lengths of way over which the motion is compared [m]."""
FINE = 0.1
"""What small_gicp thins a cloud to [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Drive:
    """What one drive gave."""

    clouds: list[mjsim.PointCloud]
    poses: Array
    """world_from_sensor when each cloud was complete, shape (n, 4, 4) [m]."""
    times: Array
    """Of each tick, shape (m,) [s]."""
    ticks: Array
    """world_from_sensor at each tick, shape (m, 4, 4) [m]."""
    odometry: Array
    """Where the sensor is by odometry at each tick, from where the robot began, shape (m, 4, 4) [m]."""
    seconds: float
    """The processor's time of the loop, all threads [s]."""


def world_with(world: mjsim.World, *lidars: sensors.Lidar3d) -> mjsim.World:
    """Return a world whose first robot carries these in place of its cameras."""
    robot, *others = world.robots
    kept = [sensor for sensor in robot.sensors if not isinstance(sensor, sensors.Camera)]
    return world.model_copy(update={"robots": (robot.model_copy(update={"sensors": (*kept, *lidars)}), *others)})


def drive(world: mjsim.World, seconds: float | None, seed: int, *, record: bool, shake: float = 0.0) -> Drive:
    """Run a world as it says, with a recording if asked, and keep the clouds; the lidar may shake [degrees]."""
    clouds: list[mjsim.PointCloud] = []
    poses: list[Array] = []
    times: list[float] = []
    ticks: list[Array] = []
    odometry: list[Array] = []
    robot = world.robots[0].name
    shaking = patch.object(BatchRays, "cast", Shaken(shake)) if shake else nullcontext()
    with shaking, mjsim.Simulation(world, seed=seed) as sim, tempfile.TemporaryDirectory() as place:
        top = sim.robots[robot].sensors.get("top")
        mount = np.eye(4) if top is None else top.robot_from_sensor

        def keep(tick: mjsim.Tick) -> None:
            times.append(tick.time)
            ticks.append(sim.pose(robot) @ mount)
            odometry.append((odometry[-1] if odometry else np.eye(4)) @ moved(tick.seen[robot].odometry))
            for cloud in tick.seen[robot].clouds.values():
                clouds.append(cloud)
                poses.append(ticks[-1])

        began = time.process_time()
        mjsim.run(sim, seconds=seconds, record=Path(place) / "run.mcap" if record else None, watch=keep)
        spent = time.process_time() - began
    return Drive(clouds, np.array(poses), np.array(times), np.array(ticks), np.array(odometry) @ mount, spent)


def by_rings(cloud: mjsim.PointCloud) -> mjsim.PointCloud:
    """Return a cloud ring by ring, the highest first, which is the order of Ouster's software and of its ROS driver.

    KISS-ICP keeps the first point of each voxel, so that the order matters.
    """
    order = np.lexsort((cloud.times, -cloud.rings.astype(int)))
    columns = {key: getattr(cloud, key)[order] for key in ("points", "times", "intensities", "rings")}
    return replace(cloud, **columns)


class Shaken:
    """Rays of a lidar that rolls and pitches at random, the same angle for a whole revolution; level at first."""

    def __init__(self, degrees: float) -> None:
        """Initialise with the standard deviation of roll and of pitch [degrees]."""
        self._degrees, self._random, self._cast = degrees, np.random.default_rng(5), BatchRays.cast
        self._level = True

    def cast(self, rays: BatchRays, beams: Array, states: Array, *, limit: float) -> RayHits:
        """Return the hits of a revolution; takes the place of `BatchRays.cast`."""
        tilt = np.append(self._degrees * self._random.standard_normal(2) * (not self._level), 0.0)
        self._level = False
        return self._cast(rays, beams @ Rotation.from_rotvec(tilt, degrees=True).as_matrix().T, states, limit=limit)

    def __get__(self, rays: BatchRays, _: type) -> partial[RayHits]:
        """Bind as a method is bound."""
        return partial(self.cast, rays)


def moved(odometry: mjsim.Odometry) -> Array:
    """Return what odometry tells of a tick as a rigid motion, shape (4, 4) [m]."""
    motion = np.eye(4)
    motion[:3, :3] = Rotation.from_euler("z", odometry.turn).as_matrix()
    motion[:2, 3] = odometry.forward, odometry.left
    return motion


def as_measured(found: Drive) -> Iterator[Array]:
    """Yield the points of each cloud, each in the frame of its own time [m]."""
    for cloud in found.clouds:
        yield cloud.points.astype(float)


def straightened(found: Drive, ticks: Array) -> Iterator[Array]:
    """Yield the points of each cloud in the frame of its stamp [m], by where the sensor was at each tick."""
    turns, places = Slerp(found.times, Rotation.from_matrix(ticks[:, :3, :3])), ticks[:, :3, 3]
    for cloud in found.clouds:
        times, which = np.unique(cloud.times, return_inverse=True)
        stamps = np.clip(cloud.stamp + np.append(times, 0.0), found.times[0], found.times[-1])
        at = np.stack([np.interp(stamps, found.times, axis) for axis in places.T], axis=-1)
        turned = turns(stamps).as_matrix()
        p_fixed = np.einsum("nij,nj->ni", turned[which], cloud.points) + at[which]
        yield (p_fixed - at[-1]) @ turned[-1]


def kiss_path(found: Drive, *, voxel: float, straighten: str, double: bool) -> Array:
    """Return where KISS-ICP has the sensor at each cloud, frame of the first one, shape (n, 4, 4) [m].

    Args:
        found: The drive.
        voxel: Of its map [m].
        straighten: Who straightens the clouds: KISS-ICP `itself`, the robot's `odometry`, the `truth`, or `nobody`.
        double: Thin what is matched a second time, as it does unless changed; its authors advise against that for an
            OS0 indoors (PRBonn/kiss-icp #128) and for lidars of few rings (#240).
    """
    from kiss_icp.config import KISSConfig
    from kiss_icp.kiss_icp import KissICP
    from kiss_icp.voxelization import voxel_down_sample

    class Once(KissICP):
        def voxelize(self, iframe: Array) -> tuple[Array, Array]:
            thin = voxel_down_sample(iframe, self.config.mapping.voxel_size * 0.5)
            return thin, thin

    config = KISSConfig()
    config.data.max_range, config.mapping.voxel_size = FARTHEST, voxel
    config.data.deskew, config.registration.max_num_threads = straighten == "itself", 1
    kiss, poses = (KissICP if double else Once)(config), []
    ways = {"odometry": found.odometry, "truth": found.ticks}
    clouds = straightened(found, ways[straighten]) if straighten in ways else as_measured(found)
    for points, cloud in zip(clouds, found.clouds, strict=True):
        kiss.register_frame(points, cloud.times.astype(float))
        poses.append(kiss.last_pose)
    return np.array(poses)


def gicp_path(found: Drive, *, voxel: float) -> Array:
    """Return where small_gicp has the sensor, as `kiss_path`: matched to a map of Gaussians, one a voxel.

    The true motion straightens the clouds: what is left is what the clouds and the matcher are off.
    """
    import small_gicp

    near = small_gicp.GaussianVoxelMap(voxel)
    near.set_lru(horizon=len(found.clouds))  # It forgets nothing.
    pose, ahead, poses = np.eye(4), np.eye(4), []
    for points in straightened(found, found.ticks):
        thin, _ = small_gicp.preprocess_points(points, downsampling_resolution=FINE, num_neighbors=10, num_threads=1)
        if poses:
            now = small_gicp.align(near, thin, pose @ ahead, 1.0, 1).T_target_source
            pose, ahead = now, np.linalg.inv(pose) @ now
        near.insert(thin, pose)
        poses.append(pose)
    return np.array(poses)


def errors(found: Drive, path: Array) -> str:
    """Return the length of the way, and how far a path is off: in the end, at most, aligned, and over parts."""
    places = (found.poses[0] @ path)[:, :3, 3]
    truth = found.poses[:, :3, 3]
    off = 1e3 * np.linalg.norm(places - truth, axis=1)
    gone = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(truth[:, :2], axis=0), axis=1)))
    way, aligned = gone[-1], 1e3 * aligned_error(places, truth)
    parts = ", ".join(
        f"{part:.0f} m {relative_error(path, found.poses, gone, part):.3%}" for part in PARTS if part < 0.9 * way
    )
    return (
        f"way {way:.1f} m, error at the end {off[-1]:.0f} mm: {off[-1] / way / 1e3:.3%} of the way, largest "
        f"{off.max():.0f} mm, ATE {aligned:.0f} mm: {aligned / way / 1e3:.3%}, over parts of {parts}"
    )


def relative_error(path: Array, truth: Array, gone: Array, part: float) -> float:
    """Return the mean error of the motion over all parts of a way, as a share of their length.

    Args:
        path: Estimated poses, shape (n, 4, 4) [m].
        truth: True poses, shape (n, 4, 4) [m].
        gone: How far the robot has gone at each, shape (n,) [m].
        part: The length of a part [m].

    References:
        Geiger, Lenz, Urtasun, Are we ready for autonomous driving? The KITTI vision benchmark suite (CVPR 2012).
    """
    ends = np.searchsorted(gone, gone + part)
    starts = np.flatnonzero(ends < len(gone))
    ends = ends[starts]
    told, true = np.linalg.inv(path[starts]) @ path[ends], np.linalg.inv(truth[starts]) @ truth[ends]
    off = np.linalg.inv(told) @ true
    return float(np.linalg.norm(off[:, :3, 3], axis=1).mean() / part)


def aligned_error(found: Array, truth: Array) -> float:
    """Return the root mean square between points, shape (n, 3), and true ones after rigid alignment [m]."""
    centred, true = found - found.mean(axis=0), truth - truth.mean(axis=0)
    turn, _ = Rotation.align_vectors(true, centred)
    return float(np.sqrt(np.mean(np.sum((turn.apply(centred) - true) ** 2, axis=1))))


def options() -> argparse.Namespace:
    """Return what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("worlds", nargs="*", default=["office", "warehouse"])
    parser.add_argument("--seeds", type=int, nargs="+", default=[1], help="one drive each")
    parser.add_argument("--lidar", default="ouster-os0-128", help="preset of the 3-D lidar")
    parser.add_argument("--columns", type=int, default=512, help="of the lidar in a turn; the fewest of an OS0")
    parser.add_argument("--height", type=float, default=1.2, help="of the lidar above the floor [m]")
    parser.add_argument("--reach", type=float, help="of the lidar, as its preset says unless given [m]")
    parser.add_argument("--short", action="store_true", help="the office's own drive, in place of a round through it")
    parser.add_argument("--seconds", type=float, help="how long each drive is; as its world says unless given")
    parser.add_argument("--noiseless", action="store_true", help="ranges without noise")
    parser.add_argument("--pace", action="store_true", help="drive once more without the lidar, for points a second")
    parser.add_argument(
        "--matchers", nargs="+", choices=[*(f"kiss-{way}" for way in WAYS), "gicp"], default=["kiss-itself"]
    )
    parser.add_argument("--voxel", type=float, default=VOXEL, help="of the map [m]")
    parser.add_argument(
        "--thin", type=int, nargs="+", choices=(1, 2), default=[1], help="how often KISS-ICP thins what it matches"
    )
    parser.add_argument("--order", choices=("rings", "firing"), help="of the points; rings for an Ouster")
    parser.add_argument("--shake", type=float, default=0.0, help="roll and pitch of the lidar at random [degrees]")
    return parser.parse_args()


def paths(found: Drive, given: argparse.Namespace) -> Iterator[tuple[str, Array]]:
    """Yield the name of each matcher that is asked for, and where it has the sensor."""
    for matcher in given.matchers:
        kiss, _, way = matcher.partition("-")
        if kiss == "gicp":
            yield matcher, gicp_path(found, voxel=given.voxel)
            continue
        for thin in given.thin:
            name = f"{matcher}, thinned {'once' if thin == 1 else 'twice'}"
            yield name, kiss_path(found, voxel=given.voxel, straighten=way, double=thin == 2)


def main() -> None:
    """Print the points of each drive, and a row a matcher."""
    given = options()
    keys = {"noise": {"range": 0.0}} if given.noiseless else {}
    keys |= {"range": (0.3, given.reach)} if given.reach else {}
    lidar = sensors.Lidar3d(
        lidar3d="top", preset=given.lidar, columns=given.columns, at=(0.0, 0.0, given.height), **keys
    )
    order = given.order or ("rings" if given.lidar.startswith("ouster") else "firing")
    for name in given.worlds:
        world = mjsim.load_world(WORLDS / f"{name}.yaml")
        if name == "office" and not given.short:
            world = with_settings(world, ROUND)
        for seed in given.seeds:
            found = drive(world_with(world, lidar), given.seconds, seed, record=given.pace, shake=given.shake)
            points = sum(len(cloud.points) for cloud in found.clouds)
            print(f"{name}, seed {seed}: {points:,} points", flush=True)
            if given.pace:
                without = drive(world_with(world), given.seconds, seed, record=True)
                pace = points / (found.seconds - without.seconds)
                print(f"    {pace:,.0f} points a second of the processor, with recording", flush=True)
            if order == "rings":
                found = replace(found, clouds=[by_rings(cloud) for cloud in found.clouds])
            for matcher, path in paths(found, given):
                print(f"    {matcher:27s} {errors(found, path)}", flush=True)


if __name__ == "__main__":
    main()
