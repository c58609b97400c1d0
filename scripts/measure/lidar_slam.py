#!/usr/bin/env python3
"""Tour a tour of the office with `LidarSlam`, which knows neither map nor beacons: one row a seed.

For instance `.venv/bin/python scripts/measure/lidar_slam.py --seeds 5`; the project asks for a mean position error
below 0.15 m. Nine rooms along 35 m of corridor and back: every loop that is closed is one along the corridor, whose
doors look alike every 3.6 m.
"""

import argparse
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import mjsim
from mjsim.algorithms.lidar_slam import LidarSlam
from mjsim.algorithms.waypoints import Waypoints
from mjsim.geometry import Array, wrap_angle
from mjsim.interface import BeaconInfo, Estimate, Observation, RobotInfo
from mjsim.world import with_settings

OFFICE = Path(__file__).resolve().parents[2] / "worlds" / "office.yaml"
LIDAR = (
    "{lidar: scan, at: [0.12, 0, 0.3], beams: 360, fov_deg: 360, range: [0.05, 10], rate_hz: 5, noise: {range: 0.02}}"
)
CORRIDOR = 6.2
"""Where the tour goes along the corridor [m]."""
SLIP = {"drive.noise": {"speed": 0.02, "turn": 0.02}, "odometry.noise": {"distance": 0.01, "turn": 0.02}}
"""Noise of the robot as the office has it."""
LONGEST = 420.0
"""When a tour that does not come to its end is given up [s]."""


def room(number: int) -> list[tuple[float, float]]:
    """Return the way from the corridor into a room and back; 1 to 10 in the south, -1 to -10 in the north."""
    x = 3.6 * (abs(number) - 1) + 1.0
    return [(x, CORRIDOR), (x, 3.0 if number > 0 else 9.4), (x, CORRIDOR)]


TOUR = [
    *(place for number in (2, -4, 7, -9) for place in room(number)),
    (33.5, CORRIDOR),
    *(place for number in (8, 5, -3, 1) for place in room(number)),
    (1.2, CORRIDOR),
]


class TimedLidarSlam(LidarSlam):
    """The same, with the processor's time of each scan beside it."""

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: np.random.Generator) -> None:
        """Begin with no times."""
        super().start(robot, catalogue, rng)
        self.seconds: list[float] = []

    def update(self, seen: Observation) -> Estimate:
        """Return the belief, and keep how long a tick with a scan took."""
        began = time.process_time()
        belief = super().update(seen)
        if seen.scans:
            self.seconds.append(time.process_time() - began)
        return belief


@dataclass(frozen=True, slots=True, eq=False)
class Tour:
    """What a tour has shown."""

    errors: Array
    """Distance of the belief from the truth at each tick [m]."""
    drift: Array
    """That of dead reckoning [m]."""
    nees: Array
    """Squared error in units of the covariance, three states."""
    seconds: Array
    """Of the processor, for each scan."""
    loops: int
    """How many were closed."""
    scans: int
    """How many are kept in the map."""
    ended: bool
    """Whether the robot came to the end of its tour."""


def drive(seed: int, *, slip: float) -> Tour:
    """Return what one tour shows, the noise of wheels and odometry made larger by a factor."""
    noise = [
        f"robots.post.{key}={{{', '.join(f'{name}: {slip * value}' for name, value in values.items())}}}"
        for key, values in SLIP.items()
    ]
    settings = [f"robots.post.sensors=[{LIDAR}]", "run.map=unknown", *noise]
    estimator, still, rows = TimedLidarSlam(), 0, []
    with mjsim.Simulation(with_settings(mjsim.load_world(OFFICE), settings), seed=seed) as sim:
        driver = mjsim.Driver(estimator=estimator, navigator=Waypoints(TOUR, speed=0.6), avoidance=True)
        for tick in mjsim.ticks(sim, {"post": driver}):
            truth, order = tick.truth["post"], tick.orders["post"]
            believed, reckoned = order.estimate.pose, order.dead_reckoning
            off = believed.as_array() - truth.as_array()
            off[2] = wrap_angle(float(off[2]))
            nees = off @ np.linalg.pinv(order.estimate.covariance, hermitian=True) @ off
            rows.append((np.hypot(*off[:2]), np.hypot(truth.x - reckoned.x, truth.y - reckoned.y), nees))
            still = 0 if order.command != mjsim.Command() else still + 1
            if still > 50 or tick.time > LONGEST:
                break
    errors, drift, nees = np.array(rows).T
    kept = len(estimator.keyframes)
    return Tour(errors, drift, nees, np.array(estimator.seconds), estimator.loops, kept, tick.time <= LONGEST)


def main() -> None:
    """Print a row a seed, and the count."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--slip", type=float, default=1.0, help="factor on the noise of wheels and odometry")
    given = parser.parse_args()
    means = []
    for seed in range(1, given.seeds + 1):
        found = drive(seed, slip=given.slip)
        means.append(found.errors.mean())
        cost = 1e3 * found.seconds
        print(
            f"seed {seed:3d}   error mean {found.errors.mean():.3f} m, largest {found.errors.max():.3f}   "
            f"odometry {found.drift.mean():.2f}   NEES {np.median(found.nees):.1f}   {found.loops} loops, "
            f"{found.scans} scans kept   a scan {cost.mean():.1f} ms, 99 % {np.quantile(cost, 0.99):.0f}, "
            f"worst {cost.max():.0f}" + ("" if found.ended else "   not at its end"),
            flush=True,
        )
    print(f"mean error {np.mean(means):.3f} m, worst seed {np.max(means):.3f} m; below 0.15 m in", end=" ")
    print(f"{np.sum(np.array(means) < 0.15)} of {len(means)}")


if __name__ == "__main__":
    main()
