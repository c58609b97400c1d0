#!/usr/bin/env python3
"""Relations between places that a robot has come back to, by exhaustive matching of single scans, for people to check.

    scripts/measure/relations.py make RUN.mcap RELATIONS.csv --robot robot --pictures DIR    # RUN: with a final path
    scripts/measure/relations.py judge RELATIONS.csv RUN.mcap ...                            # a row for each recording

`make` takes pairs of scans from a final path that are a minute or more apart in time and near in place; the path only
says which, and the lidar must be at the robot's origin. Where the second lies in the frame of the first is found by
trying every shift of 2 cm within 1 m and every half degree within 15 degrees, on a drawing of the first scan alone, and
then every millimetre; no code of the estimators takes part. A pair stays if nothing else within the window fits nearly
as well, and both scans see much of each other. `judge` prints how far relations of online estimate, final path and
odometry are from these.

References:
    Kuemmerle et al., On Measuring the Accuracy of SLAM Algorithms, Autonomous Robots 27, 2009.
"""

import argparse
import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

import mjsim
from mjsim.geometry import Array, Pose, wrap_angles
from mjsim.interface import Scan

CELL = 0.02
"""Of the drawing of a scan [m]."""
REACH, TURN = 1.0, np.radians(15.0)
"""Half of the window in which the second scan is tried."""
NEAR = 0.1
"""A point of the second scan that is farther from the first scan than this does not lie on it [m]."""
FARTHEST = 12.0
"""Points farther from the sensor are left out [m]."""
ELSEWHERE = (0.25, np.radians(3.0))
"""A fit that differs by more than this is another one."""
MARGIN = 0.12
"""By how much more of the scan the best fit must hold than any other one."""
LEAST = 0.7
"""Share of the points that must lie on the first scan."""
HEAD = ("first_s", "second_s", "x_m", "y_m", "heading_rad", "share")


@dataclass(frozen=True, slots=True)
class Relation:
    """Where the second scan of a pair was taken, in the robot's frame at the first one."""

    first: float
    """Time in the recording [s]."""
    second: float
    pose: Pose
    share: float
    """Of the points of the second scan that lie on the first."""


def main() -> None:
    """Make relations or judge by them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    make = commands.add_parser("make")
    make.add_argument("run", type=Path)
    make.add_argument("relations", type=Path)
    make.add_argument("--robot", default="robot")
    make.add_argument("--count", type=int, default=40)
    make.add_argument("--pictures", type=Path)
    judge = commands.add_parser("judge")
    judge.add_argument("relations", type=Path)
    judge.add_argument("runs", type=Path, nargs="+")
    judge.add_argument("--robot", default="robot")
    given = parser.parse_args()
    if given.command == "make":
        make_relations(given.run, given.relations, robot=given.robot, count=given.count, pictures=given.pictures)
    else:
        judge_runs(given.relations, given.runs, robot=given.robot)


def make_relations(run: Path, file: Path, *, robot: str, count: int, pictures: Path | None) -> None:
    """Write relations, and a picture of each."""
    recording = mjsim.read_recording(run)
    path = recording.robots[robot].path
    seen_scans = ((seen.moment, seen.scans) for seen in recording.observations(robot))
    scans = {at: next(iter(each.values())) for at, each in seen_scans if each}
    rows = [row for row in path.tolist() if row[0] in scans]
    found: list[Relation] = []
    for first, second in pairs(np.array(rows)):
        relation = matched(first, second, scans)
        if relation is not None:
            found.append(relation)
            if pictures is not None:
                draw(relation, scans, pictures / f"{len(found):02d}.png")
        if len(found) == count:
            break
    with file.open("w", newline="") as text:
        table = csv.writer(text, lineterminator="\n")
        table.writerow(HEAD)
        for each in sorted(found, key=lambda item: item.first):
            pose = (f"{each.pose.x:.3f}", f"{each.pose.y:.3f}", f"{each.pose.heading:.4f}")
            table.writerow((f"{each.first:.4f}", f"{each.second:.4f}", *pose, f"{each.share:.2f}"))
    print(f"{len(found)} relations in {file}")


def pairs(path: Array) -> Iterator[tuple[Array, Array]]:
    """Yield pairs of poses (time, x, y, heading) that are far apart in time, spread over the path."""
    rng = np.random.default_rng(1)
    for number in rng.permutation(len(path)):
        first = path[number]
        later = path[path[:, 0] > first[0] + 60.0]
        turned = np.abs(wrap_angles(later[:, 3] - first[3]))
        near = (np.hypot(*(later[:, 1:3] - first[1:3]).T) < 1.0) & (turned < np.radians(40.0))
        if near.any():
            yield first, later[rng.choice(np.flatnonzero(near))]


def matched(first: Array, second: Array, scans: dict[float, Scan]) -> Relation | None:
    """Return the relation of two scans; None when they do not fit, or fit in several ways."""
    one, other = near_points(scans[first[0]]), near_points(scans[second[0]])
    if min(len(one), len(other)) < 60:
        return None
    guess = Pose(*first[1:]).inverse() @ Pose(*second[1:])
    distance, lower = drawing(one)
    shifts = np.arange(-REACH, REACH + 1e-9, CELL)
    best: list[tuple[float, float, float, float]] = []
    for turn in np.arange(-TURN, TURN + 1e-9, np.radians(0.5)):
        share = shares(distance, lower, Pose(guess.x, guess.y, guess.heading + turn).transform(other), shifts)
        row, column = np.unravel_index(int(np.argmax(share)), share.shape)
        best.append((float(share[row, column]), shifts[column], shifts[row], float(turn)))
        far = np.hypot(shifts[column] - shifts[None, :], shifts[row] - shifts[:, None]) > ELSEWHERE[0]
        best.append((float(np.max(share, where=far, initial=0.0)), np.inf, np.inf, float(turn)))
    top = max(best)
    others = [each[0] for each in best if abs(each[3] - top[3]) > ELSEWHERE[1] or not np.isfinite(each[1])]
    if top[0] < LEAST or top[0] - max(others) < MARGIN or max(map(abs, top[1:3])) > REACH - 0.1:
        return None
    rough = Pose(guess.x + top[1], guess.y + top[2], guess.heading + top[3])
    return Relation(first[0], second[0], refined(one, other, rough), top[0])


def near_points(scan: Scan) -> Array:
    """Return the points of a scan that are near the sensor, shape (n, 2) [m]."""
    points = scan.points()
    return points[np.hypot(*points.T) < FARTHEST]


def drawing(points: Array, cell: float = CELL) -> tuple[Array, Array]:
    """Return the distance to the nearest point or wall between points for each cell [m], and the grid's corner."""
    lower = points.min(axis=0) - REACH - 1.0
    columns, rows = np.ceil((points.max(axis=0) + REACH + 1.0 - lower) / cell).astype(int)
    free = np.full((rows, columns), 255, dtype=np.uint8)
    pixels = np.round((points - lower) / cell - 0.5).astype(int)
    for one, other, gap in zip(pixels[:-1], pixels[1:], np.hypot(*np.diff(points, axis=0).T), strict=True):
        cv2.line(free, one.tolist(), (other if gap < 0.3 else one).tolist(), 0)
    return cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE).astype(float) * cell, lower


def shares(distance: Array, lower: Array, points: Array, shifts: Array) -> Array:
    """Return how well points lie on a drawing for each shift, rows by y, columns by x: 1 for exactly."""
    count = len(shifts)
    fit = np.pad(np.maximum(1.0 - distance / NEAR, 0.0).astype(np.float32), count)
    first = np.floor((points - lower) / CELL).astype(int) + count + int(np.round(shifts[0] / CELL))
    column, row = np.clip(first, 0, np.array(fit.shape[::-1]) - count).T
    total = np.zeros((count, count), dtype=np.float32)
    for x, y in zip(column.tolist(), row.tolist(), strict=True):
        total += fit[y : y + count, x : x + count]
    return np.asarray(total / len(points), dtype=float)


def refined(one: Array, other: Array, pose: Pose) -> Pose:
    """Return the pose at which most of a scan lies on another one, by ever smaller steps from a rough one."""
    cell = 0.005
    distance, lower = drawing(one, cell)

    def score(tried: Pose) -> float:
        at = np.clip(((tried.transform(other) - lower) / cell).astype(int), 0, np.array(distance.shape[::-1]) - 1)
        return float(np.minimum(distance[at[:, 1], at[:, 0]], 0.5 * NEAR).sum())

    step, turn, best = 0.016, np.radians(0.4), score(pose)
    while step > 5e-4:
        tries = [
            Pose(pose.x + dx * step, pose.y + dy * step, pose.heading + dh * turn)
            for dx in (-1, 0, 1)
            for dy in (-1, 0, 1)
            for dh in (-1, 0, 1)
        ]
        scores = [score(each) for each in tries]
        if min(scores) < best - 1e-9:
            best, pose = min(scores), tries[int(np.argmin(scores))]
        else:
            step, turn = 0.5 * step, 0.5 * turn
    return pose


def draw(relation: Relation, scans: dict[float, Scan], file: Path) -> None:
    """Draw the first scan, and the second one as the relation lays it on the first."""
    import matplotlib.pyplot as plt

    file.parent.mkdir(parents=True, exist_ok=True)
    figure, axes = plt.subplots(figsize=(6, 6))
    axes.plot(*near_points(scans[relation.first]).T, "k.", ms=3)
    axes.plot(*relation.pose.transform(near_points(scans[relation.second])).T, "r.", ms=2)
    axes.set_aspect("equal")
    axes.set_title(f"{relation.first:.1f} s and {relation.second:.1f} s, {relation.share:.2f} on it")
    figure.savefig(file, dpi=60)
    plt.close(figure)


def read_relations(file: Path) -> list[Relation]:
    """Return the relations of a file."""
    with file.open() as text:
        rows = list(csv.DictReader(line for line in text if not line.startswith("#")))
    return [
        Relation(
            float(row["first_s"]),
            float(row["second_s"]),
            Pose(float(row["x_m"]), float(row["y_m"]), float(row["heading_rad"])),
            float(row["share"]),
        )
        for row in rows
    ]


def misfits(relations: Sequence[Relation], times: Array, poses: Array) -> tuple[Array, Array]:
    """Return how far a trajectory is from relations: shift [m] and turn [rad], shape (k,) each."""
    shift, turn = [], []
    for each in relations:
        one, other = (Pose(*row) for row in poses_at(times, poses, np.array([each.first, each.second])))
        off = each.pose.inverse() @ (one.inverse() @ other)
        shift.append(np.hypot(off.x, off.y))
        turn.append(abs(off.heading))
    return np.array(shift), np.array(turn)


def poses_at(times: Array, poses: Array, wanted: Array) -> Array:
    """Return a trajectory at other times, interpolated linearly, shape (k, 3)."""
    x, y, headings = poses[:, 0], poses[:, 1], np.unwrap(poses[:, 2])
    return np.column_stack([np.interp(wanted, times, column) for column in (x, y, headings)])


def judge_runs(file: Path, runs: Sequence[Path], *, robot: str) -> None:
    """Print a row for each recording and trajectory."""
    relations = read_relations(file)
    print(f"{len(relations)} relations: shift mean, median, largest [m]; turn mean, largest [deg]")
    for run in runs:
        track = mjsim.read_recording(run).robots[robot]
        kinds = {
            "final path": (track.path[:, 0], track.path[:, 1:]),
            "online": (track.moments, track.estimate),
            "odometry": (track.moments, track.odometry),
        }
        for kind, (times, poses) in kinds.items():
            if len(times):
                shift, turn = misfits(relations, times, poses)
                far = f"{shift.mean():.3f} {np.median(shift):.3f} {shift.max():.3f}"
                print(f"{run.name:<24} {kind:<12} {far}   {np.degrees(turn.mean()):.2f} {np.degrees(turn.max()):.2f}")


if __name__ == "__main__":
    main()
