#!/usr/bin/env python3
"""Tour the office with `LidarSlam` from scans alone: it is told nothing of the motion. One row for each lidar.

For instance `.venv/bin/python scripts/measure/scan_odometry.py --seeds 2`. The robot finds its way by another LidarSlam
that has its odometry, so that both see the same scans.
"""

import argparse
import time
from dataclasses import replace

import numpy as np
from lidar_slam import OFFICE, TOUR

import mjsim
from mjsim.algorithms.lidar_slam import LidarSlam
from mjsim.algorithms.waypoints import Waypoints
from mjsim.geometry import Array
from mjsim.interface import Odometry
from mjsim.world import with_settings

LIDARS = {
    "360 degrees, 10 m, 5 Hz": "beams: 360, fov_deg: 360, range: [0.05, 10], rate_hz: 5, noise: {range: 0.02}",
    "360 degrees, 10 m, 12.5 Hz": "beams: 360, fov_deg: 360, range: [0.05, 10], rate_hz: 12.5, noise: {range: 0.02}",
    "270 degrees, 30 m, 25 Hz": "beams: 1081, fov_deg: 270, range: [0.05, 30], rate_hz: 25, noise: {range: 0.02}",
    "180 degrees, 30 m, 12.5 Hz": "beams: 181, fov_deg: 180, range: [0.05, 30], rate_hz: 12.5, noise: {range: 0.02}",
}
IMU = "{imu: imu, rate_hz: 125}"
"""Makes the turn known."""
LONGEST = 420.0
"""When a tour that does not come to its end is given up [s]."""


def drive(lidar: str, seed: int, *, has_imu: bool) -> tuple[Array, float]:
    """Return the position error at each tick (n,) [m], and the processor's time for each tick with a scan [s]."""
    sensors = f"{{lidar: scan, at: [0.12, 0, 0.3], {lidar}}}" + (f", {IMU}" if has_imu else "")
    world = with_settings(mjsim.load_world(OFFICE), [f"robots.post.sensors=[{sensors}]", "run.map=unknown"])
    blind, still, errors, used, scans = LidarSlam(), 0, [], 0.0, 0
    with mjsim.Simulation(world, seed=seed) as sim:
        unknown = Odometry(0.0, 0.0, 0.0, sim.dt * np.eye(3))
        blind.start(sim.robots["post"], {}, np.random.default_rng(seed))
        driver = mjsim.Driver(estimator=LidarSlam(), navigator=Waypoints(TOUR, speed=0.6), avoidance=True)
        for tick in mjsim.ticks(sim, {"post": driver}):
            seen, truth, order = tick.seen["post"], tick.truth["post"], tick.orders["post"]
            began = time.process_time()
            pose = blind.update(replace(seen, odometry=unknown)).pose
            used, scans = used + time.process_time() - began, scans + len(seen.scans)
            errors.append(np.hypot(pose.x - truth.x, pose.y - truth.y))
            still = 0 if order.command != mjsim.Command() else still + 1
            if still > 50 or tick.time > LONGEST:
                break
    return np.array(errors), used / scans


def main() -> None:
    """Print a row for each lidar."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=1)
    given = parser.parse_args()
    print(f"{'lidar':32} {'seed':>4} {'mean':>7} {'worst':>7} {'ms':>5}   [m]")
    for name, lidar in LIDARS.items():
        for has_imu in (False, True):
            for seed in range(1, given.seeds + 1):
                errors, used = drive(lidar, seed, has_imu=has_imu)
                title = name + (" + IMU" if has_imu else "")
                print(f"{title:32} {seed:4} {errors.mean():7.3f} {errors.max():7.3f} {1e3 * used:5.1f}", flush=True)


if __name__ == "__main__":
    main()
