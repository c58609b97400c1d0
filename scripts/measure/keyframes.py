#!/usr/bin/env python3
"""What a scan that enters the map of `LidarSlam` costs on a recording, driven once and several times in a row.

    OMP_NUM_THREADS=1 .venv/bin/python scripts/measure/keyframes.py INTEL.mcap [--laps 2]

Prints, for each number of laps, how many scans entered the map, and the processor's time of one: mean, 99 % quantile,
worst [ms], with one BLAS thread. The recording is one of `mjsim import-log`; a lap begins where the one before ended.
"""

import argparse
import gc
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

import mjsim
from mjsim.algorithms.lidar_slam import LidarSlam
from mjsim.geometry import Array
from mjsim.interface import Observation, RobotInfo


def main() -> None:
    """Print a row for each number of laps."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path)
    parser.add_argument("--robot", default="robot")
    parser.add_argument("--laps", type=int, default=2)
    given = parser.parse_args()
    recording = mjsim.read_recording(given.run)
    seen = list(recording.observations(given.robot))
    with mjsim.Simulation(recording.world, seed=recording.seed) as sim:
        robot = sim.robots[given.robot]
    # The garbage collector must not look through the recording while the estimator works.
    gc.freeze()
    print("laps  scans   mean    99 %   worst [ms]   loops")
    for laps in range(1, given.laps + 1):
        with threadpool_limits(1, user_api="blas"):
            cost, loops = costs(robot, seen * laps)
        told = f"{1e3 * cost.mean():6.2f} {1e3 * np.quantile(cost, 0.99):7.2f} {1e3 * cost.max():7.2f}"
        print(f"{laps:4d} {len(cost):6d} {told} {loops:12d}", flush=True)


def costs(robot: RobotInfo, seen: Sequence[Observation]) -> tuple[Array, int]:
    """Return the processor's time of each tick that adds to the map [s], and how many loops are closed."""
    slam, found = LidarSlam(), []
    slam.start(robot, {}, np.random.default_rng(0))
    for each in seen:
        kept, began = len(slam.keyframes), time.process_time()
        slam.update(each)
        if len(slam.keyframes) > kept:
            found.append(time.process_time() - began)
    return np.array(found), slam.loops


if __name__ == "__main__":
    main()
