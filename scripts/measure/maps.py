"""Bring maps of robots in and print how well the worlds stand for them: one row a map.

    python scripts/measure/maps.py [MAP.yaml ...] [--pictures DIR] [--only PART]
    python scripts/measure/maps.py [MAP.yaml ...] --drive SEEDS [--robot PRESET] [--lidar NAME] [--estimator NAME]

Without files it takes those of tests/data/maps and noisy ones made of shipped worlds. The columns:

- occupied: occupied cells of the map, specks too.
- specks: those taken for noise, which the world leaves out; the shares beside count them as not explained.
- explained: share of the occupied cells whose middle is at most one cell from something solid in the world.
- touched: share of the occupied cells that something solid touches (half a cell).
- covered: free cells of the map whose middle is more than half a cell deep in something solid, as a share of all
  cells that something solid covers. Maps whose free_thresh is above 0.196 call unknown cells free.
- false: share of the length of all walls that has no occupied cell within one cell of its faces.

With --drive a robot is put into each world as `mjsim new --robot PRESET --lidar NAME --estimator NAME` does, and drives
for a minute with each seed; the columns tell how far it drove [m], how often it bumped, and the root mean square of the
error of where it believes to be [m], its odometry's beside it.
"""

import argparse
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import mjsim
from mjsim.bench.robot_maps import Noise, mapped
from mjsim.exchange import ESTIMATORS, with_robot
from mjsim.exchange.fidelity import fidelity
from mjsim.exchange.grid import read_grid, write_grid
from mjsim.exchange.maps import specks, world_from_grid
from mjsim.world import Grid, Use, World, load_world

ROOT = Path(__file__).resolve().parents[2]
HARSH = Noise(fray=0.3, missed=0.10, specks=2e-3)
MADE = {
    "museum-turned": ("museum", {"turn": 0.3, "seed": 1}),
    "museum-2cm": ("museum", {"turn": 0.1, "seed": 2, "resolution": 0.02, "noise": HARSH}),
    "office-2cm": ("office", {"turn": 0.0, "seed": 3, "resolution": 0.02, "noise": Noise(bent=0.02)}),
    "gallery-harsh": ("gallery", {"turn": -0.2, "seed": 4, "noise": HARSH}),
    "office-bent": ("office", {"turn": 0.5, "seed": 5, "noise": Noise(bent=0.04)}),
    "warehouse-10cm": ("warehouse", {"turn": 0.05, "seed": 6, "resolution": 0.1}),
    "clutter-turned": ("clutter", {"turn": 0.7, "seed": 7}),
}


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("maps", nargs="*", type=Path)
    parser.add_argument("--only", default="", help="of the noisy maps, those whose names contain it")
    parser.add_argument("--pictures", type=Path, help="folder for the map and the plan side by side")
    parser.add_argument("--drive", type=int, metavar="SEEDS", help="drive in the worlds instead, with so many seeds")
    parser.add_argument("--robot", default="turtlebot3_burger", help="that drives")
    parser.add_argument("--lidar", default="lds-02", help="of the robot that drives")
    parser.add_argument(
        "--estimator", default="monte_carlo", choices=list(ESTIMATORS), help="that finds out where it is"
    )
    options = parser.parse_args()
    if options.drive:
        for name, grid in grids(options.maps, options.only):
            world = world_from_grid(grid, name=name)
            use = Use.model_validate({"use": ESTIMATORS[options.estimator]})
            drive(with_robot(world, preset=options.robot, lidar=options.lidar, estimator=use, grid=grid), options.drive)
        return
    widths = {"map": -16, "cells": 11, "m": 5, "occupied": 8, "specks": 6, "explained": 9, "touched": 7, "covered": 7}
    widths |= {"false": 6, "walls": 5, "segments": 8, "things": 6, "seconds": 7}
    print(*(name.ljust(-width) if width < 0 else name.rjust(width) for name, width in widths.items()))
    for name, grid in grids(options.maps, options.only):
        row(name, grid, options.pictures)


def grids(maps: list[Path], only: str) -> Iterator[tuple[str, Grid]]:
    """Yield the named maps, or those that the project has."""
    if maps:
        yield from ((path.stem, read_grid(path)) for path in maps)
        return
    yield from ((path.stem, read_grid(path)) for path in sorted((ROOT / "tests/data/maps").glob("*.yaml")))
    for name, (world, keys) in MADE.items():
        if only in name:
            yield name, mapped(load_world(world), **keys)


def drive(world: World, seeds: int) -> None:
    """Print how well a robot knows where it is in a world, a row a seed."""
    for seed in range(1, seeds + 1):
        with mjsim.Simulation(world, seed=seed) as sim:
            recording = mjsim.run(sim, seconds=60.0)
        robot, bumps = recording.robots["scout"], mjsim.statistics(recording)["scout"]["bumps"]
        way = np.hypot(*np.diff(robot.truth[:, :2], axis=0).T).sum()
        believed, reckoned = (rms(robot.truth, poses) for poses in (robot.estimate, robot.odometry))
        print(
            f"{world.name:16} {world.robots[0].preset:18} seed {seed:2}  {way:6.2f} m  {bumps} bumps"
            f"  error {believed:6.4f} m  odometry {reckoned:6.4f} m",
            flush=True,
        )


def rms(truth: np.ndarray, poses: np.ndarray) -> float:
    """Return the root mean square of the distances between poses, shape (n, 3) [m]."""
    return float(np.sqrt(np.mean(np.sum((truth[:, :2] - poses[:, :2]) ** 2, axis=1))))


def row(name: str, grid: Grid, pictures: Path | None) -> None:
    """Print the figures of one map."""
    began = time.perf_counter()
    world = world_from_grid(grid, name=name)
    took = time.perf_counter() - began
    found = fidelity(world, grid)
    rows, columns = grid.occupied.shape
    segments = sum(len(wall.segments()) for wall in world.walls)
    print(
        f"{name:16} {columns:5} x {rows:<4} {grid.resolution:4g} {found.occupied:8} {specks(grid):6} {found.share:9.2%}"
        f" {found.touched / found.occupied:7.2%} {found.covered / max(1, found.solid):7.2%} {found.false_walls:6.2%}"
        f" {len(world.walls):5} {segments:8} {len(world.obstacles):6} {took:7.1f}",
        flush=True,
    )
    if pictures is not None:
        from mjsim.exchange import read_original
        from mjsim.video import draw_beside

        pictures.mkdir(parents=True, exist_ok=True)
        original = read_original(write_grid(grid, pictures / name, overwrite=True))
        draw_beside(world, original, pictures / f"{name}.png", overwrite=True)


if __name__ == "__main__":
    main()
