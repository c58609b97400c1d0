#!/usr/bin/env python3
"""Compare estimators with the textbook's in rooms, and print LidarSlam on real logs imported by `mjsim import-log`."""

import argparse

import numpy as np

import mjsim.algorithms
from mjsim.bench.relations import score_in_log
from mjsim.bench.slam_rooms import ROOMS, scores_in_room
from mjsim.record import read_recording

NAMES = ("EkfSlam", "GraphSlam", "FastSlam", "TextbookFastSlam")


def of_room(room: str, seeds: int) -> str:
    """Return a row: mean error of the textbook, ratio of each to that, and mean NEES."""
    rows = []
    for seed in range(seeds):
        scores = scores_in_room(ROOMS[room], {name: getattr(mjsim.algorithms, name)() for name in NAMES}, seed=seed)
        rows.append([(each.error, each.nees) for each in scores.values()])
    (error, nees), *others = np.mean(rows, axis=0).tolist()
    return f"| {room} | {1000 * error:.1f} mm; {nees:.1f} | " + " | ".join(
        f"{e / error:.2f}; {n:.1f}" for e, n in others
    )


def of_log(file: str) -> str:
    """Return a row: cost of a keyframe, errors of relations online and at the end, and the seconds lost."""
    score = score_in_log(read_recording(file))
    costs = 1000 * np.array(score.costs)
    errors = " | ".join(f"{off.mean():.3f}; {off.max():.3f}" for off in (score.online, score.final))
    return f"| {file} | {costs.mean():.1f}; {costs.max():.0f} | {len(score.final)} | {errors} | {score.lost:.1f} |"


def main() -> None:
    """Print two tables in Markdown."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("logs", nargs="*", help="recordings of a robot with a lidar")
    parser.add_argument("--rooms", nargs="*", default=list(ROOMS)[:5], choices=ROOMS)
    parser.add_argument("--seeds", type=int, default=3)
    asked = parser.parse_args()
    print("| room | textbook |", " | ".join(NAMES), "|\n|---|---|" + "---|" * len(NAMES))
    for room in asked.rooms:
        print(of_room(room, asked.seeds), "|", flush=True)
    print(
        "\n| log | ms a keyframe; worst | relations | online: mean; largest [m] | final [m] | lost [s] |\n"
        + "|---" * 6
        + "|"
    )
    for log in asked.logs:
        print(of_log(log), flush=True)


if __name__ == "__main__":
    main()
