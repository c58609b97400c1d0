"""Positions triangulated from the pictures of a recording, after the run."""

from dataclasses import dataclass

import numpy as np

from mjsim.algorithms.beacon_vision.beacon_vision import PictureBeacons
from mjsim.algorithms.triangulation import bearings_only
from mjsim.geometry import Array, wrap_angles
from mjsim.interface import Sighting, sightings_from
from mjsim.record import Recording
from mjsim.sim import Simulation

GROSS = np.radians(2.0)
"""A sighting with a larger bearing error belongs to another object [rad]."""
MAX_DEVIATION = 0.2
"""Positions with a larger predicted standard deviation are left out [m]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Fixes:
    """Positions from single pictures, one row per picture, K in total."""

    time: Array
    """Time of each picture, shape (K,) [s]."""
    position: Array
    """World frame, shape (K, 2) [m]."""
    truth: Array
    """True positions of the robot, world frame, shape (K, 2) [m]."""
    places: Array
    """Positions of the beacons, world frame, shape (B, 2) [m]."""
    wrong: int
    """Number of sightings with the name of the wrong beacon."""


def triangulated(recording: Recording, robot: str, camera: str) -> Fixes:
    """Return the position of a robot for each picture that shows at least three known beacons.

    Each picture is evaluated separately, using only the bearings of the beacons recognised in it.

    Args:
        recording: Recording of a world with `map: known`.
        robot: Name of the robot.
        camera: Name of the camera.
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
        sightings = sightings_from(finder.detect(image, sensor.intrinsics), sensor.robot_from_sensor, stamp=stamp)
        wrong += sum(_bearing_error(sighting, pose, places[str(sighting.name)]) > GROSS for sighting in sightings)
        position = _position(sightings, places)
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


def _position(sightings: tuple[Sighting, ...], places: dict[str, Array]) -> tuple[float, float] | None:
    """Return the position at which bearings were taken; None if they do not determine it."""
    if len(sightings) < 3:
        return None
    try:
        pose, covariance = bearings_only(
            [places[str(sighting.name)] for sighting in sightings],
            [sighting.bearing for sighting in sightings],
            np.sqrt([sighting.covariance[1, 1] for sighting in sightings]),
        )
    except ValueError:
        return None  # They lie on one circle with the robot.
    return (pose.x, pose.y) if np.sqrt(np.trace(covariance[:2, :2])) < MAX_DEVIATION else None


def _bearing_error(sighting: Sighting, pose: Array, place: Array) -> float:
    """Return the error of a bearing [rad]."""
    x, y = place - pose[:2]
    return abs(float(wrap_angles(np.arctan2(y, x) - pose[2] - sighting.bearing)))
