#!/usr/bin/env python3
"""Carry a robot away and see how long Monte Carlo localization takes to find it: one row a seed.

For instance `.venv/bin/python scripts/measure/kidnapped.py --seeds 20`; the project asks that in at least 19 of 20
it is found to 0.3 m within 60 s.
"""

import argparse
import itertools
from pathlib import Path

import numpy as np

import mjsim
from mjsim.algorithms.distance_grid import DistanceGrid
from mjsim.algorithms.monte_carlo import MonteCarloLocalization
from mjsim.algorithms.wander import Wander
from mjsim.world import with_settings

GALLERY = Path(__file__).resolve().parents[2] / "worlds" / "gallery.yaml"
LIDAR = (
    "{lidar: scan, at: [0.1, 0, 0.3], beams: 180, fov_deg: 240, range: [0.05, 10], rate_hz: 5, noise: {range: 0.02}}"
)
BEACONS = "{beacons: eye, range: [0.3, 5], fov_deg: 60, rate_hz: 5, noise: {range: 0.05, bearing_deg: 1}}"
"""The gallery looks the same when turned by half a turn; what hangs on its walls does not."""
KIDNAPPED = 20.0
"""When the robot is carried away [s]."""
PATIENCE = 60.0
"""How long it has to be found again [s]."""
NEAR, HELD = 0.3, 3.0
"""How near the belief must be [m], and how long it must stay so [s]."""


def seconds_until_found(seed: int) -> tuple[float, float]:
    """Return the time until the belief is near and stays near [s], infinite for never, and the mean error then [m]."""
    world = with_settings(mjsim.load_world(GALLERY), [f"robots.scout.sensors=[{LIDAR}, {BEACONS}]", "run.map=known"])
    rng = np.random.default_rng(seed)
    with mjsim.Simulation(world, seed=seed) as sim:
        assert sim.map is not None
        places = DistanceGrid.from_segments(sim.map.segments).largest_region(0.4)
        place = mjsim.Pose(*places[rng.integers(len(places))], rng.uniform(-np.pi, np.pi))
        driver = mjsim.Driver(estimator=MonteCarloLocalization(), navigator=Wander(), avoidance=True)
        errors = []
        carried = False
        for tick in itertools.takewhile(
            lambda tick: tick.time < KIDNAPPED + PATIENCE, mjsim.ticks(sim, {"scout": driver})
        ):
            truth, belief = tick.truth["scout"], tick.orders["scout"].estimate.pose
            errors.append(np.hypot(truth.x - belief.x, truth.y - belief.y))
            if tick.time >= KIDNAPPED and not carried:
                sim.move("scout", place)
                carried, begin = True, len(errors)
    far = np.flatnonzero(np.array(errors[begin:]) > NEAR)
    found = 0 if not len(far) else far[-1] + 1
    dt = PATIENCE / len(errors[begin:])
    if (len(errors) - begin - found) * dt < HELD:
        return np.inf, np.inf
    return found * dt, float(np.mean(errors[begin + found :]))


def main() -> None:
    """Print a row a seed, and the count."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    given = parser.parse_args()
    times = []
    for seed in range(1, given.seeds + 1):
        seconds, error = seconds_until_found(seed)
        times.append(seconds)
        print(f"seed {seed:3d}   found after {seconds:6.1f} s   mean error then {error:.3f} m", flush=True)
    found = np.isfinite(times)
    print(f"found in {found.sum()} of {len(times)}, median after {np.median(times):.1f} s")


if __name__ == "__main__":
    main()
