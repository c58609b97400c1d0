"""Logs of robots, ready to be told in ticks -> a recording."""

import re
import sys
import weakref
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from shutil import rmtree

import numpy as np

from mjsim.errors import UsageError
from mjsim.geometry import Array, Pose, Pose3
from mjsim.interface import Command, Observation, Odometry, Sighting
from mjsim.logs.merge import MotionNoise, motions, places_at
from mjsim.output import temporary_file
from mjsim.record import Order, Recorder, Recording, Tick, read_recording
from mjsim.run import Driver, Pilot
from mjsim.sim import Simulation
from mjsim.world import World

SEED = 0
"""Of an imported recording; nothing in it was drawn by lot, but a replayed module may draw."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RobotLog:
    """What one robot logged; all times are of one clock, in ascending order [s]."""

    twists: Array
    """Rows of time [s], forward [m/s] and turn [rad/s]; each holds until the next, shape (N, 3)."""
    sightings: Sequence[Sighting]
    identities: Sequence[str] | None = None
    """What each sighting is of; None where nobody knows."""
    truth: Array | None = None
    """Rows of time [s], x, y [m] and heading [rad], shape (M, 4); None when the log has none."""
    gap: float = 0.1
    """Between two rows of truth that are farther apart nothing is known [s]."""


def write_log(
    world: World,
    logs: Mapping[str, RobotLog],
    *,
    span: tuple[float, float],
    noise: MotionNoise,
    metadata: Mapping[str, str],
    record: str | Path | None,
    overwrite: bool,
    progress: Callable[[float], None] | None,
) -> Recording:
    """Write logs as a recording and return it.

    Args:
        world: With the robots at their starts; its rate is that of the ticks.
        logs: By the name of the robot.
        span: First and last time of the log's clock; the first is 0 in the recording [s].
        noise: Of the motion.
        metadata: Where the log is from.
        record: The MCAP file; a temporary one, gone with the recording, unless given.
        overwrite: Whether that may replace a file.
        progress: Called with how much of it is done [%].

    Raises:
        UsageError: The file exists.
        RecordingError: The file cannot be written.
    """
    if record is None:
        with temporary_file("log.mcap") as path:
            recording = write_log(
                world, logs, span=span, noise=noise, metadata=metadata, record=path, overwrite=False, progress=progress
            )
        weakref.finalize(recording, rmtree, path.parent, ignore_errors=True)
        return recording
    dt = world.run.steps_per_tick * world.run.step
    count = int((span[1] - span[0]) / dt + 1e-9) + 1
    told = {"command": " ".join(sys.argv), "log start": repr(span[0]), "seconds": str(count * dt), **metadata}
    with Simulation(world, seed=SEED) as sim:
        tellers = {name: _Teller(log, sim, name, span[0], count, noise) for name, log in logs.items()}
        with Recorder(
            record, world=world, seed=SEED, robots=sim.robots, metadata=told, overwrite=overwrite
        ) as recorder:
            for tick in _ticks(sim, tellers, count):
                recorder.write(tick)
                if progress is not None:
                    progress(100.0 * (tick.time / sim.dt + 1.0) / count)
    return read_recording(record)


def cut(first: float, last: float, *, begin: float, seconds: float | None, rate_hz: float) -> tuple[float, float]:
    """Return from when to when a log is taken.

    Args:
        first: When it begins, by its own clock [s].
        last: When it ends [s].
        begin: How much of the beginning is left out [s].
        seconds: How much is taken; all unless given [s].
        rate_hz: Ticks a second.

    Raises:
        UsageError: Two ticks do not fit into that.
    """
    start = first + begin
    end = last if seconds is None else min(last, start + seconds)
    left, dt = max(end - start, 0.0), 1.0 / rate_hz
    if left < dt:
        raise UsageError(f"{left:.6g} s of a log of {last - first:.6g} s are left; two ticks are {dt:g} s apart")
    return start, end


def name_from(folder: Path) -> str:
    """Return a name for the world of a log that is in a folder."""
    return re.sub(r"[^A-Za-z0-9_.-]", "-", folder.resolve().name)[:64] or "log"


def _ticks(sim: Simulation, tellers: Mapping[str, "_Teller"], count: int) -> Iterator[Tick]:
    """Yield the ticks of all robots together."""
    qpos, qvel = sim.state()
    for row in range(count):
        seen = {name: teller.observe(row) for name, teller in tellers.items()}
        orders = {name: teller.order(row, seen[name]) for name, teller in tellers.items()}
        for name, teller in tellers.items():
            teller.stand(qpos, row, orders[name].dead_reckoning)
        truth = {name: pose for name, teller in tellers.items() if (pose := teller.truth(row)) is not None}
        yield Tick(
            time=row * sim.dt,
            truth=truth,
            poses={name: Pose3.from_planar(pose) for name, pose in truth.items()},
            seen=seen,
            orders=orders,
            qpos=qpos.copy(),
            qvel=qvel,
            looks=sim.looks,
            identities={name: teller.identities(row) for name, teller in tellers.items()},
        )


class _Teller:
    """The log of one robot, told tick by tick."""

    def __init__(self, log: RobotLog, sim: Simulation, name: str, start: float, count: int, noise: MotionNoise) -> None:
        self._log, self._dt = log, sim.dt
        edges = np.asarray(start + sim.dt * np.arange(count), dtype=float)
        rest = Odometry(0.0, 0.0, 0.0, np.zeros((3, 3)))
        self._motions = [rest, *motions(log.twists, edges, noise)]
        stamps = np.array([sighting.stamp for sighting in log.sightings])
        # A tick tells what was seen since the tick before; a stamp that is its own is told at once.
        self._ends = np.searchsorted(stamps, edges + 1e-9, side="right")
        self._start = start
        self._first = int(np.searchsorted(stamps, start - 1e-9))
        held = np.searchsorted(log.twists[:, 0], edges, side="right") - 1
        self._twists = np.where((held >= 0)[:, None], log.twists[np.maximum(held, 0), 1:], 0.0)
        self._truth = places_at(edges, log.truth, gap=log.gap) if log.truth is not None else np.full((count, 3), np.nan)
        info = sim.robots[name]
        self._pilot = Pilot(Driver(), info, dict(sim.catalogue), sim.map, seed=SEED)
        self._free = int(sim.model.joint(f"{name}/free").qposadr[0])
        self._place = info.prior
        known = np.flatnonzero(np.isfinite(self._truth).all(axis=1))
        self._known_from = int(known[0]) if len(known) else count

    def observe(self, row: int) -> Observation:
        """Return what the robot sensed since the tick before."""
        sightings = tuple(
            replace(sighting, stamp=sighting.stamp - self._start) for sighting in self._log.sightings[self._news(row)]
        )
        return Observation(
            time=row * self._dt,
            dt=self._dt,
            odometry=self._motions[row],
            sightings=sightings,
            proximity=np.full(16, np.inf),
        )

    def order(self, row: int, seen: Observation) -> Order:
        """Return dead reckoning, and the twist that holds at the tick as the command."""
        forward, turn = self._twists[row].tolist()
        command = Command(forward, 0.0, turn)
        return replace(self._pilot.decide(seen), command=command, wanted=command)

    def truth(self, row: int) -> Pose | None:
        """Return where the robot was, None where the log does not tell."""
        return Pose.from_array(self._truth[row]) if np.isfinite(self._truth[row]).all() else None

    def identities(self, row: int) -> tuple[str | None, ...]:
        """Return what the sightings of a tick are of."""
        return () if self._log.identities is None else tuple(self._log.identities[self._news(row)])

    def stand(self, qpos: Array, row: int, believed: Pose) -> None:
        """Put the robot where it was, or where it was last known to be, or where it thought to be before that."""
        known = self.truth(row)
        if known is not None:
            self._place = known
        elif row < self._known_from:
            self._place = believed
        half = self._place.heading / 2
        start = self._free
        qpos[start : start + 2] = self._place.x, self._place.y
        qpos[start + 3 : start + 7] = np.cos(half), 0.0, 0.0, np.sin(half)

    def _news(self, row: int) -> slice:
        return slice(self._first if row == 0 else int(self._ends[row - 1]), int(self._ends[row]))
