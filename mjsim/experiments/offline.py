"""Positions triangulated from the pictures of a recording, after the run."""

from dataclasses import dataclass

import numpy as np

from mjsim.algorithms.beacon_vision import PictureBeacons
from mjsim.algorithms.triangulation import bearings_only
from mjsim.geometry import Array, wrap_angles
from mjsim.interface import Sighting, sightings_from
from mjsim.record import Recording
from mjsim.sim import Simulation

GROSS = np.radians(2.0)
"""A sighting whose bearing is off by more than this is of something else [rad]."""
VAGUE = 0.2
"""Positions whose predicted deviation is larger are left out [m]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Fixes:
    """Positions found from single pictures, one row a picture, K in all."""

    time: Array
    """When each picture was taken, shape (K,) [s]."""
    position: Array
    """World frame, shape (K, 2) [m]."""
    truth: Array
    """Where the robot was, shape (K, 2) [m]."""
    places: Array
    """Of the beacons, shape (B, 2) [m]."""
    wrong: int
    """How many sightings were of another beacon than they said."""


def triangulated(recording: Recording, robot: str, camera: str) -> Fixes:
    """Return the position of a robot at each picture that shows three known beacons or more.

    Each picture is taken by itself, with nothing but the bearings of the beacons recognised in it.

    Args:
        recording: Of a world that says `map: known`.
        robot: Its name.
        camera: Whose pictures are used.
    """
    with Simulation(recording.world) as sim:
        sensor, catalogue = sim.robots[robot].sensors[camera], dict(sim.catalogue)
    assert sensor.intrinsics is not None
    places = {name: beacon.pose.as_array()[:2] for name, beacon in catalogue.items() if beacon.pose is not None}
    finder = PictureBeacons({n: (b.picture, b.width) for n, b in catalogue.items() if b.picture is not None})
    track = recording.robots[robot]
    rows, wrong = [], 0
    for stamp, image in recording.images(robot, camera):
        pose = track.truth[int(np.searchsorted(track.time, stamp - 1e-9))]
        looks = sightings_from(finder.detect(image, sensor.intrinsics), sensor.robot_from_sensor, stamp=stamp)
        wrong += sum(_off(look, pose, places[str(look.name)]) > GROSS for look in looks)
        position = _position(looks, places)
        if position is not None:
            rows.append((stamp, *position, *pose[:2]))
    table = np.array(rows).reshape(-1, 5)
    return Fixes(
        time=table[:, 0],
        position=table[:, 1:3],
        truth=table[:, 3:5],
        places=np.array(list(places.values())),
        wrong=wrong,
    )


def _position(looks: tuple[Sighting, ...], places: dict[str, Array]) -> tuple[float, float] | None:
    """Return where bearings were taken; None where they do not tell."""
    if len(looks) < 3:
        return None
    try:
        pose, covariance = bearings_only(
            [places[str(look.name)] for look in looks],
            [look.bearing for look in looks],
            np.sqrt([look.covariance[1, 1] for look in looks]),
        )
    except ValueError:
        return None  # They lie on one circle with the robot.
    return (pose.x, pose.y) if np.sqrt(np.trace(covariance[:2, :2])) < VAGUE else None


def _off(look: Sighting, pose: Array, place: Array) -> float:
    """Return by how much a bearing is off [rad]."""
    x, y = place - pose[:2]
    return abs(float(wrap_angles(np.arctan2(y, x) - pose[2] - look.bearing)))
