"""Print what every shipped estimator makes of real logs: one table a robot, one row an estimator.

    python scripts/measure/logs.py MRCLAM_Dataset7 intel.clf --seconds 400

A log is whatever `mjsim import-log` takes. Figures are those of `mjsim report`: the position error after rigid
alignment (root mean square) online and, where an estimator offers one, of its final path; the mean error without
alignment; the share of ticks whose NEES is in its 95 % band. A log without ground truth has none of these, and its
rows say how far the estimate ends from where dead reckoning does. What fails says why in one line.
"""

import argparse
import os
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np

import mjsim
from mjsim.algorithms.ekf_slam import EkfSlam
from mjsim.algorithms.fastslam import FastSlam
from mjsim.algorithms.filterpy_slam import FilterpySlam
from mjsim.algorithms.graph_slam import GraphSlam
from mjsim.algorithms.lidar_slam import LidarSlam
from mjsim.interface import Estimator
from mjsim.logs import Wishes

EKF_VARIANTS = ("standard", "first-estimates", "invariant")
OTHERS: Mapping[str, Callable[[], Estimator]] = {
    "FilterpySlam": FilterpySlam,
    "FastSlam": FastSlam,
    "GraphSlam": GraphSlam,
}
"""These need names of landmarks."""


def estimators(log: mjsim.Recording, robot: str) -> dict[str, Callable[[], Estimator]]:
    """Return what suits that which a robot of a log senses."""
    sensors = next(each.sensors for each in log.world.robots if each.name == robot)
    if any(sensor.kind == "lidar" for sensor in sensors):
        return {"LidarSlam": LidarSlam}
    named = any(sighting.name for seen in log.robots[robot].sightings for sighting in seen)
    pairing: Literal["known", "joint"] = "known" if named else "joint"
    ekf = {f"EkfSlam, {kind}": partial(EkfSlam, jacobians=kind, association=pairing) for kind in EKF_VARIANTS}
    return ekf | (dict(OTHERS) if named else {})


def rows(log: mjsim.Recording, robot: str) -> Iterator[str]:
    """Yield the row of each estimator that suits what a robot of a log senses, and of dead reckoning."""
    yield f"| dead reckoning | {figures(log, robot, 'odometry_')} |"
    for name, make in estimators(log, robot).items():
        try:
            replayed = mjsim.replay(log, robot=robot, estimator=make())
        except mjsim.MjsimError as error:
            yield f"| {name} | fails: {error} | | | |"
        else:
            yield f"| {name} | {figures(replayed, robot)} |"


def figures(recording: mjsim.Recording, robot: str, kind: str = "") -> str:
    """Return the cells of one row."""
    own = mjsim.statistics(recording)[robot]
    online, path = own.get(f"{kind}ate_m") or {}, own.get("path_ate_m") or {} if not kind else {}
    if not online:
        track = recording.robots[robot]
        if kind:
            return "no truth | | | "
        apart = track.estimate[-1, :2] - track.odometry[-1, :2]
        return f"no truth; ends {np.hypot(*apart):.1f} m from dead reckoning | | |"
    nees = own.get("nees") or {}
    error = (own.get(f"{kind}error_m" if kind else "position_error_m") or {}).get("mean")
    return f"{_number(online.get('rmse'))} | {_number(path.get('rmse'))} | {_number(error)} | {_share(nees, kind)}"


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.2f}"


def _share(nees: Mapping[str, float], kind: str) -> str:
    return "" if kind or nees.get("in_band") is None else f"{nees['in_band']:.0%}"


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("logs", nargs="+", type=Path, help="files or folders")
    parser.add_argument("--seconds", type=float, help="of the beginning of each; all unless given")
    given = parser.parse_args()
    for place in given.logs:
        log = mjsim.import_log(place, wishes=Wishes(seconds=given.seconds))
        for robot in log.robots:
            print(f"\n**{place.stem}, {robot}**\n")
            print("| estimator | aligned [m] | its path [m] | unaligned [m] | NEES in band |\n|---|---|---|---|---|")
            for row in rows(log, robot):
                print(row, flush=True)


if __name__ == "__main__":
    os.environ |= {"OMP_NUM_THREADS": "1"}
    main()
