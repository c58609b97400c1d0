"""The sensor readings of a robot at one tick: `Observation`, and a class for each kind of reading."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array

Picture = NDArray[np.uint8]
"""RGB picture, shape (height, width, 3), uint8."""
LONGEST_MESSAGE = 1 << 20
"""Maximum length of a message in JSON [characters]."""


@dataclass(frozen=True, slots=True, eq=False)
class Intrinsics:
    """A pinhole camera: u = fx x/z + cx, v = fy y/z + cy, pixel centres at whole numbers; a lens bends x/z and y/z."""

    width: int
    """[px]"""
    height: int
    """[px]"""
    fx: float
    """[px]"""
    fy: float
    """[px]"""
    cx: float
    """[px]"""
    cy: float
    """[px]"""
    lens: str = "pinhole"
    """'pinhole', 'brown' or 'fisheye'."""
    distortion: tuple[float, ...] = ()
    """Coefficients in OpenCV's order: k1, k2, p1, p2, k3 of Brown's model, then k4, k5, k6 of the rational one; k1 to
    k4 of a fisheye; none for a pinhole."""

    def matrix(self) -> Array:
        """Return the calibration matrix, shape (3, 3) [px]."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    def is_rational(self) -> bool:
        """Return whether Brown's model is the rational one, with k4, k5 and k6."""
        return self.lens == "brown" and any(self.distortion[5:])

    def coefficients(self) -> list[float]:
        """Return the distortion as stored in files, zeros if there is none: 4 numbers for a fisheye, else 5 or 8."""
        count = 4 if self.lens == "fisheye" else 8 if self.is_rational() else 5
        return [*map(float, self.distortion), *([0.0] * count)][:count]


@dataclass(frozen=True, slots=True, eq=False)
class CameraFrame:
    """One picture of an onboard camera."""

    stamp: float
    """When it was taken [s]."""
    image: Picture
    """RGB, shape (height, width, 3)."""
    intrinsics: Intrinsics
    depth: Array | None = None
    """Distance along the optical axis, shape (height, width) [m]: +inf for none, -inf for too near, as in a `Scan`;
    None unless the camera gives it."""
    segmentation: NDArray[np.int32] | None = None
    """Instance of each pixel, -1 for none, shape (height, width); None unless the camera gives it."""
    instances: tuple[str, ...] = ()
    """Names of the instances: 'beacon/NAME', 'obstacle/NAME', the name of a robot, 'wall', 'floor' and so on."""
    depth_stamp: float | None = None
    """When the depth was taken, if not with the picture: in a log of a camera with a separate depth sensor [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """One scan of a 2-D lidar: a range per beam, from right to left.

    +inf for no return, -inf for something too near to be measured.

    References:
        ROS REP 117, Informational Distance Measurements.
    """

    stamp: float
    """When it was taken [s]."""
    ranges: Array
    """Ranges along the beams, shape (beams,) [m]."""
    angle_min: float
    """Angle of the first beam in the sensor frame, left positive [rad]."""
    angle_increment: float
    """Angle between neighbouring beams [rad]."""
    range_min: float
    """[m]"""
    range_max: float
    """[m]"""
    intensities: Array | None = None
    """Intensity of each return, relative to a white wall at normal incidence, shape (beams,); None if not measured."""

    def angles(self) -> Array:
        """Return the angle of each beam in the sensor's frame, left positive, shape (beams,) [rad]."""
        return np.asarray(self.angle_min + self.angle_increment * np.arange(len(self.ranges)), dtype=float)

    def points(self) -> Array:
        """Return the points hit by the beams, in the plane of the sensor's frame, shape (n, 2) [m]."""
        hit = np.isfinite(self.ranges)
        angles, ranges = self.angles()[hit], self.ranges[hit]
        return np.stack([ranges * np.cos(angles), ranges * np.sin(angles)], axis=-1)


CLOUD_FIELDS = {"x": "<f4", "y": "<f4", "z": "<f4", "intensity": "<f4", "time": "<f4", "ring": "<u2"}
"""Fields of a point in files and messages, in order: name -> NumPy type."""


@dataclass(frozen=True, slots=True, eq=False)
class PointCloud:
    """One revolution of a 3-D lidar: the points hit by its beams, one per row, in firing order.

    The sensor moves while it turns, and each point is in the sensor's frame at the time of that point. Beams
    without a return are left out.
    """

    stamp: float
    """End of the revolution [s]."""
    points: NDArray[np.float32]
    """Points in the sensor frame, x forward, y left, z up, shape (n, 3) [m]."""
    times: NDArray[np.float32]
    """Time of each point relative to the stamp, not above zero, shape (n,) [s]."""
    intensities: NDArray[np.float32]
    """Intensity of each return, relative to a white wall at normal incidence, shape (n,)."""
    rings: NDArray[np.uint16]
    """Ring of each point, 0 for the lowest; 0 for a rosette, shape (n,)."""

    def rows(self) -> NDArray[np.void]:
        """Return one record per point with the fields of `CLOUD_FIELDS`, shape (n,)."""
        rows = np.empty(len(self.points), dtype=[*CLOUD_FIELDS.items()])
        rows["x"], rows["y"], rows["z"] = self.points.T
        rows["intensity"], rows["time"], rows["ring"] = self.intensities, self.times, self.rings
        return rows


@dataclass(frozen=True, slots=True, eq=False)
class ImuReading:
    """A reading of an inertial sensor: the mean since its last reading, in its own frame."""

    stamp: float
    """End of its averaging period [s]."""
    acceleration: Array
    """Specific force, (0, 0, 9.81) at rest, shape (3,) [m/s^2]; NaN from a sensor of a log without accelerometers."""
    turn: Array
    """Angular velocity about x, y and z, shape (3,) [rad/s]; NaN from a sensor of a log that has no gyroscopes."""
    name: str = "imu"
    """Name of the sensor."""


@dataclass(frozen=True, slots=True, eq=False)
class Odometry:
    """Motion since the last tick measured by the wheels, in the robot frame at that tick."""

    forward: float
    """[m]"""
    left: float
    """[m]"""
    turn: float
    """[rad]"""
    covariance: Array
    """Covariance of (forward, left, turn), shape (3, 3) [m, m, rad]."""
    stamp: float | None = None
    """When the motion ended, if not at the time of the observation: in a log, at the scan that came with it [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class Sighting:
    """A beacon seen from the robot."""

    stamp: float
    """[s]"""
    name: str | None
    """Name of the beacon; None if the sensor does not identify it."""
    range: float
    """Horizontal distance from the robot's origin [m]."""
    bearing: float
    """Bearing from the robot's x axis, left positive, in [-pi, pi) [rad]."""
    covariance: Array
    """Covariance of (range, bearing), shape (2, 2): of this sighting alone.

    The errors of sightings from pictures (with `corners`) are shared: all of an image shift together as the robot
    pitches, and a picture errs in nearly the same way from one image to the next. A filter that takes them as
    independent becomes overconfident, and its NIS does not show it: a textbook EKF has a NEES of 107 (3 expected) with
    a NIS of 2. `mjsim.algorithms.picture_errors:PictureErrors` gives the covariance of a tick's sightings with what
    they share.
    """
    corners: Array | None = None
    """Outline in the image, shape (4, 2) [px], clockwise from the picture's own top left."""


@dataclass(frozen=True, slots=True)
class AnchorRanges:
    """Ranges from a tag to radio anchors."""

    stamp: float
    """When it was measured [s]."""
    ranges: Mapping[str, float]
    """Name of an anchor -> 3-D distance from the tag to its centre [m]; anchors not received are omitted."""
    variance: float
    """Variance of each range in line of sight, from the data sheet [m^2]; without line of sight the error is larger."""


@dataclass(frozen=True, slots=True)
class WheelTicks:
    """Encoder counts of the driven wheels since the start, forward positive."""

    stamp: float
    """When they were read [s]."""
    counts: tuple[int, ...]
    """Counts of the wheels, in the order of `RobotInfo.wheels`, from -2^(bits - 1) to 2^(bits - 1) - 1."""
    resolution: int
    """Counts per revolution of a wheel."""
    bits: int = 32
    """Width of the counters, which wrap around."""

    def since(self, before: "WheelTicks") -> tuple[int, ...]:
        """Return the counts of each wheel since an earlier reading; correct up to half the counter range."""
        half = 1 << (self.bits - 1)
        return tuple(
            (now - then + half) % (2 * half) - half for now, then in zip(self.counts, before.counts, strict=True)
        )

    def rotations(self, before: "WheelTicks") -> Array:
        """Return the rotation of each wheel since an earlier reading, shape (wheels,) [rad]."""
        return np.array(self.since(before), dtype=float) * (2.0 * np.pi / self.resolution)


@dataclass(frozen=True, slots=True, eq=False)
class JointState:
    """State of joints or driven wheels, as measured by encoders; each array has shape (joints,)."""

    stamp: float
    """When they were read [s]."""
    positions: Array
    """[rad], or [m] of joints that slide; wheels count from the start, forward positive, relative to the body."""
    velocities: Array
    """[rad/s], or [m/s]."""
    torques: Array
    """Torques of the motors on the side of the joint, as currently applied [N m], or [N]."""


@dataclass(frozen=True, slots=True, eq=False)
class FastReading:
    """The inputs of a controller between ticks: only encoders and inertial sensors."""

    time: float
    """[s]"""
    dt: float
    """Since the last call, and until the next [s]."""
    joints: Mapping[str, JointState]
    """By the name of the arm; all arms of the robot."""
    wheels: JointState
    """Driven wheels, in the order of `RobotInfo.wheels`."""
    imu: tuple[ImuReading, ...] = ()
    """Readings since the last call, one sensor after the other. The first call has one of the robot held at rest."""


@dataclass(frozen=True, slots=True)
class Message:
    """A message from another robot."""

    sender: str
    """Name of the robot."""
    stamp: float
    """When it was sent [s]."""
    text: str = field(repr=False)
    """The content as JSON."""

    @property
    def content(self) -> Any:
        """A copy of what was sent: numbers, strings, None, lists and dicts; arrays and tuples become lists."""
        return json.loads(self.text)


@dataclass(frozen=True, slots=True, eq=False)
class Observation:
    """All sensor readings of a robot at one tick."""

    time: float
    """[s]"""
    dt: float
    """Since the last tick [s]."""
    odometry: Odometry
    sightings: tuple[Sighting, ...] = ()
    """Sightings of the beacon sensor, and of the observer once it has run."""
    cameras: Mapping[str, CameraFrame] = field(default_factory=dict)
    """By camera name, only those due at this tick."""
    scans: Mapping[str, Scan] = field(default_factory=dict)
    """By lidar name, only those due at this tick."""
    imu: tuple[ImuReading, ...] = ()
    """Readings since the last tick, one sensor after the other."""
    ranges: Mapping[str, AnchorRanges] = field(default_factory=dict)
    """Ranges to radio anchors by the name of the tag, only those due at this tick."""
    encoders: Mapping[str, WheelTicks] = field(default_factory=dict)
    """Counts of the driven wheels by the name of the sensor, only those due at this tick."""
    proximity: Array = field(default_factory=lambda: np.full(16, np.inf))
    """Ring of 16 ranges from the robot's rim, from straight ahead counter-clockwise [m]; +inf for no object."""
    bump: tuple[float, ...] = ()
    """Bearings of current contacts, left positive [rad]; empty without contact."""
    messages: tuple[Message, ...] = ()
    """Messages from other robots received since the last tick."""
    joints: Mapping[str, JointState] = field(default_factory=dict)
    """Joint states by the name of the arm."""
    clouds: Mapping[str, PointCloud] = field(default_factory=dict)
    """By the name of the 3-D lidar, only those due at this tick."""

    @property
    def moment(self) -> float:
        """When the motion of this tick ended: the time of the robot's pose [s]."""
        return self.time if self.odometry.stamp is None else self.odometry.stamp


def message_text(content: object) -> str:
    """Return a message's content as JSON, exactly.

    Raises:
        ValueError: It contains a value that JSON cannot represent, or is too long.
    """
    try:
        text = json.dumps(content, allow_nan=False, separators=(",", ":"), default=_plain)
    except (TypeError, ValueError, RecursionError) as error:
        raise ValueError(
            f"a message that cannot be sent ({error}); it may contain finite numbers, strings, None, lists and dicts"
        ) from None
    if len(text) > LONGEST_MESSAGE:
        raise ValueError(f"a message of {len(text)} characters as JSON; {LONGEST_MESSAGE} can be sent")
    return text


def _plain(value: object) -> object:
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError(f"a value of type {type(value).__name__}")
