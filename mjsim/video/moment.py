"""The data drawn for one robot at one instant, from a recording or from a run in progress."""

from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import Picture, Shown, Sighting
from mjsim.record import Recording, Tick
from mjsim.video.beam_points import newest_points, recorded_points
from mjsim.world import Looks


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Moment:
    """One robot at one instant; poses are (x, y, heading), shape (3,) [m, m, rad], NaN if unknown."""

    time: float
    """[s]"""
    truth: Array
    estimate: Array
    covariance: Array
    """Covariance of the estimate, shape (3, 3)."""
    odometry: Array
    """Dead reckoning."""
    names: tuple[str, ...]
    """Names of the K landmarks of the map."""
    means: Array
    """Estimated positions, shape (K, 2) [m]."""
    covariances: Array
    """Shape (K, 2, 2) [m^2]."""
    sightings: Sequence[Sighting]
    """Sightings of the last tick with a measurement."""
    picture: Picture | None
    """The newest onboard picture, RGB; None before the first."""
    touched: bool
    """Whether the robot bumped within the last half second."""
    others: Mapping[str, Array] = field(default_factory=dict)
    """True poses of the other robots."""
    things: Mapping[str, Array] = field(default_factory=dict)
    """Poses of doors, moving and movable objects, by name in the scene; by default their initial ones."""
    looks: Looks | None = None
    """Light and removed items; by default as at the start."""
    arms: Mapping[str, Array] = field(default_factory=dict)
    """Joint values of arms by `ROBOT/ARM` and of mechanisms by name, shape (joints,) [rad, m]; by default the initial
    ones."""
    scans: Mapping[str, Array] = field(default_factory=dict)
    """Points of the newest scan of each lidar, placed by the estimated pose, shape (n, 2) [m]."""
    shown: Sequence[Shown] = ()
    """Items that the modules of the robot show."""


def moment_of(
    tick: Tick, robot: str, *, before: Moment | None, lidars: Mapping[str, Array] = MappingProxyType({})
) -> Moment:
    """Return the data drawn for a tick; what the tick does not update is taken from the previous moment.

    Args:
        tick: The tick.
        robot: Name of the robot.
        before: Moment of the previous tick; None for the first.
        lidars: robot_from_sensor of the lidars whose scans are drawn, shape (4, 4) each [m].
    """
    order, seen = tick.orders[robot], tick.seen[robot]
    belief = order.estimate
    frame = next(iter(seen.cameras.values()), None)
    renewed = frame is not None or bool(order.sightings) or before is None
    return Moment(
        time=tick.time,
        truth=tick.truth[robot].as_array(),
        estimate=belief.pose.as_array(),
        covariance=belief.covariance,
        odometry=order.dead_reckoning.as_array(),
        names=tuple(map(str, belief.landmarks)),
        means=np.reshape([mean for mean, _ in belief.landmarks.values()], (-1, 2)),
        covariances=np.reshape([covariance for _, covariance in belief.landmarks.values()], (-1, 2, 2)),
        sightings=order.sightings if renewed or before is None else before.sightings,
        picture=frame.image if frame is not None else before.picture if before is not None else None,
        others={name: pose.as_array() for name, pose in tick.truth.items() if name != robot},
        touched=bool(seen.bump),
        things={name: pose.as_array() for name, pose in tick.things.items()},
        looks=tick.looks,
        arms={name: motion.positions for name, motion in tick.joints.items()},
        scans=newest_points(seen.scans, lidars, belief.pose.as_array(), before.scans if before is not None else {}),
        shown=belief.show,
    )


def moments(recording: Recording, robot: str, rows: Sequence[int]) -> Iterator[Moment]:
    """Yield the data drawn for ascending rows of a recording."""
    track = recording.robots[robot]
    bumps = np.array([event.time for event in track.events if event.kind == "bump"])
    sightings: Sequence[Sighting] = ()
    changes = [event.time for event in recording.events]
    past, looks = -1, recording.looks(0)
    first = 0
    scans = enumerate(recorded_points(recording, robot))
    for row, (picture, renewed) in zip(rows, _newest_pictures(recording, robot, rows), strict=True):
        now = float(track.time[row])
        if bisect_right(changes, now) != past or looks.reached:
            past, looks = bisect_right(changes, now), recording.looks(row)
        recent = next((track.sightings[k] for k in range(row, first - 1, -1) if track.sightings[k]), ())
        first = row + 1
        sightings = recent if recent or renewed else sightings
        mapped = np.isfinite(track.landmarks.mean[row]).all(axis=1)
        yield Moment(
            time=now,
            truth=track.truth[row],
            estimate=track.estimate[row],
            covariance=track.covariance[row],
            odometry=track.odometry[row],
            names=tuple(str(n) for n, is_mapped in zip(track.landmarks.names, mapped, strict=True) if is_mapped),
            means=track.landmarks.mean[row, mapped],
            covariances=track.landmarks.covariance[row, mapped],
            sightings=sightings,
            picture=picture,
            others={name: other.truth[row] for name, other in recording.robots.items() if name != robot},
            scans=next((points for number, points in scans if number == row), {}),
            touched=bool(((now - bumps >= 0.0) & (now - bumps < 0.5)).any()),
            things={name: places[row] for name, places in recording.things.items()},
            looks=looks,
            arms={name: joints.positions[row] for name, joints in recording.joints.items()},
            shown=track.shown[row] if track.shown else (),
        )


def _newest_pictures(recording: Recording, robot: str, rows: Sequence[int]) -> Iterator[tuple[Picture | None, bool]]:
    """Yield for ascending rows the newest picture of a robot's first camera, and whether it came since the last row."""
    camera = next((camera for name, camera in recording.cameras() if name == robot), None)
    pictures = recording.images(robot, camera) if camera is not None else iter(())
    stamp, picture = next(pictures, (np.inf, None))
    newest: Picture | None = None
    for row in rows:
        renewed = False
        while stamp <= recording.robots[robot].time[row] + 1e-9:
            newest, renewed = picture, True
            stamp, picture = next(pictures, (np.inf, None))
        yield newest, renewed
