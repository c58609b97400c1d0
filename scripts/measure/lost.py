#!/usr/bin/env python3
"""Print how SLAM with named landmarks, beside the textbook's, and with a lidar does after a push, slip or carry."""

import argparse

import numpy as np

import mjsim.algorithms
from mjsim.bench import disturbed, disturbed_scans
from mjsim.bench.disturbed import Errors

NAMES = ("TextbookEkfSlam", "TextbookFastSlam", "EkfSlam", "FastSlam", "GraphSlam")
BY_SCANS = ("LidarSlam", "MonteCarloLocalization")


def cell(runs: list[Errors]) -> str:
    """Return the error of the last 10 s [m], NEES then and of the run, and the seconds surely wrong and lost."""
    last = [run.time > run.time[-1] - 10.0 for run in runs]
    error = np.mean([run.position[end].mean() for run, end in zip(runs, last, strict=True)])
    nees = np.mean([run.nees[end].mean() for run, end in zip(runs, last, strict=True)])
    wrong, lost = np.mean([run.surely_wrong() for run in runs]), np.mean([run.seconds_lost() for run in runs])
    whole = np.mean([run.nees.mean() for run in runs])
    return f"{error:.2f} m; {min(nees, 9999):.0f}; {min(whole, 9999):.0f}; {wrong:.1f} s; {lost:.1f} s"


def main() -> None:
    """Print a table in Markdown."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--estimators", nargs="+", default=NAMES, choices=(*NAMES, *BY_SCANS))
    asked = parser.parse_args()
    for names, room in ((NAMES, disturbed), (BY_SCANS, disturbed_scans)):
        chosen = [name for name in asked.estimators if name in names]
        if chosen:
            print("| |", " | ".join(chosen), "|\n|---|" + "---|" * len(chosen))
            for case, disturbance in {"nothing": None, **room.DISTURBED}.items():
                runs = [
                    room.drive({name: getattr(mjsim.algorithms, name)() for name in chosen}, seed, disturbance)
                    for seed in range(asked.seeds)
                ]
                print(f"| {case} |", " | ".join(cell([run[name] for run in runs]) for name in chosen), "|", flush=True)


if __name__ == "__main__":
    main()
