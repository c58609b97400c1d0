"""The loop: how fast it runs, and what a tick is made of."""

import functools
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from time import process_time

import mujoco
from threadpoolctl import threadpool_limits

from mjsim.algorithms.constant import ConstantCommand
from mjsim.bench.figure import Clock, Once, Prepare
from mjsim.bench.scenes import gallery
from mjsim.record import Recorder, Tick
from mjsim.run import Driver, drivers_of, run, ticks
from mjsim.sim import Renderer, Simulation
from mjsim.world import World, parse_world

TICKS = 100
"""Of the gallery that are taken apart."""
PUMA = """
mjsim: 1
robots: [{name: puma, base: fixed, at: [0, 0], arms: [{preset: puma560}]}]
run:
  drivers:
    puma:
      navigator: {use: "mjsim.algorithms.joint_path:JointPath", to_deg: [45, -35, 30, 25, 40, -30], seconds: 2,
                  repeat: true}
      controllers: {arm: {use: "mjsim.algorithms.arm_control:ComputedTorque", rate_hz: 250}}
"""
ROBOT, CAMERA = "scout", "front"
"""Of the gallery."""


def loop_speed(make: Callable[[], World], *, seconds: float, turn: float = 0.0) -> Prepare:
    """Measure the loop with physics and sensing and no modules but one that turns the robot [rad/s]."""

    @contextmanager
    def prepare() -> Iterator[Once]:
        world = make()
        with Simulation(world) as sim:
            navigator = ConstantCommand(turn=turn) if turn else None
            loop = ticks(sim, {robot.name: Driver(navigator=navigator) for robot in world.robots})
            next(loop)
            count = round(seconds / sim.dt)

            def once(clock: Clock) -> float:
                began = clock()
                for _ in range(count):
                    next(loop)
                return seconds / (clock() - began)

            yield once

    return prepare


@contextmanager
def computed_torque() -> Iterator[Once]:
    """Measure a Puma 560 that goes back and forth under computed torque at 250 Hz."""
    world, seconds = parse_world(PUMA), 2.0
    with Simulation(world) as sim, threadpool_limits(1, user_api="blas"):
        loop = ticks(sim, drivers_of(world))
        next(loop)

        def once(clock: Clock) -> float:
            began = clock()
            for _ in range(round(seconds / sim.dt)):
                next(loop)
            return seconds / (clock() - began)

        yield once


@contextmanager
def whole_run() -> Iterator[Once]:
    """Measure the gallery with recognition, SLAM, navigation and recording."""
    world, seconds = gallery(), 10.0

    def once(clock: Clock) -> float:
        with Simulation(world) as sim, tempfile.TemporaryDirectory() as folder:
            drivers = drivers_of(world)
            began = clock()
            run(sim, drivers=drivers, seconds=seconds, record=Path(folder) / "run.mcap")
            return seconds / (clock() - began)

    yield once


@functools.cache  # The same ticks for all parts; they are 50 pictures.
def gallery_ticks() -> tuple[Tick, ...]:
    """Return the first ticks of the gallery."""
    world = gallery()
    with Simulation(world) as sim:
        loop = ticks(sim, drivers_of(world))
        return tuple(next(loop) for _ in range(TICKS))


def _milliseconds(seconds: float) -> float:
    return 1e3 * seconds / TICKS


@contextmanager
def whole_tick() -> Iterator[Once]:
    """Measure a tick of the gallery with all that belongs to it: processor time [ms]."""
    world = gallery()

    def once(clock: Clock) -> float:
        with Simulation(world) as sim, tempfile.TemporaryDirectory() as folder, threadpool_limits(1, user_api="blas"):
            loop = ticks(sim, drivers_of(world))
            recorder = Recorder(Path(folder) / "run.mcap", world=world, seed=1, robots=sim.robots, metadata={})
            recorder.write(next(loop))
            began = process_time()
            for _ in range(TICKS - 1):
                recorder.write(next(loop))
            recorder.close()
            return 1e3 * (process_time() - began) / (TICKS - 1)

    yield once


@contextmanager
def physics_alone() -> Iterator[Once]:
    """Measure the physics of the same ticks alone: processor time [ms]."""
    told = gallery_ticks()
    with Simulation(gallery()) as sim:
        steps = sim.world.run.steps_per_tick

        def once(clock: Clock) -> float:
            seconds = 0.0
            for tick in told:
                sim.data.qpos[:], sim.data.qvel[:] = tick.qpos, tick.qvel
                began = process_time()
                mujoco.mj_step(sim.model, sim.data, steps)
                seconds += process_time() - began
            return _milliseconds(seconds)

        yield once


@contextmanager
def rendering_alone() -> Iterator[Once]:
    """Measure the pictures of the same ticks alone: processor time [ms]."""
    told = [tick for tick in gallery_ticks() if tick.seen[ROBOT].cameras]
    with Simulation(gallery()) as sim, Renderer(sim.model, width=640, height=480) as renderer:

        def once(clock: Clock) -> float:
            seconds = 0.0
            for tick in told:
                sim.data.qpos[:] = tick.qpos
                mujoco.mj_kinematics(sim.model, sim.data)
                mujoco.mj_camlight(sim.model, sim.data)
                began = process_time()
                renderer.render(sim.data, f"{ROBOT}/{CAMERA}")
                seconds += process_time() - began
            return _milliseconds(seconds)

        yield once


@contextmanager
def modules_alone() -> Iterator[Once]:
    """Measure the user modules on the same observations alone: processor time [ms]."""
    told, world = gallery_ticks(), gallery()
    with Simulation(world) as sim:
        info, catalogue = sim.robots[ROBOT], dict(sim.catalogue)

    def once(clock: Clock) -> float:
        from numpy.random import default_rng

        driver = drivers_of(world)[ROBOT]
        observer, estimator, navigator = driver.observer, driver.estimator, driver.navigator
        for module in (observer, estimator):
            module.start(info, catalogue, default_rng(0))
        navigator.start(info, None, default_rng(0))
        with threadpool_limits(1, user_api="blas"):
            began = process_time()
            for tick in told:
                seen = replace(tick.seen[ROBOT], sightings=tuple(observer.observe(tick.seen[ROBOT])))
                navigator.command(seen, estimator.update(seen))
            return _milliseconds(process_time() - began)

    yield once


@contextmanager
def encoding_alone() -> Iterator[Once]:
    """Measure the recording of the same ticks alone, its thread included: processor time [ms]."""
    told, world = gallery_ticks(), gallery()
    with Simulation(world) as sim:
        robots = dict(sim.robots)

    def once(clock: Clock) -> float:
        with tempfile.TemporaryDirectory() as folder:
            recorder = Recorder(Path(folder) / "run.mcap", world=world, seed=1, robots=robots, metadata={})
            began = process_time()
            for tick in told:
                recorder.write(tick)
            recorder.close()
            return _milliseconds(process_time() - began)

    yield once
