"""The one loop, as a generator of ticks; `run` consumes it into a recording."""

import json
import shutil
import sys
import tempfile
import time
import weakref
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from threadpoolctl import threadpool_limits

from mjsim.errors import ModuleFault, UsageError, did_you_mean
from mjsim.record.tick import Event, Tick
from mjsim.run.pilot import Driver, Pilot, Steer
from mjsim.world import World
from mjsim.world.use import make_module

if TYPE_CHECKING:
    from mjsim.record import Recorder, Recording
    from mjsim.sim import Simulation


def ticks(sim: "Simulation", drivers: Mapping[str, Driver], *, steer: Steer | None = None) -> Iterator[Tick]:
    """Yield one Tick per period, for as long as the caller asks for more.

    Args:
        sim: Where the robots are.
        drivers: The modules of each robot that is driven.
        steer: Asked for each of them at each tick; a command that it returns takes the place of the navigator's.

    Raises:
        UsageError: A driver is for a robot that is not there.
        ModuleFault: A module raised, or returned what it must not.
        PhysicsFault: The simulation is no longer to be trusted.
    """
    for name in drivers:
        if name not in sim.robots:
            raise UsageError(f"no robot '{name}' in this world{did_you_mean(name, sim.robots)}")
    pilots = {
        name: Pilot(driver, sim.robots[name], dict(sim.catalogue), sim.map, seed=sim.seed, steer=steer)
        for name, driver in drivers.items()
    }
    physics = 0.0
    while True:
        began = time.perf_counter()
        seen = {name: sim.sense(name) for name in pilots}
        sensing = time.perf_counter() - began
        orders = {name: pilot.decide(seen[name]) for name, pilot in pilots.items()}
        qpos, qvel = sim.state()
        yield Tick(
            time=sim.time,
            truth=sim.truths(),
            seen=seen,
            orders=orders,
            qpos=qpos,
            qvel=qvel,
            timing={"sense": sensing, "step": physics},
            events=sim.happened(),
            things=sim.things(),
            looks=sim.looks,
            identities={name: sim.identities(name) for name in pilots},
        )
        began = time.perf_counter()
        for name, order in orders.items():
            sim.apply(name, order.command)
        sim.step()
        physics = time.perf_counter() - began


def drivers_of(world: World) -> dict[str, Driver]:
    """Return a driver for each robot of a world, its modules made as `run: drivers:` says.

    Raises:
        UsageError: A module or class is not there, or does not take its arguments.
    """
    drivers = {}
    for robot in world.robots:
        modules = world.run.drivers.get(robot.name)
        if modules is None:
            drivers[robot.name] = Driver()
            continue
        observer, estimator, navigator = (
            make_module(use, world.source) if use is not None else None
            for use in (modules.observer, modules.estimator, modules.navigator)
        )
        avoidance = modules.avoidance
        drivers[robot.name] = Driver(
            observer=observer,
            estimator=estimator,
            navigator=navigator,
            avoidance=avoidance if isinstance(avoidance, bool) else make_module(avoidance, world.source),
            push=modules.push,
        )
    return drivers


def run(
    sim: "Simulation",
    *,
    drivers: Mapping[str, Driver] | None = None,
    seconds: float | None = None,
    record: str | Path | None = None,
    watch: Callable[[Tick], None] | None = None,
    realtime: bool = False,
    pictures: bool = True,
) -> "Recording":
    """Run a simulation from now on and return its recording.

    Args:
        sim: Where the robots are.
        drivers: The modules of each robot; those of the world file unless given.
        seconds: How long, simulated [s]; as the world file says unless given.
        record: The MCAP file to write; a temporary one, gone with the recording, unless given.
        watch: Called with each tick, after it is recorded.
        realtime: Go no faster than the clock.
        pictures: Whether the recording holds those of the cameras, which are most of it; they can be drawn again.

    Raises:
        UsageError: It would have no tick, or the file cannot be written.
        MjsimError: As `ticks`; what was recorded until then stays readable in `record`.
    """
    from mjsim.record import read_recording

    if drivers is None:
        drivers = drivers_of(sim.world)
    count = tick_count(sim, seconds)
    folder = None
    if record is None:
        folder = tempfile.mkdtemp(prefix="mjsim-")
        record = Path(folder) / "run.mcap"
    with one_blas_thread(), recorder_of(sim, drivers, count, record, pictures=pictures) as recorder:
        _consume(sim, drivers, count, recorder.write, recorder.event, watch, realtime)
    recording = read_recording(record)
    if folder is not None:
        weakref.finalize(recording, shutil.rmtree, folder, ignore_errors=True)
    return recording


def tick_count(sim: "Simulation", seconds: float | None) -> int:
    """Return how many ticks a run of so many seconds has, as long as the world says unless given.

    Raises:
        UsageError: It would have none.
    """
    seconds = sim.world.run.seconds if seconds is None else seconds
    count = round(seconds / sim.dt)
    if count < 1:
        raise UsageError(f"seconds is {seconds:g}; a run has at least one tick of {sim.dt:g} s")
    return count


def one_blas_thread() -> threadpool_limits:
    """Return what keeps BLAS to one thread: small matrices are several times faster, and the same on every machine."""
    return threadpool_limits(1, user_api="blas")


def recorder_of(
    sim: "Simulation", drivers: Mapping[str, Driver], count: int, path: str | Path, *, pictures: bool = True
) -> "Recorder":
    """Return what records a run of so many ticks.

    Raises:
        RecordingError: The file cannot be written.
    """
    from mjsim.record import Recorder

    metadata = {"command": " ".join(sys.argv), "seconds": str(count * sim.dt), "modules": _modules_text(drivers)}
    return Recorder(path, world=sim.world, seed=sim.seed, robots=sim.robots, metadata=metadata, pictures=pictures)


def _modules_text(drivers: Mapping[str, Driver]) -> str:
    """Return the classes of all modules as JSON: robot -> part -> name."""
    parts = ("observer", "estimator", "navigator")
    return json.dumps(
        {
            name: {part: type(module).__name__ for part in parts if (module := getattr(driver, part)) is not None}
            for name, driver in drivers.items()
        }
    )


def _consume(
    sim: "Simulation",
    drivers: Mapping[str, Driver],
    count: int,
    write: Callable[[Tick], None],
    note: Callable[[str, Event], None],
    watch: Callable[[Tick], None] | None,
    realtime: bool,
) -> None:
    began = time.perf_counter()
    loop = ticks(sim, drivers)
    try:
        for _ in range(count):
            tick = next(loop)
            write(tick)
            if watch is not None:
                watch(tick)
            if realtime:
                time.sleep(max(0.0, began + tick.time - time.perf_counter()))
    except ModuleFault as fault:
        if fault.robot is not None:
            note(fault.robot, Event(sim.time, "fault", str(fault)))
        raise
