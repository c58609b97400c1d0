"""The Victoria Park data set in the format of the RFS-SLAM project: a car among trees, seen by a laser scanner.

One folder, three text files; all times are relative to the same start:

    inputs.dat         time [s], velocity [m/s] of the left rear wheel, steering angle [rad], left positive
    measurements.dat   time [s], range [m], bearing [rad], diameter [m] of a tree trunk; a bearing of 0 is to the right
                       of the scanner, pi / 2 is ahead
    gps.dat            time [s], x [m], y [m] of the antenna; optional

The car's axles are 2.83 m apart, its left rear wheel is 0.76 m from the middle of the axle, its scanner 3.78 m ahead of
it and 0.50 m to the left. These numbers, and the standard deviations of sightings below, are those of the project's
configuration (cfg/rbphdslam_VictoriaPark.xml); the columns and the definition of the bearing are those of its programs
(src/rbphdslam_VictoriaPark.cpp, src/MeasurementModel_VictoriaPark.cpp, src/ProcessModel_Ackerman2D.cpp).

The robot's origin is the middle of the rear axle: odometry, sightings, estimates and truth all refer to that point. No
source gives the position of the antenna; fixes agree best with that of the scanner, which is assumed. The heading is
that of odometry, fitted to the fixes of 20 s before and after.

References:
    Guivant, Nebot, Optimization of the simultaneous localization and map-building algorithm for real-time
    implementation, IEEE T-RA 17(3), 2001: the data and the model of the car.
"""

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.interface import Sighting
from mjsim.logs.files import TIME, CarPoses, car_poses, read_table
from mjsim.logs.resampling import (
    MotionNoise,
    Output,
    RobotLog,
    Wishes,
    cut,
    generated_world,
    motions,
    name_from,
    write_robot_logs,
)
from mjsim.world import World

WHEELBASE, ENCODER_OFFSET = 2.83, 0.76
"""Distance between the axles, and from the middle of the rear axle to the measured wheel [m]."""
SCANNER_POSITION = (3.78, 0.50)
"""Ahead of the middle of the rear axle, and to its left [m]."""
ANTENNA = SCANNER_POSITION
"""Assumed position of the antenna, ahead of the middle of the rear axle and to its left [m]."""
MOTION = MotionNoise(distance=0.08, turn=0.0, veer=0.03)
"""Twice the noise that results over one metre at 3 m/s from variances of 0.2 (m/s)^2 and 0.025 rad^2 of each input at
40 Hz. `mjsim calibrate` finds 0.14 m over one metre; with half of this noise, a filter takes known trees for new ones
at 300 s."""
RANGE, BEARING = math.sqrt(0.025), math.sqrt(0.000025)
"""Standard deviations of a sighting by the scanner [m, rad]."""
DEFAULT_RATE_HZ = 25.0
"""Default tick rate [Hz]."""
MAX_TRUTH_GAP = 0.5
"""Maximum time between two fixes to interpolate; normally there is one every 0.2 s [s]."""
NAME = "car"


def convert_victoria_park(folder: Path, wishes: Wishes, output: Output) -> Iterator[float]:
    """Convert a data set to a recording, and yield the progress [%].

    Raises:
        UsageError: A file does not exist or is invalid (the message has file and line).
        RecordingError: The recording cannot be written.
    """
    rate, sighting = wishes.rate_hz or DEFAULT_RATE_HZ, wishes.sighting_over(RANGE, BEARING)
    cuts: dict[str, str] = {}
    inputs = read_table(folder / "inputs.dat", (TIME, "velocity", "steering"), notes=cuts)
    columns = (TIME, "range", "bearing", "diameter")
    seen = read_table(folder / "measurements.dat", columns, positive={"range"}, notes=cuts)
    gps = folder / "gps.dat"
    twists = twists_of(inputs)
    found = _fixed(read_table(gps, (TIME, "x", "y"), notes=cuts), twists) if gps.exists() else None
    truth = None if found is None else found.rows
    span = cut(float(inputs[0, 0]), float(inputs[-1, 0]), begin=wishes.begin, seconds=wishes.seconds, rate_hz=rate)
    log = RobotLog(
        twists=twists,
        sightings=[sighting_of(row, np.diag(np.square(sighting))) for row in seen],
        truth=truth if truth is not None and len(truth) else None,
        gap=MAX_TRUTH_GAP,
    )
    world = _world(folder, _first(truth, span[0]), span, rate_hz=rate, sighting=sighting)
    metadata = {"log": "victoria park", "log folder": str(folder), "truth is of": "the middle of the rear axle", **cuts}
    if found is not None:
        metadata["gps outlier fixes left out"] = str(found.jumped)
    yield from write_robot_logs(
        world,
        {NAME: log},
        span=span,
        noise=wishes.motion_over(MOTION),
        bias=wishes.bias,
        metadata=metadata,
        output=output,
    )


def twists_of(inputs: Array) -> Array:
    """Return time, forward and turn of the middle of the rear axle, shape (N, 3) [s, m/s, rad/s].

    Args:
        inputs: Rows of time [s], velocity of the left rear wheel [m/s] and steering angle [rad].

    References:
        Guivant, Nebot (2001), the equations of the car: v = v_wheel / (1 - tan(steering) H / L).
    """
    curvature = np.tan(inputs[:, 2]) / WHEELBASE
    forward = inputs[:, 1] / (1.0 - curvature * ENCODER_OFFSET)
    return np.stack([inputs[:, 0], forward, forward * curvature], axis=-1)


def sighting_of(row: Array, covariance: Array) -> Sighting:
    """Return a tree as seen from the middle of the rear axle, without a name.

    Args:
        row: Time [s], range [m] and bearing [rad] from the scanner, diameter [m].
        covariance: Covariance of range and bearing from the scanner, shape (2, 2).
    """
    stamp, distance, bearing = row[:3].tolist()
    c, s = math.cos(bearing - math.pi / 2), math.sin(bearing - math.pi / 2)
    x, y = SCANNER_POSITION[0] + distance * c, SCANNER_POSITION[1] + distance * s
    away = math.hypot(x, y)
    polar = np.array([[x / away, y / away], [-y / away**2, x / away**2]])
    J = polar @ np.array([[c, -distance * s], [s, distance * c]])
    return Sighting(stamp, None, away, math.atan2(y, x), J @ covariance @ J.T)


def _fixed(fixes: Array, twists: Array) -> CarPoses:
    """Return the poses of the middle of the rear axle at fixes of the antenna.

    Args:
        fixes: Rows of time [s], x and y [m].
        twists: Rows of time [s], forward [m/s] and turn [rad/s] of the middle of the rear axle.
    """
    return car_poses(fixes, motions(twists, fixes[:, 0], MOTION), ANTENNA)


def _first(truth: Array | None, start: float) -> Pose:
    """Return the start of the car."""
    if truth is None or not len(truth):
        return Pose(0.0, 0.0, 0.0)
    return Pose.from_array(truth[min(int(np.searchsorted(truth[:, 0], start)), len(truth) - 1), 1:])


def _world(
    folder: Path, first: Pose, span: tuple[float, float], *, rate_hz: float, sighting: tuple[float, float]
) -> World:
    """Return the world of the park, which contains only the car."""
    noise = f"{{range: {sighting[0]!r}, bearing_deg: {math.degrees(sighting[1])!r}}}"
    text = (
        "# From the Victoria Park data set. The positions of the trees are unknown.\n"
        f"mjsim: 1\nname: {name_from(folder)}\n"
        f"robots:\n  - name: {NAME}\n    at: [{first.x!r}, {first.y!r}]\n"
        f"    heading_deg: {math.degrees(first.heading)!r}\n"
        f"    drive: {{type: ackermann, wheel_radius: 0.35, track: {2 * ENCODER_OFFSET}, wheelbase: {WHEELBASE},\n"
        "            max_speed: 8, max_acceleration: 3, max_steer_deg: 35}\n"
        "    body: {radius: 1.0, height: 1.2, mass: 1200}  # for the eye; nothing depends on it\n"
        f"    sensors: [{{beacons: laser, at: [{SCANNER_POSITION[0]}, {SCANNER_POSITION[1]}, 0.6], "
        "range: [0.5, 80], fov_deg: 180,\n"
        f"               rate_hz: {rate_hz!r}, anonymous: true, noise: {noise}}}]\n"
        f"run: {{seconds: {span[1] - span[0]!r}, rate_hz: {rate_hz!r}}}\n"
    )
    return generated_world(text, f"readings of '{folder}'")
