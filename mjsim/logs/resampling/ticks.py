"""Writes observations of robots, tick by tick, to a recording."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Protocol

import numpy as np

from mjsim.errors import MAX_MESSAGE_LENGTH, UsageError, WorldError
from mjsim.geometry import Array, Pose, Pose3
from mjsim.interface import Command, Observation
from mjsim.logs.resampling.record_output import Output
from mjsim.logs.resampling.timed_readings import Damage
from mjsim.record import (
    LOGGED_CAMERAS,
    LoggedCamera,
    Order,
    Recorder,
    Tick,
    cameras_text,
    with_logged_cameras,
)
from mjsim.run import Driver, Pilot
from mjsim.sim import Simulation
from mjsim.world import World, parse_world

SEED = 0
"""Seed of an imported recording, used only by replayed modules."""


class Account(Protocol):
    """Observations and true poses of one robot, by index of the tick."""

    @property
    def truth(self) -> Array:
        """True pose at each tick, shape (N, 3) [m, m, rad]; NaN rows where unknown."""

    @property
    def poses(self) -> Array | None:
        """The same in 3-D, rows as in `Pose3`, shape (N, 7); None if the robot stays upright on the floor."""

    def observation(self, row: int) -> Observation:
        """Return the observation since the previous tick."""

    def command(self, row: int) -> Command:
        """Return the command to its drive at the tick."""

    def identities(self, row: int) -> tuple[str | None, ...]:
        """Return the true landmarks of the sightings of the tick; empty if unknown."""


def write_ticks(
    world: World,
    accounts: Mapping[str, Account],
    *,
    metadata: Mapping[str, str],
    cameras: Mapping[tuple[str, str], LoggedCamera] = MappingProxyType({}),
    damage: Mapping[str, Damage] = MappingProxyType({}),
    output: Output,
) -> Iterator[float]:
    """Write the observations of robots as a recording, and yield the progress [%].

    Args:
        world: World with the robots at their starts; its rate is that of the ticks.
        accounts: Accounts by the names of robots, all with the same number of ticks.
        metadata: Origin of the data.
        cameras: Data sheets of cameras whose pictures are stored, by robot and camera.
        damage: Readings that the accounts could not load, by the name of the robot; noted after the last tick.
        output: The recording.

    Raises:
        RecordingError: It cannot be written.
    """
    count = len(next(iter(accounts.values())).truth)
    with Simulation(world, seed=SEED) as sim:
        content = {"command": output.command, "seconds": str(count * sim.dt), **metadata}
        content |= {LOGGED_CAMERAS: cameras_text(cameras)} if cameras else {}
        infos = with_logged_cameras(sim.robots, cameras)
        robots = {name: _Robot(account, sim, name) for name, account in accounts.items()}
        with Recorder(output.place, world=world, seed=SEED, robots=infos, metadata=content) as recorder:
            for row, tick in enumerate(_ticks(sim, robots, count), start=1):
                recorder.write(tick)
                yield 100.0 * row / count
            recorder.add_metadata(_damaged(damage))
            output.place.is_whole = True


def _damaged(damage: Mapping[str, Damage]) -> dict[str, str]:
    """Return the metadata about damaged readings of robots, named if there are several."""
    return {
        f"{fact} of {robot}" if len(damage) > 1 else fact: value
        for robot, each in damage.items()
        for fact, value in each.notes().items()
    }


def cut(first: float, last: float, *, begin: float, seconds: float | None, rate_hz: float) -> tuple[float, float]:
    """Return start and end of the imported part of a log.

    Args:
        first: Start of the log, by its own clock [s].
        last: End of the log [s].
        begin: Time to skip at the beginning [s].
        seconds: Duration to import; by default all [s].
        rate_hz: Ticks per second.

    Raises:
        UsageError: It is too short for two ticks.
    """
    if last < first:
        raise UsageError(f"some files of the log end at {last:.15g} s, before others begin, at {first:.15g} s")
    start = first + begin
    end = last if seconds is None else min(last, start + seconds)
    left, dt = max(end - start, 0.0), 1.0 / rate_hz
    if left < dt:
        raise UsageError(
            f"{left:.6g} s of a log of {last - first:.6g} s remain; two ticks are {dt:g} s apart: give less --begin,"
            " or more --seconds"
        )
    return start, end


def name_from(path: Path) -> str:
    """Return a name for the world of a log, from that of its folder or file."""
    return re.sub(r"[^A-Za-z0-9_.-]", "-", path.resolve().name).lstrip(".-")[:64] or "log"


def generated_world(text: str, source: str) -> World:
    """Return the world of a text that was made from a log.

    Args:
        text: Text of a world file.
        source: Where its numbers are from, for error messages.

    Raises:
        UsageError: A name or a number is not possible in a world.
    """
    try:
        return parse_world(text)
    except WorldError as error:
        # Positions in a generated text mean nothing to the user.
        raise UsageError(f"{source} cannot be recorded: {error.problems[0].message}"[:MAX_MESSAGE_LENGTH]) from None


def _ticks(sim: Simulation, robots: Mapping[str, "_Robot"], count: int) -> Iterator[Tick]:
    """Yield the ticks of all robots together."""
    qpos, qvel = sim.state()
    for row in range(count):
        seen = {name: robot.account.observation(row) for name, robot in robots.items()}
        orders = {name: robot.order(row, seen[name]) for name, robot in robots.items()}
        for name, robot in robots.items():
            robot.place(qpos, row, orders[name].dead_reckoning)
        truth = {name: pose for name, robot in robots.items() if (pose := robot.truth(row)) is not None}
        yield Tick(
            time=row * sim.dt,
            truth=truth,
            poses={name: robots[name].pose(row, planar) for name, planar in truth.items()},
            seen=seen,
            orders=orders,
            qpos=qpos.copy(),
            qvel=qvel,
            looks=sim.looks,
            identities={name: robot.account.identities(row) for name, robot in robots.items()},
        )


class _Robot:
    """One robot of a log in the scene."""

    def __init__(self, account: Account, sim: Simulation, name: str) -> None:
        self.account = account
        info = sim.robots[name]
        self._pilot = Pilot(Driver(), info, dict(sim.catalogue), sim.map, seed=SEED)
        self._free = int(sim.model.joint(f"{name}/free").qposadr[0])
        self._place = info.prior
        known = np.flatnonzero(np.isfinite(account.truth).all(axis=1))
        self._known_from = int(known[0]) if len(known) else len(account.truth)

    def order(self, row: int, seen: Observation) -> Order:
        """Return dead reckoning, and the command of the log."""
        command = self.account.command(row)
        return replace(self._pilot.decide(seen), command=command, wanted=command)

    def truth(self, row: int) -> Pose | None:
        """Return the true pose of the robot, None if unknown."""
        pose = self.account.truth[row]
        return Pose.from_array(pose) if np.isfinite(pose).all() else None

    def pose(self, row: int, planar: Pose) -> Pose3:
        """Return the true 3-D pose of the robot, given its pose seen from above."""
        poses = self.account.poses
        return Pose3.from_planar(planar) if poses is None else Pose3(*poses[row].tolist())

    def place(self, qpos: Array, row: int, believed: Pose) -> None:
        """Place the robot at its true pose, or the last known one, or before that at its pose by odometry."""
        known = self.truth(row)
        if known is not None:
            self._place = known
        elif row < self._known_from:
            self._place = believed
        half = self._place.heading / 2
        start = self._free
        qpos[start : start + 2] = self._place.x, self._place.y
        qpos[start + 3 : start + 7] = np.cos(half), 0.0, 0.0, np.sin(half)
