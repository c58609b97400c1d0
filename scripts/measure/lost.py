#!/usr/bin/env python3
"""Print how SLAM with named landmarks does after a push, a slip or a kidnapping, beside the textbook's."""

import argparse

import numpy as np

import mjsim.algorithms
from mjsim.bench.disturbed import DISTURBED, Errors, drive

NAMES = ("TextbookEkfSlam", "TextbookFastSlam", "EkfSlam", "FastSlam", "GraphSlam")


def cell(runs: list[Errors]) -> str:
    """Return the error of the last 10 s [m], the NEES then, and the seconds surely wrong and said to be lost."""
    last = [run.time > run.time[-1] - 10.0 for run in runs]
    error = np.mean([run.position[end].mean() for run, end in zip(runs, last, strict=True)])
    nees = np.mean([run.nees[end].mean() for run, end in zip(runs, last, strict=True)])
    wrong, lost = np.mean([run.surely_wrong() for run in runs]), np.mean([run.seconds_lost() for run in runs])
    return f"{error:.2f} m; {min(nees, 9999):.0f}; {wrong:.1f} s; {lost:.1f} s"


def main() -> None:
    """Print a table in Markdown."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--estimators", nargs="+", default=NAMES, choices=NAMES)
    asked = parser.parse_args()
    print("| |", " | ".join(asked.estimators), "|")
    print("|---|" + "---|" * len(asked.estimators))
    for case, disturbance in {"nothing": None, **DISTURBED}.items():
        runs = [
            drive({name: getattr(mjsim.algorithms, name)() for name in asked.estimators}, seed, disturbance)
            for seed in range(asked.seeds)
        ]
        print(
            f"| {case} |", " | ".join(cell([run[name] for run in runs]) for name in asked.estimators), "|", flush=True
        )


if __name__ == "__main__":
    main()
