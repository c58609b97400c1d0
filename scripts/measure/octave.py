"""Print what modules in .m files cost: an empty call, and a run of 120 s with 28 landmarks beside Python.

    python scripts/measure/octave.py [--calls 5000] [--runs 3] [--seconds 120]

The runs take turns, so that other programs disturb both alike. Processor time is that of mjsim and of Octave together.
"""

import argparse
import resource
import statistics
import tempfile
import time
from pathlib import Path

import numpy as np

import mjsim
from mjsim.modules import make_module
from mjsim.world import Source, Use, World

WORLD = Path(__file__).parents[2] / "worlds" / "matlab" / "loop.yaml"
EMPTY = "function [est, state] = empty(obs, robot, state)\nest.pose = robot.prior;\nest.covariance = eye(3);\nend\n"


def main() -> None:
    """Print them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--calls", type=int, default=5000)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=120.0)
    given = parser.parse_args()
    call = empty_calls(given.calls)
    print(f"empty call: median {np.median(call) * 1e3:.3f} ms, 95 % below {np.percentile(call, 95) * 1e3:.3f} ms")
    cases = worlds()
    times: dict[str, list[tuple[float, float]]] = {name: [] for name in cases}
    for _ in range(given.runs):
        for name, world in cases.items():
            times[name].append(timed(world, given.seconds))
    for name, pairs in times.items():
        wall, work = (statistics.median(column) for column in zip(*pairs, strict=True))
        print(f"{given.seconds:g} s with the estimator in {name}: {wall:.1f} s, {work:.1f} s of processor time")
    for column, what in ((0, "wall-clock"), (1, "processor")):
        octave, python = (statistics.median(pair[column] for pair in times[name]) for name in ("Octave", "Python"))
        print(f"{what} time, Octave / Python: {octave / python:.2f}")


def empty_calls(count: int) -> list[float]:
    """Return how long calls took of a function that does nothing, each with an observation [s]."""
    seconds = []
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "empty.m").write_text(EMPTY, encoding="utf-8")
        module = make_module(Use(use="empty.m"), Source(folder=Path(folder)), role="estimator", robot="scout")
        with mjsim.Simulation(mjsim.load_world(WORLD)) as sim, module:
            seen = sim.sense("scout")
            module.take_world(dict(sim.catalogue), None)
            module.start(sim.robots["scout"], dict(sim.catalogue), np.random.default_rng(1))
            for _ in range(count):
                began = time.perf_counter()
                module.update(seen)
                seconds.append(time.perf_counter() - began)
    return seconds


def worlds() -> dict[str, World]:
    """Return the same world with the estimator in either language; everything else is in Python."""
    world = mjsim.load_world(WORLD)
    points = [list(point) for point in world.run.drivers["scout"].navigator.arguments()["points"]]
    route = Use(use="mjsim.algorithms.waypoints:Waypoints", points=points, laps=3)
    filters = {
        "Octave": Use(use="ekf_slam.m", gate=13.8),
        "Python": Use(use="mjsim.algorithms.ekf_slam:EkfSlam", jacobians="standard"),
    }
    return {name: _driven(world, estimator=use, navigator=route) for name, use in filters.items()}


def _driven(world: World, **modules: Use) -> World:
    driver = world.run.drivers["scout"].model_copy(update=modules)
    made = world.model_copy(update={"run": world.run.model_copy(update={"drivers": {"scout": driver}})})
    made._source = world.source
    return made


def timed(world: World, seconds: float) -> tuple[float, float]:
    """Return wall-clock and processor time of a run [s]."""
    with mjsim.Simulation(world) as sim:
        began, worked = time.perf_counter(), _work()
        recording = mjsim.run(sim, seconds=seconds)
        taken = time.perf_counter() - began, _work() - worked
    assert len(recording.robots["scout"].landmarks.names) == 28
    return taken


def _work() -> float:
    """Return the processor time of this process and of those that it has ended [s]."""
    usages = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(usage.ru_utime + usage.ru_stime for usage in usages)


if __name__ == "__main__":
    main()
