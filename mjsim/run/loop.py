"""The control loop as a generator of ticks, with the events of robots that fall; `run` records them."""

import json
import math
import shutil
import sys
import time
import weakref
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, closing, nullcontext, suppress
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

from threadpoolctl import threadpool_limits

from mjsim.errors import ModuleFault, RecordingError, UsageError, did_you_mean
from mjsim.geometry import Pose3
from mjsim.interface import ControlLoop, Observation
from mjsim.modules import ROLES, load_runnable, make_module, name_of
from mjsim.output import NewFile, temporary_file
from mjsim.progress import watched
from mjsim.record import Order, RobotEvent, Tick
from mjsim.run.pilot import Driver, Pilot, Steer, controller_of, final_path, require_takes_goals
from mjsim.sentences import Sentence
from mjsim.world import GoalEvent, Modules, Source, Use, World, WorldEvent

if TYPE_CHECKING:
    from mjsim.record import Recorder, Recording
    from mjsim.sim import Simulation


def ticks(sim: "Simulation", drivers: Mapping[str, Driver], *, steer: Steer | None = None) -> Generator[Tick]:
    """Yield one Tick per period, for as long as the caller asks for more.

    Args:
        sim: The simulation of the robots.
        drivers: The modules of each robot that is driven.
        steer: Called for each of them at each tick; a command that it returns replaces the navigator's.

    Raises:
        UsageError: A driver is for a robot that does not exist, or a goal for a navigator that takes none.
        ModuleFault: A module raised an exception or returned an invalid value.
        PhysicsFault: The simulation has become unstable.
    """
    for name in drivers:
        if name not in sim.robots:
            raise UsageError(Sentence("no robot '{name}' in this world{meant}", name, did_you_mean(name, sim.robots)))
    for goal in goals_of(sim.world.run.events):
        require_takes_goals(drivers, goal.goal)
    with ExitStack() as stack:
        pilots = {
            name: stack.enter_context(
                Pilot(driver, sim.robots[name], dict(sim.catalogue), sim.map, seed=sim.seed, steer=steer)
            )
            for name, driver in drivers.items()
        }
        for name, driver in drivers.items():
            sim.control(name, driver.controllers)
        physics, falls = 0.0, Falls()
        while True:
            began = time.perf_counter()
            seen = {name: sim.sense(name) for name in pilots}
            sensing = time.perf_counter() - began
            happened = sim.happened()
            for goal in goals_of(happened):
                require_takes_goals(drivers, goal.goal)
                pilots[goal.goal].take_goal(goal)
            orders = {name: timed(pilot.decide(seen[name]), sim.control_times(name)) for name, pilot in pilots.items()}
            poses = sim.poses()
            noted = falls.noted(orders, poses, sim.time)
            yield _tick(sim, poses, seen, noted, happened, timing={"sense": sensing, "step": physics})
            began = time.perf_counter()
            for name, order in orders.items():
                sim.apply(name, order.command)
            sim.step()
            physics = time.perf_counter() - began


def goals_of(events: Iterable[WorldEvent]) -> list[GoalEvent]:
    """Return the goals among events."""
    return [event for event in events if isinstance(event, GoalEvent)]


def timed(order: Order, times: Mapping[str, float]) -> Order:
    """Return an order with the wall-clock times of the controllers since the last tick, by part [s]."""
    if not times:
        return order
    parts = {f"controller/{part}": seconds for part, seconds in times.items()}
    return replace(order, timing={**order.timing, **parts})


def _tick(
    sim: "Simulation",
    poses: Mapping[str, Pose3],
    seen: Mapping[str, Observation],
    orders: Mapping[str, Order],
    happened: tuple[WorldEvent, ...],
    *,
    timing: Mapping[str, float],
) -> Tick:
    qpos, qvel = sim.state()
    return Tick(
        time=sim.time,
        truth={name: pose.planar() for name, pose in poses.items()},
        poses=poses,
        seen=seen,
        orders=orders,
        qpos=qpos,
        qvel=qvel,
        timing=timing,
        events=happened,
        things=sim.things(),
        joints=sim.motions(),
        readings=sim.readings(),
        looks=sim.looks,
        identities={name: sim.identities(name) for name in orders},
    )


def drivers_of(world: World) -> dict[str, Driver]:
    """Return a driver for each robot of a world, its modules made as `run: drivers:` says.

    Raises:
        UsageError: A module or class does not exist, or does not accept its keys.
        ModuleFault: It exists but fails, or lacks a method of its role.
    """
    source = world.source.for_run()
    return {robot.name: _driver(world, robot.name, source) for robot in world.robots}


def _driver(world: World, robot: str, source: Source) -> Driver:
    modules = world.run.drivers.get(robot, Modules())
    live = {
        role: make_module(use, source, role=role, robot=robot)
        for role in ROLES
        if isinstance(use := getattr(modules, role, None), Use)
    }
    controllers = {
        part: ControlLoop(
            controller=make_module(control, world.source, role="controller", robot=robot),
            rate_hz=control.rate_hz,
            latency=control.latency,
        )
        for part, control in modules.controllers.items()
    }
    return Driver(**{"avoidance": modules.avoidance, **live}, controllers=controllers, push=modules.push)


def run(
    sim: "Simulation | World | str | Path",
    *,
    seed: int | None = None,
    drivers: Mapping[str, Driver] | None = None,
    seconds: float | None = None,
    record: str | Path | NewFile | None = None,
    watch: Callable[[Tick], None] | None = None,
    realtime: bool = False,
    pictures: bool = True,
    overwrite: bool = False,
    progress: bool = True,
) -> "Recording":
    """Run a simulation from now on and return its recording.

    Args:
        sim: A simulation, a world, its file, or the name of a shipped world.
        seed: Seed of all random numbers, for a world; by default its own.
        drivers: The modules of each robot; by default those of the world file.
        seconds: Simulated duration [s]; by default that of the world file.
        record: The MCAP file to write, or its name from `reserve`; by default a temporary file, deleted with the
            recording. It is created at the first tick.
        watch: Called with each tick, after it is recorded.
        realtime: Run no faster than real time.
        pictures: Whether to record camera pictures, which are most of the data, and the map as a grid; they can be
            rendered again.
        overwrite: Whether `record` may replace a file; that stays until the first tick of the new one is written.
        progress: Whether to show progress on a terminal or in a notebook; elsewhere nothing is shown.

    Raises:
        UsageError: It would have no tick, or `record` exists, is being written, or cannot be written; or a simulation
            is given a seed, though it already has one.
        WorldError: The file is not a valid world.
        MjsimError: As `ticks`; what was recorded until then stays readable in `record`.
    """
    from mjsim.record import read_recording, reserve

    if record is None:
        with temporary_file("run.mcap") as path:
            recording = run(
                sim,
                seed=seed,
                drivers=drivers,
                seconds=seconds,
                record=path,
                watch=watch,
                realtime=realtime,
                pictures=pictures,
                progress=progress,
            )
        weakref.finalize(recording, shutil.rmtree, path.parent, ignore_errors=True)
        return recording
    with _simulated(sim, seed) as made:
        count = made.world.run.ticks(seconds)
        drivers = drivers_of(made.world) if drivers is None else drivers
        shown = watched(f"run {made.world.name}", total=count * made.dt, unit="s") if progress else nullcontext()
        with (
            reserve(record, overwrite=overwrite) as place,
            one_blas_thread(),
            recorder_of(made, drivers, count, place, pictures=pictures) as recorder,
            shown as advance,
        ):
            watches = [watch] if watch is not None else []
            if advance is not None:
                watches.append(lambda tick: advance(tick.time + made.dt))
            _consume(made, drivers, count, recorder, watches, realtime)
    return read_recording(place.whole_path)


def _simulated(sim: "Simulation | World | str | Path", seed: int | None) -> "AbstractContextManager[Simulation]":
    """Return a simulation, which stays open after the block, or that of a world, which is closed then."""
    from mjsim.sim import Simulation

    if not isinstance(sim, Simulation):
        return Simulation(sim if isinstance(sim, World) else load_runnable(sim), seed=seed)
    if seed is not None:
        raise UsageError(
            "a simulation already has its seed; write Simulation(world, seed=...), or give the world to run"
        )
    return nullcontext(sim)


def one_blas_thread() -> threadpool_limits:
    """Return a context with one BLAS thread: small matrices are several times faster, and the same on every machine."""
    return threadpool_limits(1, user_api="blas")


def recorder_of(
    sim: "Simulation", drivers: Mapping[str, Driver], count: int, place: NewFile, *, pictures: bool = True
) -> "Recorder":
    """Return the recorder of a run with this many ticks.

    Raises:
        RecordingError: The file cannot be written.
    """
    from mjsim.record import Recorder

    metadata = {"command": " ".join(sys.argv), "seconds": str(count * sim.dt), "modules": _modules_text(drivers)}
    return Recorder(place, world=sim.world, seed=sim.seed, robots=sim.robots, metadata=metadata, pictures=pictures)


def record_paths(drivers: Mapping[str, Driver], recorder: "Recorder", now: float) -> None:
    """Record the final trajectories of estimators after the last tick, at time `now` [s].

    Raises:
        ModuleFault: An estimator raised, or returned an invalid value.
    """
    for robot, driver in drivers.items():
        path = final_path(robot, driver, now)
        if path is not None:
            recorder.path(robot, now, path)


def _modules_text(drivers: Mapping[str, Driver]) -> str:
    """Return the classes of all modules as JSON: robot -> part -> name."""
    parts = ("observer", "estimator", "navigator")
    return json.dumps(
        {
            name: {part: name_of(module) for part in parts if (module := getattr(driver, part)) is not None}
            | {f"controllers/{part}": name_of(controller_of(each)) for part, each in driver.controllers.items()}
            for name, driver in drivers.items()
        }
    )


def _consume(
    sim: "Simulation",
    drivers: Mapping[str, Driver],
    count: int,
    recorder: "Recorder",
    watches: Sequence[Callable[[Tick], None]],
    realtime: bool,
) -> None:
    began = time.perf_counter()
    try:
        with closing(ticks(sim, drivers)) as loop:
            for tick in islice(loop, count):
                recorder.write(tick)
                for watch in watches:
                    watch(tick)
                if realtime:
                    time.sleep(max(0.0, began + tick.time - time.perf_counter()))
        record_paths(drivers, recorder, tick.time)
    except ModuleFault as fault:
        if fault.robot is not None:
            with suppress(RecordingError):  # The fault may be that the module closed the file.
                recorder.event(fault.robot, RobotEvent(sim.time, "fault", str(fault)))
        raise


FALLEN = math.cos(math.radians(45.0))
"""Cosine of the lean from which a robot has fallen; no ramp is so steep."""
UPRIGHT = math.cos(math.radians(20.0))
"""Cosine of the lean up to which it stands again."""


class Falls:
    """Detects falls of robots from their true poses; a fall ends when the robot stands upright again."""

    def __init__(self) -> None:
        """Start with all robots upright."""
        self._lying: set[str] = set()

    def noted(self, orders: Mapping[str, Order], poses: Mapping[str, Pose3], time: float) -> dict[str, Order]:
        """Return the orders of a tick, with falls that begin now added to their events."""
        return {
            name: replace(order, events=(*order.events, RobotEvent(time, "fall", Sentence("{name} fell over", name))))
            if name in poses and self._falls(name, poses[name])
            else order
            for name, order in orders.items()
        }

    def _falls(self, name: str, pose: Pose3) -> bool:
        """Return whether a robot falls now."""
        upright = 1.0 - 2.0 * (pose.qx * pose.qx + pose.qy * pose.qy)  # z of the body's z axis
        if name in self._lying:
            if upright > UPRIGHT:
                self._lying.remove(name)
            return False
        if upright > FALLEN:
            return False
        self._lying.add(name)
        return True
