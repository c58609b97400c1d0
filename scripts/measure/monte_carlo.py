#!/usr/bin/env python3
"""Drive shipped robots through the maze with its map, and print how sure `MonteCarloLocalization` is of where they are.

    .venv/bin/python scripts/measure/monte_carlo.py [PRESET ...] [--noise 0.5 2] [--lidar far near] [--seeds 3]

Odometry errs by 2 % of the way and of the turn, times the factor, as it says. The lidar `far` sees 8 m in 270 degrees,
`near` 3.5 m all around with a noise of 1.5 cm, as cheap ones do. A row has the mean and largest position error, and the
mean and median NEES over the seeds, for which 3 is right; `--weight` is that of the estimator.
"""

import argparse
from itertools import product
from pathlib import Path

import numpy as np

import mjsim
from mjsim.algorithms.monte_carlo import MonteCarloLocalization
from mjsim.algorithms.waypoints import Waypoints
from mjsim.geometry import Array, wrap_angle
from mjsim.world import World, with_settings

MAZE = Path(__file__).resolve().parents[2] / "worlds" / "maze.yaml"
LIDARS = {
    "far": "beams: 180, fov_deg: 270, range: [0.05, 8], noise: {range: 0.01}",
    "near": "beams: 360, fov_deg: 360, range: [0.12, 3.5], rate_hz: 5, noise: {range: 0.015}",
}
WAY = [(1.8, 0.6), (1.8, 1.8), (0.6, 1.8), (0.6, 3), (3, 3), (3, 5.4), (10.2, 5.4), (10.2, 6.6), (4.2, 6.6)]
ROBOTS = ("pioneer3dx", "create3", "turtlebot3_burger", "turtlebot3_waffle")


def main() -> None:
    """Print a row for each robot, lidar and noise of odometry."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("robots", nargs="*", default=ROBOTS)
    parser.add_argument("--noise", nargs="+", type=float, default=[0.5, 2.0])
    parser.add_argument("--lidar", nargs="+", choices=LIDARS, default=list(LIDARS))
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--weight", type=float, default=12.0)
    given = parser.parse_args()
    print("robot              lidar noise   error: mean, largest [m]   NEES: mean, median")
    for robot, lidar, noise in product(given.robots, given.lidar, given.noise):
        world = prepared(robot, lidar, noise)
        found = [driven(world, seed, given.seconds, given.weight) for seed in range(1, given.seeds + 1)]
        errors, nees = np.concatenate(found).T
        figures = f"{errors.mean():14.3f} {errors.max():7.3f} {nees.mean():16.1f} {np.median(nees):6.1f}"
        print(f"{robot:<19}{lidar:<5}{noise:5.1f} {figures}", flush=True)


def prepared(robot: str, lidar: str, noise: float) -> World:
    """Return the maze with another robot in it."""
    scout = f"{{name: theseus, preset: {robot}, at: [0.6, 0.6], drive: {{noise: {{speed: 0.02, turn: 0.02}}}}, "
    scout += f"odometry: {{noise: {{distance: {0.02 * noise}, turn: {0.02 * noise}}}}}, "
    scout += f"sensors: [{{lidar: scan, at: [0, 0, 0.3], {LIDARS[lidar]}}}]}}"
    return with_settings(mjsim.load_world(MAZE), [f"robots=[{scout}]", "run.drivers={}"])


def driven(world: World, seed: int, seconds: float, weight: float) -> Array:
    """Return the position error [m] and the NEES of each tick of a drive, shape (n, 2)."""
    rows: list[tuple[float, float]] = []
    estimator = MonteCarloLocalization(lidar="scan", weight=weight)
    driver = mjsim.Driver(estimator=estimator, navigator=Waypoints(WAY, speed=0.3, lookahead=0.35))
    with mjsim.Simulation(world, seed=seed) as sim:
        for tick in mjsim.ticks(sim, {"theseus": driver}):
            belief = tick.orders["theseus"].estimate
            off = belief.pose.as_array() - tick.truth["theseus"].as_array()
            off[2] = wrap_angle(float(off[2]))
            rows.append((np.hypot(*off[:2]), off @ np.linalg.solve(belief.covariance, off)))
            if tick.time > seconds:
                break
    return np.array(rows)


if __name__ == "__main__":
    main()
