"""Converts the log of one robot, with separate times for each sensor, to observations at ticks."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array, Pose3, places_at, poses_at
from mjsim.interface import Command, ImuReading, Observation, Odometry, PointCloud, Scan, Sighting, retimed
from mjsim.inventory import Fate, told
from mjsim.logs.resampling.noise_file import UNBIASED, Bias, bias_note
from mjsim.logs.resampling.record_output import Output
from mjsim.logs.resampling.resample import MotionNoise, motions, track_motions, unknown_motion
from mjsim.logs.resampling.ticks import write_ticks
from mjsim.logs.resampling.timed_readings import Damage, DamagedReadingError, Readings, stamps_of
from mjsim.record import LoggedCamera, LoggedFrame
from mjsim.world import World

SAME_TIME = 2e-6
"""Times that differ by less are equal: the resolution of times since 1970, as usually written and as doubles [s]."""
MAX_WAIT = 2.0
"""Maximum time that a scan waits for its own tick; later scans are left out [s]."""
NO_ODOMETRY = told(Fate.LEFT_OUT, "none; the motion of each tick is unknown")
"""Entry of the metadata for a log without odometry."""
RESTARTS = "restarts of odometry left out"
"""Entry of the metadata with their number and times."""
Taken = TypeVar("Taken", Scan, LoggedFrame, PointCloud)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RobotLog:
    """The log of one robot; all times are by one clock, in ascending order [s]."""

    twists: Array = field(default_factory=lambda: np.zeros((0, 3)))
    """Rows of time [s], forward [m/s], turn [rad/s] and, if it can move sideways, left [m/s], shape (N, 3 or 4); each
    holds until the next."""
    track: Array | None = None
    """Rows of time [s], x, y [m] and heading [rad] in a frame that drifts, shape (K, 4): odometry, if the log has
    poses. Then the twists are the commands."""
    sightings: Sequence[Sighting] = ()
    identities: Sequence[str | None] | None = None
    """True landmark of each sighting; None if unknown."""
    scans: Mapping[str, Readings[Scan]] = field(default_factory=dict)
    """By the name of the lidar. Ticks are moved to the scans of the first."""
    cameras: Mapping[str, Readings[LoggedFrame]] = field(default_factory=dict)
    """By the name of the camera. Without scans, ticks are moved to the pictures of the first."""
    clouds: Mapping[str, Readings[PointCloud]] = field(default_factory=dict)
    """By the name of the 3-D lidar. Without scans and pictures, ticks are moved to the clouds of the first."""
    imu: Sequence[ImuReading] = ()
    truth: Array | None = None
    """Rows of time [s], x, y [m] and heading [rad], shape (M, 4); None if the log has none."""
    poses: Array | None = None
    """3-D ground truth, if the log has it: rows of time [s], x, y, z [m] and unit quaternion x, y, z, w, shape (M, 8);
    replaces `truth`."""
    gap: float = 0.1
    """Maximum time between two rows of truth to interpolate [s]."""
    damage: Damage = field(default_factory=Damage)
    """Readings that could not be loaded; filled while they are recorded."""

    def has_odometry(self) -> bool:
        """Return whether it has odometry or commands; constant poses do not count."""
        if self.track is None:
            return bool(len(self.twists))
        return bool(len(self.twists) or np.ptp(self.track[:, 1:], axis=0).any())


def write_robot_logs(
    world: World,
    logs: Mapping[str, RobotLog],
    *,
    span: tuple[float, float],
    noise: MotionNoise,
    bias: Bias = UNBIASED,
    metadata: Mapping[str, str],
    cameras: Mapping[tuple[str, str], LoggedCamera] = MappingProxyType({}),
    output: Output,
) -> Iterator[float]:
    """Write logs as a recording, and yield the progress [%].

    Args:
        world: World with the robots at their starts; its rate is that of the ticks.
        logs: Logs by the names of robots.
        span: First and last time of the log's clock; the first is 0 in the recording [s].
        noise: Noise of the motion.
        bias: Subtracted from odometry and sightings.
        metadata: Origin of the log.
        cameras: Data sheets of cameras whose pictures are stored, by robot and camera.
        output: The recording.

    Raises:
        RecordingError: It cannot be written.
    """
    dt = world.run.steps_per_tick * world.run.step
    count = int((span[1] - span[0]) / dt + 1e-9) + 1
    accounts = {name: _Ticked(log, noise, bias, start=span[0], dt=dt, count=count) for name, log in logs.items()}
    left_out = {
        f"{f'{name} ' if len(accounts) > 1 else ''}{sensor} {kind} left out": str(left)
        for name, account in accounts.items()
        for sensor, kind, left in account.left_out()
    }
    return write_ticks(
        world,
        accounts,
        metadata={"log start": repr(span[0]), **left_out, **bias_note(bias), **metadata},
        damage={name: log.damage for name, log in logs.items()},
        cameras=cameras,
        output=output,
    )


def _readings_at(stamps: Array, edges: Array) -> dict[int, int]:
    """Return tick -> index of its reading: each reading waits for the first tick without one.

    Args:
        stamps: Stamps of the readings of one sensor, shape (N,), ascending [s].
        edges: Times of the ticks, shape (K,), ascending [s].
    """
    arrived = np.searchsorted(stamps, edges + SAME_TIME, side="right").tolist()
    assigned, following = {}, int(np.searchsorted(stamps, edges[0] - SAME_TIME))
    for row, count in enumerate(arrived):
        if following < count:
            if edges[row] - stamps[following] > MAX_WAIT:
                following = count - 1
            assigned[row] = following
            following += 1
    return assigned


class _Ticked:
    """The log of one robot, tick by tick.

    A tick with a scan has the time of that scan: odometry, truth and scan belong to the same instant, however unevenly
    scans were logged; it is the stamp of odometry and scan. (Odometry in old logs is exact only where it came with a
    scan.) Without scans, pictures are used instead. Its time in the recording is later by less than a tick, or by the
    waiting time of readings that arrived at once.
    """

    def __init__(self, log: RobotLog, noise: MotionNoise, bias: Bias, *, start: float, dt: float, count: int) -> None:
        self._bias = bias
        self._log, self._dt, self._end = log, dt, start + dt * (count - 1)
        nominal = np.asarray(start + dt * np.arange(count), dtype=float)
        self._scans = {name: _readings_at(scans.stamps, nominal) for name, scans in log.scans.items()}
        self._pictures = {name: _readings_at(frames.stamps, nominal) for name, frames in log.cameras.items()}
        self._clouds = {name: _readings_at(clouds.stamps, nominal) for name, clouds in log.clouds.items()}
        edges = self._moments(nominal)
        self._ends = np.where(np.abs(edges - nominal) > SAME_TIME, edges - start, np.nan).tolist()
        rest = Odometry(0.0, 0.0, 0.0, np.zeros((3, 3)))
        if not log.has_odometry():
            told = [unknown_motion(dt)] * (count - 1)
        elif log.track is None:
            told = motions(bias.corrected_times(log.twists), edges, noise)
        else:
            told = track_motions(bias.corrected_times(log.track), edges, noise)
        lasting = np.diff(edges).tolist()
        self._motions = [rest, *(bias.corrected_motion(step, time) for step, time in zip(told, lasting, strict=True))]
        self._sightings = _rows_since(np.array([sighting.stamp for sighting in log.sightings]), edges)
        self._imu = _rows_since(stamps_of(log.imu), edges)
        self._start = start
        self._twists = _held(log.twists, edges) if log.track is None or len(log.twists) else self._mean_twists()
        self.poses = poses_at(edges, log.poses, gap=log.gap) if log.poses is not None else None
        self.truth = self._truth(edges)

    def observation(self, row: int) -> Observation:
        """Return the observation since the previous tick."""
        return Observation(
            time=row * self._dt,
            dt=self._dt,
            odometry=self._motion(row),
            sightings=tuple(
                self._bias.corrected_sighting(self._shifted(self._log.sightings[k]))
                for k in range(*self._sightings[row])
            ),
            cameras=self._taken_at(self._log.cameras, self._pictures, row),
            scans=self._taken_at(self._log.scans, self._scans, row),
            clouds=self._taken_at(self._log.clouds, self._clouds, row),
            imu=tuple(
                ImuReading(reading.stamp - self._start, reading.acceleration, reading.turn, reading.name)
                for reading in sorted(
                    (self._log.imu[k] for k in range(*self._imu[row])), key=lambda reading: reading.name
                )
            ),
            proximity=np.full(16, np.inf),
        )

    def command(self, row: int) -> Command:
        """Return the twist that holds at the tick."""
        forward, left, turn = self._twists[row].tolist()
        return Command(forward, left, turn)

    def identities(self, row: int) -> tuple[str | None, ...]:
        """Return the true landmarks of the sightings of a tick."""
        if self._log.identities is None:
            return ()
        begin, end = self._sightings[row]
        return tuple(self._log.identities[begin:end])

    def left_out(self) -> Iterator[tuple[str, str, int]]:
        """Yield each lidar, camera and 3-D lidar, its kind of reading, and how many readings have no tick."""
        scans = [(name, "scans", self._log.scans[name].stamps, rows) for name, rows in self._scans.items()]
        pictures = [(name, "pictures", self._log.cameras[name].stamps, rows) for name, rows in self._pictures.items()]
        clouds = [(name, "clouds", self._log.clouds[name].stamps, rows) for name, rows in self._clouds.items()]
        for name, kind, stamps, rows in scans + pictures + clouds:
            within = (stamps >= self._start - SAME_TIME) & (stamps <= self._end + SAME_TIME)
            yield name, kind, int(within.sum()) - len(rows)

    def _moments(self, nominal: Array) -> Array:
        """Return the time in the log of each tick, ascending, shape (N,) [s]."""
        edges = nominal.copy()
        leading = [(self._log.scans[name].stamps, rows) for name, rows in self._scans.items()]
        leading += [(self._log.cameras[name].stamps, rows) for name, rows in self._pictures.items()]
        leading += [(self._log.clouds[name].stamps, rows) for name, rows in self._clouds.items()]
        for stamps, rows in leading[:1]:
            edges[list(rows)] = stamps[list(rows.values())]
        # Data after a delayed scan must not precede it: a tick without a scan keeps to the following ones.
        return np.minimum.accumulate(edges[::-1])[::-1]

    def _truth(self, edges: Array) -> Array:
        """Return the true pose at each tick, NaN where unknown, shape (N, 3)."""
        if self.poses is not None:
            return np.array([Pose3(*row).planar().as_array() for row in self.poses.tolist()])
        if self._log.truth is not None:
            return places_at(edges, self._log.truth, gap=self._log.gap)
        return np.full((len(edges), 3), np.nan)

    def _motion(self, row: int) -> Odometry:
        """Return the motion since the previous tick, with the time of its end if it is not the tick's."""
        end = self._ends[row]
        return replace(self._motions[row], stamp=None if math.isnan(end) else end)

    def _taken_at(self, sensors: Mapping[str, Readings[Taken]], ticks: Mapping[str, dict[int, int]], row: int) -> Any:
        """Return the readings of a tick by sensor, with the times when they were taken, not after the tick [s]."""
        found = {name: self._loaded(name, sensors[name], rows[row]) for name, rows in ticks.items() if row in rows}
        now = row * self._dt
        shifted = {name: self._shifted(each) for name, each in found.items() if each is not None}
        return {name: replace(each, stamp=min(max(each.stamp, 0.0), now)) for name, each in shifted.items()}

    def _loaded(self, name: str, readings: Readings[Taken], number: int) -> Taken | None:
        """Return a reading of a sensor; None if it is damaged, which is noted."""
        try:
            return readings.take(number)
        except DamagedReadingError as error:
            self._log.damage.add(f"readings of {name}", error)
            return None

    def _shifted(self, reading: Any) -> Any:
        return retimed(reading, lambda time: time - self._start)

    def _mean_twists(self) -> Array:
        """Return the mean twist of each tick, for a log without commands, shape (N, 3)."""
        return np.array([[step.forward, step.left, step.turn] for step in self._motions]) / self._dt


def _rows_since(stamps: Array, edges: Array) -> list[tuple[int, int]]:
    """Return the first row and the end of the rows of each tick: all since the previous tick."""
    # A stamp equal to the tick's time is given immediately.
    ends = np.searchsorted(stamps, edges + SAME_TIME, side="right").tolist()
    return list(pairwise([int(np.searchsorted(stamps, edges[0] - SAME_TIME)), *ends]))


def _held(twists: Array, edges: Array) -> Array:
    """Return the twist that holds at each tick, shape (N, 3) [m/s, m/s, rad/s]."""
    if not len(twists):
        return np.zeros((len(edges), 3))
    held: NDArray[np.intp] = np.searchsorted(twists[:, 0], edges, side="right") - 1
    forward, turn, *left = np.where((held >= 0)[:, None], twists[np.maximum(held, 0), 1:], 0.0).T
    return np.column_stack([forward, left[0] if left else np.zeros(len(edges)), turn])
