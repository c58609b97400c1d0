"""Score navigators on worlds of the BARN benchmark.

python scripts/measure/barn.py [--held-out | --tuning] [--every K] [--drive PRESET] [--navigator SPEC] [--avoidance]
                               [-o FILE.csv]

SPEC names the module as a world does, with GOALS for the list of goals.
World N of `mjsim new --barn N` is held out if N has the remainder 5 for the divisor 6: 50 worlds. Navigators are tuned
on the other 200. A robot without a lidar gets that of the Jackal, on its top or 0.8 m above the floor. Time is
processor time of the navigator alone.
"""

import argparse
import csv
import sys
import time
from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path

import numpy as np

from mjsim.exchange import barn_path_length, barn_score, barn_world
from mjsim.interface import Command, Estimate, Navigator, Observation, RobotInfo, WheelCommand, WorldMap
from mjsim.modules import module_of
from mjsim.run import Driver, ticks
from mjsim.sim import Simulation
from mjsim.world import Lidar, World

WORLDS = [number for number in range(300) if number % 6]
HELD_OUT = [number for number in WORLDS if number % 6 == 5]
GOAL, NEAR, LIMIT = (-2.25, 13.0), 1.0, 100.0
SIGHT = 0.8
"""Height up to which a lidar is mounted: the cylinders are 1 m high [m]."""
SPEC = "mjsim.algorithms.go_to_goal:GoToGoal{goals: GOALS}"


@dataclass(frozen=True, slots=True)
class Result:
    """One run."""

    world: int
    score: float
    """Metric of the challenge, 0 to 0.5."""
    arrival: float
    """From the first 0.1 m of motion to the goal [s]; NaN if it did not arrive."""
    touched: bool
    mean: float
    """Processor time of the navigator in a tick [ms]."""
    worst: float
    """The same [ms]."""
    still: float
    """Longest time without 0.1 m of motion [s]."""


class Timed:
    """A navigator whose processor time is measured."""

    def __init__(self, navigator: Navigator) -> None:
        """Take the navigator."""
        self.navigator, self.seconds = navigator, list[float]()

    def start(self, robot: RobotInfo, map: WorldMap | None, rng: np.random.Generator) -> None:
        """Start it."""
        self.navigator.start(robot, map, rng)

    def command(self, seen: Observation, belief: Estimate) -> Command | WheelCommand:
        """Return its command."""
        began = time.process_time()
        command = self.navigator.command(seen, belief)
        self.seconds.append(time.process_time() - began)
        return command


def with_lidar(world: World) -> World:
    """Return a world whose robot has a lidar."""
    (robot,) = world.robots
    if any(isinstance(sensor, Lidar) for sensor in robot.sensors):
        return world
    (lidar,) = barn_world(WORLDS[0]).robots[0].sensors
    mounted = lidar.model_copy(update={"at": (0.0, 0.0, min(robot.body.height + 0.1, SIGHT))})
    robot = robot.model_copy(update={"sensors": (*robot.sensors, mounted)})
    return world.model_copy(update={"robots": (robot,)})


def result(number: int, preset: str, spec: str, *, avoidance: bool) -> Result:
    """Run a world until the robot arrives or touches something, at most 100 s."""
    module, _ = module_of(spec.replace("GOALS", f"[{list(GOAL)}]"), role="navigator", robot="scout")
    timed = Timed(module)
    began, arrival, touched, rest, still, longest = None, np.nan, False, None, 0.0, 0.0
    with Simulation(with_lidar(barn_world(number, preset=preset)), seed=number) as sim:
        for tick in ticks(sim, {"scout": Driver(navigator=timed, avoidance=avoidance)}):
            place = np.array(tick.truth["scout"].as_array()[:2])
            rest = place if rest is None else rest
            if np.hypot(*(place - rest)) > 0.1:
                rest, still = place, tick.time
                began = tick.time if began is None else began
            longest = max(longest, tick.time - still)
            touched = bool(tick.seen["scout"].bump)
            if touched or tick.time > LIMIT:
                break
            if np.hypot(*(place - GOAL)) < NEAR:
                arrival = tick.time - (began or 0.0)
                break
    score = barn_score(None if np.isnan(arrival) else arrival, barn_path_length(number))
    milliseconds = 1e3 * np.array(timed.seconds)
    return Result(number, score, arrival, touched, milliseconds.mean(), milliseconds.max(), longest)


def summary(results: Sequence[Result]) -> str:
    """Return a line with the results of all runs."""
    score, arrival, touched = (
        np.array([getattr(each, name) for each in results]) for name in ("score", "arrival", "touched")
    )
    mean, worst = np.mean([each.mean for each in results]), max(each.worst for each in results)
    return (
        f"{len(results)} worlds: metric {score.mean():.3f}, {100 * np.isfinite(arrival).mean():.1f} % arrive,"
        f" {100 * touched.mean():.1f} % touch, {np.nanmedian(arrival):.1f} s median;"
        f" {mean:.1f} ms per tick on average, {worst:.0f} ms at worst"
    )


def main() -> None:
    """Run the worlds, and print a line for each and the summary."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("worlds", nargs="*", type=int)
    parser.add_argument("--held-out", action="store_true")
    parser.add_argument("--tuning", action="store_true")
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--drive", default="jackal")
    parser.add_argument("--navigator", default=SPEC)
    parser.add_argument("--avoidance", action="store_true")
    parser.add_argument("-o", dest="output", type=Path)
    options = parser.parse_args()
    tuning = [number for number in WORLDS if number not in HELD_OUT]
    numbers = options.worlds or (HELD_OUT if options.held_out else tuning if options.tuning else WORLDS)
    results = []
    for number in numbers[:: options.every]:
        results.append(result(number, options.drive, options.navigator, avoidance=options.avoidance))
        print(
            " ".join(f"{value:.3f}" if isinstance(value, float) else str(value) for value in astuple(results[-1])),
            flush=True,
        )
    print(summary(results))
    if options.output is not None:
        with options.output.open("w", newline="") as file:
            csv.writer(file).writerows([[field.name for field in fields(Result)], *map(astuple, results)])


if __name__ == "__main__":
    sys.exit(main())
