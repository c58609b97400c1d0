#!/usr/bin/env python3
"""Compare SLAM with named landmarks with the textbook's in rooms and logs, and after pushes, slips, faults.

Each cell: mean error and its ratio to that of TextbookEkfSlam; the mean error of the final trajectory, if there is one;
mean NEES; the longest time surely wrong, and how long the robot said that it is lost. With a lidar there is no ratio.
"""

import argparse

import numpy as np

import mjsim.algorithms
from mjsim.bench import disturbed, disturbed_scans
from mjsim.bench.disturbed import CASES, Errors
from mjsim.interface import Estimator

NAMES = ("TextbookEkfSlam", "TextbookFastSlam", "EkfSlam", "GraphSlam", "FastSlam", "FilterpySlam")
BY_SCANS = ("LidarSlam", "MonteCarloLocalization")


def cell(runs: list[Errors], book: list[Errors] | None = None) -> str:
    """Return the text of a cell of the table, over some runs."""
    error = np.mean([run.position.mean() for run in runs])
    ratio = f" ({error / np.mean([run.position.mean() for run in book]):.2f})" if book else ""
    path = np.mean([run.path for run in runs])
    final = "" if np.isnan(path) else f"; {path:.3f} m"
    nees, lost = np.mean([run.nees.mean() for run in runs]), np.mean([run.seconds_lost() for run in runs])
    wrong = max(run.longest_wrong() for run in runs)
    return f"{error:.3f} m{ratio}{final}; {min(nees, 9999):.1f}; {wrong:.1f} s; {lost:.1f} s"


def _made(names: list[str]) -> dict[str, Estimator]:
    return {name: getattr(mjsim.algorithms, name)() for name in names}


def main() -> None:
    """Print tables in Markdown."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--estimators", nargs="+", default=NAMES, choices=(*NAMES, *BY_SCANS))
    parser.add_argument("--cases", nargs="+", help="rooms, faults and disturbances; all by default")
    asked = parser.parse_args()
    names = [name for name in NAMES if name in asked.estimators]
    if names:
        print("| |", " | ".join(names), "|\n|---|" + "---|" * len(names))
    for case, (room, disturbance) in CASES.items() if names else ():
        if asked.cases and case not in asked.cases:
            continue
        made = dict.fromkeys([NAMES[0], *names])
        runs = [disturbed.drive(_made(list(made)), seed, disturbance, room=room) for seed in range(asked.seeds)]
        book = [run[NAMES[0]] for run in runs]
        print(f"| {case} |", " | ".join(cell([run[name] for run in runs], book) for name in names), "|", flush=True)
    names = [name for name in BY_SCANS if name in asked.estimators]
    if names:
        print("| |", " | ".join(names), "|\n|---|" + "---|" * len(names))
    for case, disturbance in {"nothing": None, **disturbed_scans.DISTURBED}.items() if names else ():
        if asked.cases and case not in asked.cases:
            continue
        runs = [disturbed_scans.drive(_made(names), seed, disturbance) for seed in range(asked.seeds)]
        print(f"| {case} |", " | ".join(cell([run[name] for run in runs]) for name in names), "|", flush=True)


if __name__ == "__main__":
    main()
