#!/usr/bin/env python3
"""Measure recognition over thousands of drawn views: found, wrong, how exact, how honest, how long.

.venv/bin/python scripts/measure/vision.py --views 2000 [--markers 4x4_50 --width 0.6]
"""

import argparse
import time

import numpy as np

from mjsim.algorithms.beacon_vision import MarkerBeacons, PictureBeacons
from mjsim.bench.views import INTRINSICS, KNOWN, MARKERS, PICTURES, WIDTH, Studio, Tally, marker_room, marker_sizes


def main() -> None:
    """Draw views, look for beacons in them, print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--views", type=int, default=2000)
    parser.add_argument("--markers", metavar="DICTIONARY", help="markers instead of pictures")
    parser.add_argument("--width", type=float, default=0.6, help="of the markers [m]")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    if given.markers:
        studio, names, farthest = (
            Studio(marker_room(given.markers, given.width), marker_sizes(given.width)),
            list(MARKERS),
            8.0,
        )
        finder = MarkerBeacons(given.markers, given.width, names={number: name for name, number in MARKERS.items()})
    else:
        studio, names, farthest = Studio(), list(KNOWN), 4.0
        finder = PictureBeacons({name: (PICTURES[name], WIDTH) for name in KNOWN})
    rng, tally, seconds = np.random.default_rng(given.seed), Tally(), []
    edges = np.linspace(1.0, farthest, 5)
    by_distance: list[list[float]] = [[] for _ in edges[1:]]
    for k in range(given.views):
        name, yaw = names[k % len(names)], float(rng.uniform(-45.0, 45.0))
        distance = float(rng.uniform(1.0, farthest))
        shot = studio.before(name, distance, yaw, aside_deg=float(rng.uniform(-12, 12)), rng=rng)
        began = time.process_time()
        found = finder.detect(shot.image, INTRINSICS)
        seconds.append(time.process_time() - began)
        before = len(tally.distances)
        tally.add(name, yaw, shot, found)
        by_distance[int(np.searchsorted(edges, distance) - 1)] += tally.distances[before:]
    studio.canvas.close()
    ranges, bearings = 100.0 * np.array(tally.errors).T * [[1.0], [0.01]]
    cost = 1e3 * np.array(seconds)
    for yaw, (count, total) in tally.found.items():
        print(f"found, yaw up to {yaw} deg    {count} of {total} ({100 * count / total:.1f} %)")
    print(f"gross or wrong           {tally.gross} in {given.views} views ({len(ranges)} detections)")
    print(f"range error              median {np.median(ranges):.3f} %, worst {ranges.max():.2f} %")
    print(f"bearing error            median {np.median(bearings):.4f} deg, worst {bearings.max():.3f} deg")
    print(f"NEES of the position     mean {np.mean(tally.distances):.2f}, median {np.median(tally.distances):.2f}")
    for low, high, part in zip(edges, edges[1:], by_distance, strict=False):
        print(f"    {low:.1f} to {high:.1f} m         mean {np.mean(part):.2f}")
    print(f"processor time a picture mean {cost.mean():.1f} ms, 99 % {np.quantile(cost, 0.99):.1f} ms")


if __name__ == "__main__":
    main()
