#!/usr/bin/env python3
"""Drive robots with poor odometry and a plain lidar through buildings, and print how well `LidarSlam` does in each.

    .venv/bin/python scripts/measure/lidar_buildings.py [BUILDING ...] [--seeds 1] [--odometry honest biased]
        [--lidar old wide] [--walkers 0 8]

The lidar is, unless told otherwise, that of old logs: `old`, 181 beams over 180 degrees, 5 scans a second, 30 m; others
are `fast` (the same 40 times a second), `wide` (541 beams over 270 degrees), `wide-fast` (both), `near` (`wide`, but
4 m) and `round` (360 beams all around, 12 m). Ranges come in whole centimetres. Walkers are people who go to and fro
along the robot's way, beside it. Odometry is

- `honest`: as its data sheet says,
- `biased`: 10 % too long, and turned by -0.3 degrees a second while the robot moves,
- `slips`: honest but for a slip every 40 s, in which the wheels turn by 0.3 m and 10 degrees and the robot does not,
- `noisy`: honest, but ranges err by 5 cm more, and 1 in 20 beams and a sector of 15 degrees somewhere see nothing,
- `sparse`: honest, but a scan comes each second only,
- `short`: honest, but the lidar sees no farther than 4 m,
- `cheap`: as `noisy` and `short`, and odometry 3 % too long and turned by 2 degrees a second,

and nobody tells the estimator. Each row has the mean and the largest position error of the final path and of the
estimate online, the ATE of the final path, that of odometry, NEES, loops, and the processor's time of a scan that
enters the map. Buildings: a tour of an office; a ring of corridors without doors; a corridor bare for 30 m;
a maze; a hall of pillars; a warehouse.
"""

import argparse
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, product
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

import mjsim
from mjsim.algorithms.lidar_slam import LidarSlam
from mjsim.algorithms.waypoints import Waypoints
from mjsim.geometry import Array, Pose, wrap_angle
from mjsim.interface import BeaconInfo, Estimate, Observation, RobotInfo
from mjsim.report.metrics import absolute_trajectory_errors
from mjsim.world import World, with_settings

WORLDS = Path(__file__).resolve().parents[2] / "worlds"
LIDAR = "{lidar: scan, at: [0.1, 0, 0.3], KIND, noise: {range: 0.01}}"
LIDARS = {
    "old": "beams: 181, fov_deg: 180, range: [0.05, 30], rate_hz: 5",
    "fast": "beams: 181, fov_deg: 180, range: [0.05, 30], rate_hz: 40",
    "wide": "beams: 541, fov_deg: 270, range: [0.05, 30], rate_hz: 5",
    "wide-fast": "beams: 541, fov_deg: 270, range: [0.05, 30], rate_hz: 40",
    "near": "beams: 541, fov_deg: 270, range: [0.05, 4], rate_hz: 5",
    "round": "beams: 360, fov_deg: 360, range: [0.05, 12], rate_hz: 5",
}
ASIDE = 0.6
"""How far from the robot's way people walk [m]."""
ROBOT = (
    "{name: scout, preset: pioneer3dx, at: AT, drive: {noise: {speed: 0.02, turn: 0.02}}, "
    "odometry: {noise: {distance: 0.01, turn: 0.02}}, sensors: [" + LIDAR + "]}"
)
RING = """
mjsim: 1
name: ring
walls:
  - {points: [[0, 0], [40, 0], [40, 25], [0, 25]], closed: true}
  - {points: [[2, 2], [38, 2], [38, 23], [2, 23]], closed: true}
"""
CORRIDOR = """
mjsim: 1
name: corridor
walls:
  - {points: [[0, 0], [44, 0], [44, 6], [38, 6], [38, 2.4], [6, 2.4], [6, 5], [0, 5]], closed: true}
obstacles: [{box: [0.8, 0.5, 1.0], at: [1, 4.2], heading_deg: 20}, {box: [1, 0.5, 1.0], at: [42.5, 4.5]}]
"""
PILLARS = """
mjsim: 1
name: pillars
walls: [{points: [[0, 0], [30, 0], [30, 20], [0, 20]], closed: true}]
obstacles: [{cylinder: [0.25, 2.0], at: [4, 4], repeat: [{times: 6, offset: [4.4, 0]}, {times: 4, offset: [0, 4]}]}]
"""
LONGEST = 420.0
"""When a drive that does not come to its end is given up [s]."""
BIASES = {"biased": (1.1, np.radians(-0.3)), "cheap": (1.03, np.radians(2.0))}
"""Of odometry: factor on lengths, and turn [rad/s]."""
SHORT = 4.0
"""As far as a short-sighted lidar sees [m]."""


@dataclass(frozen=True, slots=True)
class Building:
    """A world, and where a robot goes in it."""

    world: World
    start: tuple[float, float]
    points: Sequence[tuple[float, float]]


@dataclass(frozen=True, slots=True, eq=False)
class Drive:
    """What a robot sensed, and where it was."""

    robot: RobotInfo
    seen: list[Observation]
    truth: Array
    """Shape (N, 3)."""


class Told:
    """An estimator that is told the truth from outside, so that the robot gets where it should."""

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: np.random.Generator) -> None:
        """Keep what the module is told of the robot."""
        self.robot, self.pose = robot, robot.prior

    def update(self, seen: Observation) -> Estimate:
        """Return what it was told last."""
        return Estimate(self.pose, 1e-4 * np.eye(3))


def buildings() -> dict[str, Building]:
    """Return all buildings by their names."""
    rooms = [(4.6, 6.2), (4.6, 3.0), (4.6, 6.2), (11.8, 6.2), (11.8, 9.4), (11.8, 6.2), (22.6, 6.2), (22.6, 3.0)]
    rooms += [(22.6, 6.2), (33.5, 6.2), (1.2, 6.2)]
    lap = [(39.0, 1.0), (39.0, 24.0), (1.0, 24.0), (1.0, 1.0)]
    hall = [(28.0, 2.0), (28.0, 10.0), (15.0, 10.0), (15.0, 18.0), (2.0, 18.0), (2.0, 2.0), (28.0, 2.0), (28.0, 18.0)]
    aisles = [(29.0, 2.2), (29.0, 6.6), (5.0, 6.6), (5.0, 10.8), (56.0, 10.8), (56.0, 2.2), (3.0, 2.2)]
    maze = mjsim.maze_world((11, 9), seed=3)
    ways = [tuple(point) for point in maze.run.drivers["theseus"].navigator.model_extra["points"]]
    return {
        "office": Building(mjsim.load_world(WORLDS / "office.yaml"), (1.2, 6.2), rooms),
        "ring": Building(mjsim.parse_world(RING), (3.0, 1.0), lap + lap[:1]),
        "corridor": Building(mjsim.parse_world(CORRIDOR), (2.0, 1.2), [(42.0, 1.2), (2.0, 1.2)] * 2),
        "maze": Building(maze, (0.75, 0.75), [*ways, *ways[-2::-1]]),
        "pillars": Building(mjsim.parse_world(PILLARS), (2.0, 2.0), hall),
        "warehouse": Building(mjsim.load_world(WORLDS / "warehouse.yaml"), (3.0, 2.2), aisles),
    }


def prepared(building: Building, *, lidar: str = "old", walkers: int = 0) -> World:
    """Return a world with a robot in it that has one of the lidars, and with people who walk."""
    robot = ROBOT.replace("AT", str(list(building.start))).replace("KIND", LIDARS[lidar])
    rate = ["run.rate_hz=40", "run.step_ms=1"] if lidar.endswith("fast") else ["run.rate_hz=25"]
    settings = [f"robots=[{robot}]", "run.drivers={}", *rate]
    world = with_settings(building.world, settings)
    people = mjsim.parse_world(f"mjsim: 1\nname: people\nobstacles: [{', '.join(walks(building, walkers))}]\n")
    return world.model_copy(update={"obstacles": [*world.obstacles, *people.obstacles]})


def walks(building: Building, number: int) -> Iterator[str]:
    """Yield people who walk to and fro beside the robot's way, each along one stretch of it."""
    rng, points = np.random.default_rng(7), np.array([building.start, *building.points])
    stretches = [(a, b) for a, b in pairwise(points) if np.hypot(*(b - a)) > 2.0]
    for k in range(number):
        a, b = stretches[rng.integers(len(stretches))]
        ahead = (b - a) / np.hypot(*(b - a))
        aside = ASIDE * np.array([-ahead[1], ahead[0]]) * rng.choice([-1.0, 1.0])
        ends = np.round([b + aside - 0.5 * ahead, a + aside + 0.5 * ahead], 3).tolist()
        path = f"{{points: {ends}, speed: {rng.uniform(0.6, 1.3):.2f}}}"
        yield f"{{name: walker-{k}, cylinder: [0.2, 1.7], at: {ends[0]}, path: {path}}}"


def driven(world: World, points: Sequence[tuple[float, float]], *, seed: int) -> Drive:
    """Return what a robot senses on its way through a building."""
    told, seen, truth, still = Told(), [], [], 0
    driver = mjsim.Driver(estimator=told, navigator=Waypoints(points, speed=0.7), avoidance=True)
    with mjsim.Simulation(world, seed=seed) as sim:
        for tick in mjsim.ticks(sim, {"scout": driver}):
            told.pose = tick.truth["scout"]
            seen.append(tick.seen["scout"])
            truth.append(tick.truth["scout"].as_array())
            still = still + 1 if tick.orders["scout"].command == mjsim.Command() else 0
            if tick.time > LONGEST or still > 50:
                break
    return Drive(told.robot, seen, np.array(truth))


def spoilt(seen: Observation, kind: str) -> Observation:
    """Return an observation with ranges of whole centimetres and the odometry of a kind."""
    scans = {name: replace(scan, ranges=np.round(scan.ranges, 2)) for name, scan in seen.scans.items()}
    if kind in ("noisy", "cheap"):
        scans = {name: replace(scan, ranges=noisy(scan.ranges, seen.time)) for name, scan in scans.items()}
    if kind in ("short", "cheap"):
        scans = {name: replace(s, ranges=np.where(s.ranges < SHORT, s.ranges, np.inf)) for name, s in scans.items()}
    if kind == "sparse" and round(seen.time / seen.dt) % round(1.0 / seen.dt):
        scans = {}
    odometry = seen.odometry
    moves = abs(odometry.forward) + 0.1 * abs(odometry.turn) > 1e-4
    if kind in BIASES and moves:
        gain, turning = BIASES[kind]
        odometry = replace(odometry, forward=gain * odometry.forward, turn=odometry.turn + turning * seen.dt)
    if kind == "slips" and seen.time % 40.0 > 39.0:
        odometry = replace(
            odometry, forward=odometry.forward + 0.3 * seen.dt, turn=odometry.turn + np.radians(10.0) * seen.dt
        )
    return replace(seen, scans=scans, odometry=odometry)


def noisy(ranges: Array, time: float) -> Array:
    """Return ranges (n,) [m] that err by 5 cm more, and some beams that see nothing, other ones at each time."""
    rng = np.random.default_rng(round(1000 * time))
    sector = (np.arange(len(ranges)) - rng.integers(len(ranges))) % len(ranges) < len(ranges) // 12
    return np.where(sector | (rng.random(len(ranges)) < 0.05), np.inf, ranges + rng.normal(0.0, 0.05, len(ranges)))


def row(drive: Drive, kind: str) -> str:
    """Return what `LidarSlam` makes of a drive, as a line."""
    slam = LidarSlam()
    slam.start(drive.robot, {}, np.random.default_rng(0))
    online, nees, costs, reckoned = [], [], [], [drive.robot.prior]
    for seen, truth in zip(drive.seen, drive.truth, strict=True):
        seen, kept = spoilt(seen, kind), len(slam.keyframes)
        began = time.process_time()
        belief = slam.update(seen)
        if len(slam.keyframes) > kept:
            costs.append(time.process_time() - began)
        moved = seen.odometry
        reckoned.append(reckoned[-1] @ Pose(moved.forward, moved.left, moved.turn))
        off = belief.pose.as_array() - truth
        off[2] = wrap_angle(float(off[2]))
        online.append(np.hypot(*off[:2]))
        nees.append(off @ np.linalg.pinv(belief.covariance, hermitian=True) @ off)
    final = np.array([pose.as_array() for _, pose in slam.path()])
    errors = np.hypot(*(final - drive.truth)[:, :2].T)
    ate = [
        np.sqrt(np.mean(absolute_trajectory_errors(drive.truth, poses) ** 2))
        for poses in (final, np.array([pose.as_array() for pose in reckoned[1:]]))
    ]
    cost = 1e3 * np.array(costs)
    return (
        f"{errors.mean():6.3f} {errors.max():6.3f} {np.mean(online):7.3f} {np.max(online):6.3f} {ate[0]:6.3f} "
        f"{ate[1]:8.2f} {np.mean(nees):7.1f} {np.median(nees):7.2f} {slam.loops:6d} {len(cost):5d} "
        f"{cost.mean():6.1f} {cost.max():6.1f}"
    )


def main() -> None:
    """Print a row for each building, kind of odometry and seed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("buildings", nargs="*", choices=[[], *buildings()], help="all unless given")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--odometry", nargs="+", default=["honest", "biased", "slips"])
    parser.add_argument("--lidar", nargs="+", choices=LIDARS, default=["old"])
    parser.add_argument("--walkers", nargs="+", type=int, default=[0], help="how many people walk there")
    given = parser.parse_args()
    print("building  lidar  walkers odometry seed   final: mean, max, online: mean, max, ATE [m], of odometry,")
    print("                          NEES mean, median, loops, scans kept, a scan: mean, worst [ms]")
    for name, lidar, walkers in product(given.buildings or buildings(), given.lidar, given.walkers):
        building = buildings()[name]
        world = prepared(building, lidar=lidar, walkers=walkers)
        for seed in range(1, given.seeds + 1):
            drive = driven(world, building.points, seed=seed)
            for kind in given.odometry:
                with threadpool_limits(1, user_api="blas"):
                    figures = row(drive, kind)
                print(f"{name:<10}{lidar:<10}{walkers:3d}  {kind:<9}{seed:4d}  {figures}", flush=True)


if __name__ == "__main__":
    main()
