"""A recording in memory: arrays by robot, one row a tick."""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from pathlib import Path

from mjsim.geometry import Array
from mjsim.interface import Sighting
from mjsim.record.tick import Event
from mjsim.world import World


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Landmarks:
    """The estimated map over time; NaN before a landmark is in it. One row a tick, N in all."""

    names: tuple[Hashable, ...]
    """K landmarks, in the order in which they came."""
    mean: Array
    """Shape (N, K, 2) [m]."""
    covariance: Array
    """Shape (N, K, 2, 2) [m^2]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Track:
    """Everything recorded of one robot. One row a tick, N in all; poses are (x, y, heading) [m, m, rad]."""

    time: Array
    """Shape (N,) [s]."""
    truth: Array
    """Shape (N, 3), world frame."""
    odometry: Array
    """Dead reckoning, shape (N, 3)."""
    odometry_covariance: Array
    """Shape (N, 3, 3)."""
    estimate: Array
    """Shape (N, 3)."""
    covariance: Array
    """Shape (N, 3, 3)."""
    command: Array
    """(forward, left, turn) told to the drive, shape (N, 3) [m/s, m/s, rad/s]; NaN rows for wheel commands."""
    landmarks: Landmarks
    sightings: tuple[tuple[Sighting, ...], ...]
    """One tuple a tick."""
    innovations: tuple[tuple[tuple[Hashable, Array, Array], ...], ...]
    """One tuple a tick: name, nu (2,), S (2, 2)."""
    events: tuple[Event, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Recording:
    """A run that was recorded; it needs nothing but its file."""

    path: Path
    world: World
    seed: int
    metadata: Mapping[str, str]
    """Versions and command line."""
    time: Array
    """Shape (N,) [s]."""
    qpos: Array
    """Shape (N, nq)."""
    qvel: Array
    """Shape (N, nv)."""
    robots: Mapping[str, Track]
    wall_seconds: float
    """Time on the clock from the first tick to the last."""
    module_seconds: Mapping[str, Array]
    """Wall-clock time by 'robot/module' or 'loop/part', shape (N,) [s]."""
