#!/usr/bin/env python3
"""Measure how much a camera finds to hold on to along the drive of each world: ORB features, and pixels with a slope.

.venv/bin/python scripts/measure/features.py [WORLD ...] [--set KEY=VALUE ...] [--every 2] [--noise 2]

Each world drives as it is written, but with exact odometry in place of observers, so that every variant of a world
takes the same pictures. For a picture after noise are counted: its ORB features (FAST threshold 20), and the cells of a
grid of 8 by 6 that hold one. `flat` is the share of pixels whose gradient is below 0.25 grey levels a pixel, before and
after noise.
"""

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

import cv2
import numpy as np

from mjsim import Simulation
from mjsim.interface import Picture
from mjsim.run import Driver, drivers_of, ticks
from mjsim.world import BeaconSensor, Camera, OdometryNoise, Robot, WheelOdometry, World, load_world

WORLDS = ("gallery", "office", "museum", "warehouse", "foyer", "corridor")
MOST = 10_000
"""Features that ORB is asked for in a picture."""
FEW = 100
"""Fewer features than this in a picture starve visual SLAM."""
GRID = (6, 8)
"""Cells of a picture, down and across."""
FLAT = 0.25
"""Gradient below which a pixel holds nothing [grey levels/px]."""


@dataclass(frozen=True, slots=True)
class Seen:
    """What one picture holds."""

    features: int
    cells: float
    """Share of the cells of the grid with a feature."""
    flat: float
    """Share of pixels without a slope, before noise."""
    flat_noisy: float
    """The same, after noise."""


def main() -> None:
    """Print a row for each world."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("worlds", nargs="*", default=WORLDS, help="names or files; default: shipped ones with a camera")
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="a setting, such as run.seconds"
    )
    parser.add_argument("--every", type=float, default=2.0, help="time between pictures [s]")
    parser.add_argument("--noise", type=float, default=2.0, help="deviation of the camera's noise [grey levels]")
    parser.add_argument("--keep", type=Path, help="folder for every tenth picture")
    chosen = parser.parse_args()
    print(f"| world | pictures | below {FEW} features | median | cells with one | flat | flat after noise |")
    print("|---|---|---|---|---|---|---|")
    for name in chosen.worlds:
        pictures = list(drive(load_world(name, settings=chosen.set), every=chosen.every))
        print(f"| {Path(name).stem} {row(pictures, chosen.noise)}", flush=True)
        for index in range(0, len(pictures), 10) if chosen.keep else ():
            chosen.keep.mkdir(parents=True, exist_ok=True)
            cv2.imwrite(str(chosen.keep / f"{Path(name).stem}-{index:03}.png"), pictures[index][..., ::-1])


def row(pictures: Sequence[Picture], noise: float) -> str:
    """Return the figures of pictures as cells of a table."""
    rng = np.random.default_rng(1)
    seen = [measure(picture, noise, rng) for picture in pictures]
    features = np.array([each.features for each in seen])
    means = [np.mean([getattr(each, name) for each in seen]) for name in ("cells", "flat", "flat_noisy")]
    shares = " | ".join(f"{mean:.2f}" for mean in means)
    return f"| {len(seen)} | {(features < FEW).mean():.2f} | {np.median(features):.0f} | {shares} |"


def measure(picture: Picture, noise: float, rng: np.random.Generator) -> Seen:
    """Return what an RGB picture holds, shape (height, width, 3), once noise is added."""
    noisy = np.clip(np.rint(picture + rng.normal(0.0, noise, picture.shape)), 0, 255).astype(np.uint8)
    before, after = (cv2.cvtColor(each, cv2.COLOR_RGB2GRAY) for each in (picture, noisy))
    orb = cv2.ORB.create(nfeatures=MOST, fastThreshold=20)
    points = np.array([each.pt for each in orb.detect(after)]).reshape(-1, 2)
    across = (points / [picture.shape[1] / GRID[1], picture.shape[0] / GRID[0]]).astype(int)
    return Seen(len(points), len(np.unique(across, axis=0)) / (GRID[0] * GRID[1]), flatness(before), flatness(after))


def flatness(gray: Picture) -> float:
    """Return the share of pixels of a grey picture whose gradient, by central differences, is below `FLAT`."""
    slopes = np.gradient(gray.astype(np.float32))
    return float((np.hypot(*slopes) < FLAT).mean())


def drive(world: World, *, every: float) -> Iterator[Picture]:
    """Yield the pictures of all cameras along the drive of a world, without noise."""
    world = exact(world, rate_hz=1.0 / every, noise=0.0, latency=0)
    drivers = exact_drivers(world)
    with Simulation(world) as sim:
        for tick in islice(ticks(sim, drivers), sim.world.run.ticks()):
            for seen in tick.seen.values():
                yield from (frame.image.copy() for frame in seen.cameras.values())


def exact(world: World, **keys: object) -> World:
    """Return a world whose robots know their way, and whose cameras have other keys."""
    return world.model_copy(update={"robots": tuple(_exact(robot, keys) for robot in world.robots)})


def _exact(robot: Robot, keys: dict[str, object]) -> Robot:
    sensors = tuple(
        each.model_copy(update=keys) if isinstance(each, Camera) else each
        for each in robot.sensors
        if not isinstance(each, BeaconSensor)
    )
    still = WheelOdometry(noise=OdometryNoise(distance=0.0, turn=0.0))
    return robot.model_copy(update={"sensors": sensors, "odometry": still})


def exact_drivers(world: World) -> dict[str, Driver]:
    """Return the drivers of a world without observers and estimators."""
    return {name: replace(each, observer=None, estimator=None) for name, each in drivers_of(world).items()}


if __name__ == "__main__":
    main()
