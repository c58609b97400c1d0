"""Recorded data of one robot, as arrays."""

from collections.abc import Hashable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mjsim.geometry import Array, places_at, poses_at
from mjsim.interface import Shown, Sighting
from mjsim.record.tick import RobotEvent
from mjsim.sentences import number_of
from mjsim.views import Viewed


def span_of(time: Array) -> str:
    """Return the number of ticks and their duration, as a text."""
    return f"{number_of(len(time), 'tick')} in {time[-1] - time[0]:g} s" if len(time) else "no ticks"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Landmarks:
    """The estimated map over time; NaN before a landmark is in it. One row per tick, N in all."""

    names: tuple[Hashable, ...]
    """Names of K landmarks, in order of first appearance."""
    mean: Array
    """Shape (N, K, 2) [m]."""
    covariance: Array
    """Shape (N, K, 2, 2) [m^2]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class Track(Viewed):
    """Recorded data of one robot. One row per tick, N in all; poses are (x, y, heading) [m, m, rad].

    A robot without a driver has only its truth, and NaN elsewhere.
    """

    time: Array
    """Shape (N,) [s]."""
    moment: Array | None = None
    """When the robot was at the poses of each row, shape (N,) [s]: in a log, at the scan that came with the tick, less
    than a tick before `time`. None: at that time."""
    truth: Array
    """Seen from above, shape (N, 3), world frame."""
    truth_pose: Array
    """3-D pose of the base: position and unit quaternion (x, y, z, qx, qy, qz, qw), world frame, shape (N, 7)."""
    odometry: Array
    """Dead reckoning, shape (N, 3)."""
    odometry_covariance: Array
    """Shape (N, 3, 3)."""
    estimate: Array
    """Shape (N, 3)."""
    covariance: Array
    """Shape (N, 3, 3)."""
    command: Array
    """(forward, left, turn) given to the drive, shape (N, 3) [m/s, m/s, rad/s]; NaN rows for wheel commands."""
    landmarks: Landmarks
    sightings: tuple[tuple[Sighting, ...], ...]
    """One tuple per tick."""
    identities: tuple[tuple[str | None, ...], ...] = ()
    """One tuple per tick: the true beacons of its first sightings, those of the beacon sensors; None for a false
    sighting."""
    innovations: tuple[tuple[tuple[Hashable, Array, Array], ...], ...]
    """One tuple per tick: name, nu (2,), S (2, 2)."""
    shown: tuple[tuple[Shown, ...], ...] = ()
    """One tuple per tick: items shown by modules."""
    events: tuple[RobotEvent, ...]
    path: Array = field(default_factory=lambda: np.zeros((0, 4)))
    """Final trajectory of the estimator, if it provides one: rows of time, x, y and heading, shape (M, 4)."""

    def __repr__(self) -> str:
        """Return its span and the amount of its data."""
        seen = sum(map(len, self.sightings))
        return f"<Track: {span_of(self.time)}, {seen} sightings, {number_of(len(self.landmarks.names), 'landmark')}>"

    @property
    def moments(self) -> Array:
        """When the robot was at the poses of each row, ascending, shape (N,) [s]."""
        return self.time if self.moment is None else self.moment

    def truth_at(self, times: ArrayLike) -> Array:
        """Return the true 3-D poses of the base at some times, such as the stamps of a camera, as in `truth_pose`.

        Args:
            times: Shape (K,) [s].

        Returns:
            Shape (K, 7), interpolated between two ticks; NaN where the truth is unknown.
        """
        track = np.column_stack([self.moments, self.truth_pose])
        return poses_at(np.asarray(times, dtype=float), track, gap=np.inf)

    def odometry_at(self, times: ArrayLike) -> Array:
        """Return dead reckoning at some times, interpolated between two ticks; NaN outside, shape (K, 3)."""
        return places_at(np.asarray(times, dtype=float), np.column_stack([self.moments, self.odometry]), gap=np.inf)

    def at(self, rows: NDArray[np.intp]) -> "Track":
        """Return the track at some rows; events and the final trajectory are kept completely."""
        marks, chosen = self.landmarks, rows.tolist()
        return replace(
            self,
            time=self.time[rows],
            moment=None if self.moment is None else self.moment[rows],
            truth=self.truth[rows],
            truth_pose=self.truth_pose[rows],
            odometry=self.odometry[rows],
            odometry_covariance=self.odometry_covariance[rows],
            estimate=self.estimate[rows],
            covariance=self.covariance[rows],
            command=self.command[rows],
            landmarks=Landmarks(names=marks.names, mean=marks.mean[rows], covariance=marks.covariance[rows]),
            sightings=tuple(self.sightings[row] for row in chosen),
            identities=tuple(self.identities[row] for row in chosen) if self.identities else (),
            innovations=tuple(self.innovations[row] for row in chosen),
            shown=tuple(self.shown[row] for row in chosen) if self.shown else (),
        )
