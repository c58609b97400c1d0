#!/usr/bin/env python3
"""Measure VisualSlam in furnished worlds with baked light, with depth and with one camera, on the same observations.

The robot drives as its world says; no sightings are passed on. Pictures have 320 x 240 pixels and the noise of a usual
camera, depths an error of 0.005 z^2. With --carried, somebody carries the robot from where it is at the first time to
where it would be at the second. Columns: RMSE of dead reckoning, of the estimate, its ratio to the way, of the final
path; mean NEES; longest time surely wrong (NEES above 25); time lost; processor time per picture, mean and worst.
"""

import argparse
import time
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

import mjsim
from mjsim.algorithms import VisualSlam
from mjsim.geometry import Pose, wrap_angle
from mjsim.interface import CameraFrame, Observation
from mjsim.run.loop import drivers_of
from mjsim.world import Camera, World, name_of

WORLDS = ("corridor", "foyer", "museum", "office", "warehouse")
HEAD = ("", "way", "odometry", "estimate", "of the way", "final path", "NEES", "wrong", "lost", "picture, worst")
CAMERA = {
    "width": 320,
    "height": 240,
    "noise": {"full_well": 5800, "read": 3.9},
    "depth": {"range": [0.3, 10], "noise": 0.005},
}
SURE = 25.0


def small_pictures(name: str) -> World:
    """Return a shipped world with baked light and a camera with small, noisy pictures and depth."""
    robot = mjsim.load_world(name).robots[0]
    (camera,) = (name_of(each) for each in robot.sensors if isinstance(each, Camera))
    place = f"robots.{robot.name}.sensors.{camera}"
    return mjsim.load_world(name, settings={"shading": "baked"} | {f"{place}.{key}": CAMERA[key] for key in CAMERA})


def drive(sim: mjsim.Simulation, carried: tuple[float, float]) -> Iterator[tuple[Observation, Pose]]:
    """Yield each observation of the first robot, without sightings, and where it truly was."""
    begin, end = carried
    for tick in mjsim.ticks(sim, drivers_of(sim.world)):
        if tick.time >= sim.world.run.seconds:
            return
        name = sim.world.robots[0].name
        seen = replace(tick.seen[name], sightings=())
        if begin < seen.time <= end:
            continue
        if seen.time > end:
            missing = end - begin
            frames = {key: replace(frame, stamp=frame.stamp - missing) for key, frame in seen.cameras.items()}
            seen = replace(seen, time=seen.time - missing, cameras=frames)
        yield seen, tick.truth[name]


class Measured:
    """An estimator on its way."""

    def __init__(self, sim: mjsim.Simulation, *, depth: bool) -> None:
        """Start it."""
        robot = sim.robots[sim.world.robots[0].name]
        self.estimator, self._depth, self._dt = VisualSlam(), depth, robot.dt
        self.estimator.start(robot, {}, np.random.default_rng(0))
        self._errors: list[float] = []
        self._nees: list[float] = []
        self._seconds: list[float] = []
        self._wrong, self._longest, self._lost = 0.0, 0.0, 0.0

    def update(self, seen: Observation, truth: Pose) -> None:
        """Give it an observation."""
        if not self._depth:
            seen = replace(seen, cameras={key: _without_depth(frame) for key, frame in seen.cameras.items()})
        began = time.process_time()
        belief = self.estimator.update(seen)
        if seen.cameras:
            self._seconds.append(time.process_time() - began)
        error = belief.pose.as_array() - truth.as_array()
        error[2] = wrap_angle(float(error[2]))
        nees = float(error @ np.linalg.solve(belief.covariance + 1e-12 * np.eye(3), error))
        self._wrong = self._wrong + self._dt if nees > SURE else 0.0
        self._longest, self._lost = max(self._longest, self._wrong), self._lost + self._dt * self.estimator.lost()
        self._errors.append(float(np.hypot(*error[:2])))
        self._nees.append(nees)

    def row(self, name: str, truths: list[Pose], odometry: float) -> str:
        """Return a row of the table."""
        places = np.array([pose.as_array()[:2] for pose in truths])
        way = float(np.hypot(*np.diff(places, axis=0).T).sum())
        final = np.array([pose.as_array()[:2] for _, pose in self.estimator.path()])
        error, path = _rms(self._errors), _rms(np.hypot(*(final - places).T))
        spent = 1e3 * np.array(self._seconds)
        texts = f"{way:.0f} m", f"{odometry:.3f} m", f"{error:.3f} m", f"{100.0 * error / way:.2f} %", f"{path:.3f} m"
        more = f"{np.mean(self._nees):.1f}", f"{self._longest:.1f} s", f"{self._lost:.1f} s"
        return f"| {' | '.join((name, *texts, *more, f'{spent.mean():.1f}, {spent.max():.0f} ms'))} |"


def _without_depth(frame: CameraFrame) -> CameraFrame:
    return replace(frame, depth=None)


def _rms(errors: Iterable[float]) -> float:
    return float(np.sqrt(np.mean(np.square([*errors]))))


def main() -> None:
    """Print a table in Markdown."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("worlds", nargs="*", default=WORLDS)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--carried", type=float, nargs=2, default=(np.inf, np.inf), metavar=("FROM", "TO"))
    asked = parser.parse_args()
    print(f"| {' | '.join(HEAD)} |\n{'|---' * len(HEAD)}|")
    for name in asked.worlds:
        world = small_pictures(name)
        for seed in range(1, asked.seeds + 1):
            with mjsim.Simulation(world, seed=seed) as sim:
                both = {"depth": Measured(sim, depth=True), "one camera": Measured(sim, depth=False)}
                truths, reckoned, errors = [], sim.robots[world.robots[0].name].prior, []
                for seen, truth in drive(sim, tuple(asked.carried)):
                    step = seen.odometry
                    reckoned = reckoned @ Pose(step.forward, step.left, step.turn)
                    truths.append(truth)
                    errors.append(np.hypot(reckoned.x - truth.x, reckoned.y - truth.y))
                    for each in both.values():
                        each.update(seen, truth)
                for kind, each in both.items():
                    print(each.row(f"{name}, {seed}, {kind}", truths, _rms(errors)), flush=True)


if __name__ == "__main__":
    main()
