"""Print how estimators hold on copies of a real log that are worse than it.

    python scripts/measure/hostile_logs.py MRCLAM_Dataset7 [--copies late dark] [--variants standard graph] [--seed 2]
    python scripts/measure/hostile_logs.py MRCLAM_Dataset7 --late [0 30 400]

The folder is a data set of MRCLAM. Of each robot's text files a copy is written that has been spoilt in one way, by
chance drawn from the seed; it is imported as any log, and all estimators see the same. Figures are the position error
after rigid alignment (root mean square) [m] online and the mean NEES, of `GraphSlam` (graph) the errors online and of
its final path.

With `--late`, the log as it is but for its beginning: so many seconds of that are left out, a row each.
"""

import argparse
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.random import Generator

import mjsim
from mjsim.algorithms.ekf_filter import Jacobians
from mjsim.algorithms.ekf_slam import EkfSlam
from mjsim.algorithms.graph_slam import GraphSlam
from mjsim.bench.slam_rooms import scores_in_log
from mjsim.geometry import Array
from mjsim.interface import Estimator
from mjsim.logs import Wishes

VARIANTS: tuple[Jacobians | Literal["invariant"], ...] = ("standard", "first-estimates", "invariant")
GRAPH = "graph"
LATE = 0.2
"""Sightings are told so long after they were taken, and nobody says so [s]."""
RANGE, BEARING = 0.15, np.radians(2.0)
"""Standard deviations of noise that is added to sightings: as much again as the import takes them to have [m, rad]."""
DARK, EVERY = 20.0, 120.0
"""So long nothing is seen, and so often [s]."""

BEGINS = (0, 30, 60, 100, 150, 200, 300, 400, 500)
"""So much of the beginning is left out [s]."""

Files = tuple[Array, Array]
"""Odometry (n, 3) and measurements (m, 4), columns as in the text files."""


def late(odometry: Array, looks: Array, rng: Generator) -> Files:
    """Return sightings with stamps that are too late."""
    return odometry, looks + np.array([LATE, 0.0, 0.0, 0.0])


def sparse(odometry: Array, looks: Array, rng: Generator) -> Files:
    """Return every fifth sighting."""
    return odometry, looks[::5]


def longer(odometry: Array, looks: Array, rng: Generator, *, scale: float) -> Files:
    """Return odometry whose way and turn are multiplied by a scale."""
    return odometry * np.array([1.0, scale, scale]), looks


def veering(odometry: Array, looks: Array, rng: Generator, *, turn_deg: float) -> Files:
    """Return odometry that turns by so much too far to the left while the robot moves [deg/s]."""
    moving = np.any(odometry[:, 1:] != 0.0, axis=1)
    return odometry + np.outer(moving, (0.0, 0.0, np.radians(turn_deg))), looks


def noisy(odometry: Array, looks: Array, rng: Generator) -> Files:
    """Return sightings with more noise."""
    added = rng.normal(size=(len(looks), 2)) * (RANGE, BEARING)
    ranges, bearings = np.maximum(looks[:, 2] + added[:, 0], 0.1), np.clip(looks[:, 3] + added[:, 1], -1.0, 1.0)
    return odometry, np.column_stack([looks[:, :2], ranges, bearings])


def misread(odometry: Array, looks: Array, rng: Generator, *, share: float) -> Files:
    """Return sightings of which a share has the barcode of another landmark."""
    spoilt, wrong = looks.copy(), rng.random(len(looks)) < share
    spoilt[wrong, 1] = rng.choice(np.unique(looks[:, 1]), int(wrong.sum()))
    return odometry, spoilt


def dark(odometry: Array, looks: Array, rng: Generator) -> Files:
    """Return sightings with gaps."""
    phase = (looks[:, 0] - odometry[0, 0] - rng.uniform(0.0, EVERY)) % EVERY
    return odometry, looks[phase > DARK]


def all_of_it(odometry: Array, looks: Array, rng: Generator) -> Files:
    """Return a copy with a little of everything."""
    for spoil in (
        partial(longer, scale=1.03),
        partial(veering, turn_deg=float(rng.choice([-1.0, 1.0]))),
        partial(misread, share=0.02),
        dark,
    ):
        odometry, looks = spoil(odometry, looks, rng)
    return odometry, looks


COPIES: Mapping[str, Callable[[Array, Array, Generator], Files]] = {
    "as-it-is": lambda odometry, looks, rng: (odometry, looks),
    "late": late,
    "sparse": sparse,
    "longer": partial(longer, scale=1.03),
    "left": partial(veering, turn_deg=2.0),
    "right": partial(veering, turn_deg=-2.0),
    "noisy": noisy,
    "misread": partial(misread, share=0.02),
    "dark": dark,
    "all": all_of_it,
}
"""By name."""


def spoilt_copy(folder: Path, to: Path, name: str, *, seed: int) -> None:
    """Write a copy of a data set that is spoilt in one way."""
    shutil.copytree(folder, to)
    for path in sorted(folder.glob("Robot*_Odometry.dat")):
        looks = path.with_name(path.name.replace("Odometry", "Measurement"))
        rng = np.random.default_rng((seed, *path.name.encode()))
        odometry, measurements = COPIES[name](np.loadtxt(path), np.loadtxt(looks), rng)
        np.savetxt(to / path.name, odometry, fmt="%.6f")
        np.savetxt(to / looks.name, measurements, fmt=("%.6f", "%d", "%.6f", "%.6f"))


def cells(folder: Path, name: str, *, seed: int, seconds: float | None, variants: Sequence[str]) -> Iterator[str]:
    """Yield the cells of a copy, one a robot: the errors of the estimators in their order."""
    with tempfile.TemporaryDirectory() as place:
        copy = Path(place) / folder.name
        spoilt_copy(folder, copy, name, seed=seed)
        log = mjsim.import_log(copy, wishes=Wishes(seconds=seconds))
    for robot in log.robots:
        yield "; ".join(errors(log, robot, variants))


def late_cells(folder: Path, begin: float, *, seconds: float | None, variants: Sequence[str]) -> Iterator[str]:
    """Yield the cells of a log without its beginning, one a robot."""
    log = mjsim.import_log(folder, wishes=Wishes(begin=begin, seconds=seconds))
    for robot in log.robots:
        yield "; ".join(errors(log, robot, variants))


def errors(log: mjsim.Recording, robot: str, variants: Sequence[str]) -> Iterator[str]:
    """Yield the aligned error of each estimator online [m] and its mean NEES; of GraphSlam that of its final path."""
    makes: dict[str, Estimator] = {each: EkfSlam(jacobians=each) for each in VARIANTS if each in variants}
    if makes:
        yield from (f"{score.ate:.2f}, {score.nees:.1f}" for score in scores_in_log(log, robot, makes).values())
    if GRAPH in variants:
        own = mjsim.statistics(mjsim.replay(log, robot=robot, estimator=GraphSlam()))[robot]
        yield f"{own['ate_m']['rmse']:.2f}, {own['path_ate_m']['rmse']:.2f}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="a data set of MRCLAM")
    parser.add_argument("--copies", nargs="+", default=[*COPIES], choices=COPIES)
    parser.add_argument("--variants", nargs="+", default=[*VARIANTS, GRAPH], choices=[*VARIANTS, GRAPH])
    parser.add_argument("--seconds", type=float, help="of the beginning; all unless given")
    parser.add_argument("--seed", type=int, default=1, help="of the chance")
    parser.add_argument("--late", nargs="*", type=float, help="leave out so much of the beginning instead [s]")
    given = parser.parse_args()
    print("; ".join(given.variants), "(a column each robot)")
    for begin in given.late or BEGINS if given.late is not None else ():
        row = late_cells(given.folder, begin, seconds=given.seconds, variants=given.variants)
        print(f"| {begin:g} s | " + " | ".join(row) + " |", flush=True)
    for name in given.copies if given.late is None else ():
        row = cells(given.folder, name, seed=given.seed, seconds=given.seconds, variants=given.variants)
        print(f"| {name} | " + " | ".join(row) + " |", flush=True)


if __name__ == "__main__":
    os.environ |= {"OMP_NUM_THREADS": "1"}
    main()
