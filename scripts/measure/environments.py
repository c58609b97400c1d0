#!/usr/bin/env python
"""How fast environments step, alone and side by side: the table of docs/environments.md.

Ways to step several at once: one after the other; in threads; the physics by `mujoco.batch` and all else one after the
other; in processes. They take turns and the best turn counts, since machines are noisy; a machine that has other work
to do shows little of what runs side by side, so processor time is told too.

    .venv/bin/python scripts/measure/environments.py [WORLD] [--count 4] [--steps 100] [--turns 5]
"""

import argparse
import os
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import mujoco.batch
import numpy as np
from numpy.typing import NDArray

import mjsim
from mjsim.env import Task, vector_environment
from mjsim.env.episodes import Episodes

Timed = tuple[float, float]
"""Seconds by the clock, and of the processor, of one step of all."""


class Batched:
    """Environments whose physics is stepped by `mujoco.batch`, which all else then waits for."""

    def __init__(self, episodes: list[Episodes]) -> None:
        self._episodes = episodes
        self._data = [each.sim.data for each in episodes]
        sim = episodes[0].sim
        self._batch = mujoco.batch.Batch(sim.model, nsim=len(episodes), nthread=os.cpu_count() or 1)
        self._steps = sim.world.run.steps_per_tick
        self._fields = {name: self._batch.bind(name) for name in ("qpos", "qvel")}
        self._ctrl = self._batch.bind("ctrl")
        self._copy(into_batch=True)
        for each in episodes:
            each.sim._run_physics = list

    def physics(self) -> None:
        """Step the physics of all."""
        for row, data in enumerate(self._data):
            self._ctrl[row] = data.ctrl
        self._batch.step(nstep=self._steps)
        self._copy(into_batch=False)

    def rest(self) -> None:
        """Sense, decide and whatever else is done in a step but physics."""
        for each in self._episodes:
            step(each)

    def _copy(self, *, into_batch: bool) -> None:
        for row, data in enumerate(self._data):
            for name, values in self._fields.items():
                if into_batch:
                    values[row] = getattr(data, name)
                else:
                    getattr(data, name)[:] = values[row]


def action(episodes: Episodes) -> NDArray[np.float32]:
    """Return a slow arc."""
    (driven,) = episodes.actions.values()
    return np.full(driven.low.shape, 0.3, dtype=np.float32)


def step(episodes: Episodes) -> None:
    """Do what an environment does in a step."""
    episodes.go_on(action(episodes))
    episodes.observation()


def begun(task: Task, count: int) -> list[Episodes]:
    """Return environments at work."""
    made = [Episodes(task) for _ in range(count)]
    for seed, each in enumerate(made):
        each.begin(seed)
    return made


def timed(once: Callable[[], object], steps: int, workers: list[int]) -> Timed:
    """Return how long one call of many takes, with what processes of these numbers compute for it."""
    wall, cpu = time.perf_counter(), time.process_time() + computed(workers)
    for _ in range(steps):
        once()
    return (time.perf_counter() - wall) / steps, (time.process_time() + computed(workers) - cpu) / steps


def computed(processes: list[int]) -> float:
    """Return the seconds that processes have computed until now; Linux only."""
    fields = [Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split() for process in processes]
    return sum(int(each[11]) + int(each[12]) for each in fields) / os.sysconf("SC_CLK_TCK")


def lidar_task(path: str) -> Task:
    """Return a task in a world for its first robot: all that it senses but pictures."""
    world = mjsim.load_world(path)
    lidars = [sensor.lidar for sensor in world.robots[0].sensors if hasattr(sensor, "lidar")]
    return Task(world=world, observations=["proximity", "bump", "odometry", *lidars], seconds=1e5)


def main() -> None:
    """Measure, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("world", nargs="?", default="worlds/clutter.yaml")
    parser.add_argument("--count", type=int, default=4)
    parser.add_argument("--steps", type=int, default=100)
    parser.add_argument("--turns", type=int, default=5)
    asked = parser.parse_args()
    task, count = lidar_task(asked.world), asked.count

    began = time.process_time()
    alone = Episodes(task)
    made = time.process_time() - began
    resets = [timed(lambda seed=seed: alone.begin(seed), 1, [])[1] for seed in range(9)]
    print(f"{task.loaded().name}: {1e3 * made:.0f} ms to make, {1e3 * float(np.median(resets)):.1f} ms to reset")

    others, batched = begun(task, count), Batched(begun(task, count))
    pool, processes = ThreadPoolExecutor(os.cpu_count()), vector_environment(task, count)
    processes.reset(seed=0)
    workers = processes.workers
    actions = np.tile(action(alone), (count, 1))
    ways: dict[str, Callable[[], object]] = {
        "one alone": lambda: step(alone),
        "one after the other": lambda: [step(each) for each in others],
        "threads": lambda: list(pool.map(step, others)),
        "mujoco.batch": lambda: (batched.rest(), batched.physics()),
        "- of it the physics": batched.physics,
        "processes": lambda: processes.step(actions),
    }
    best: dict[str, Timed] = dict.fromkeys(ways, (np.inf, np.inf))
    for _ in range(asked.turns):
        for name, once in ways.items():
            one = timed(once, asked.steps, workers if name == "processes" else [])
            best[name] = min(best[name][0], one[0]), min(best[name][1], one[1])
    processes.close()
    pool.shutdown()
    print(f"{'way':<22}{'steps a second':>16}{'processor ms a step':>22}")
    for name, (wall, cpu) in best.items():
        number = 1 if name == "one alone" else count
        print(f"{name:<22}{number / wall:>16.0f}{1e3 * cpu / number:>22.2f}")
    print(f"{count} environments, {os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
