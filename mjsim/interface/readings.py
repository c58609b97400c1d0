"""The sensor readings of a robot at one tick: `Observation`, and a class for each kind of reading."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.interface.forms import CLOCK_TIME, Form, Stamp

Picture = NDArray[np.uint8]
"""RGB picture, shape (height, width, 3), uint8."""


@dataclass(frozen=True, slots=True, eq=False)
class Intrinsics:
    """A pinhole camera: u = fx x/z + cx, v = fy y/z + cy, pixel centres at whole numbers; a lens distorts x/z and y/z.

    Examples:
        >>> import mjsim
        >>> lens = mjsim.Intrinsics(640, 480, 550.0, 550.0, 319.5, 239.5)
        >>> lens.fx * 0.5 / 2.0 + lens.cx  # u of a point 0.5 m to the right at a depth of 2 m
        457.0
    """

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

    stamp: Stamp
    """When it was taken [s]."""
    image: Picture
    """RGB, shape (height, width, 3)."""
    intrinsics: Intrinsics
    """Calibration of the picture [px]."""
    depth: Array | None = None
    """Distance along the optical axis, shape (height, width) [m]: +inf for none, -inf for too near, as in a `Scan`,
    NaN where stereo matching fails; None unless the camera gives it."""
    segmentation: NDArray[np.int32] | None = None
    """Instance of each pixel, -1 for none, shape (height, width); None unless the camera gives it."""
    instances: tuple[str, ...] = ()
    """Names of the instances: 'beacon/NAME', 'obstacle/NAME', the name of a robot, 'wall', 'floor' and so on."""
    depth_stamp: Annotated[float | None, CLOCK_TIME] = None
    """When the depth was taken, if not with the picture: in a log of a camera with a separate depth sensor [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """One scan of a 2-D lidar: a range per beam, from right to left.

    +inf for no return, -inf for something too near to be measured.

    References:
        ROS REP 117, Informational Distance Measurements.
    """

    stamp: Stamp
    """When it was taken; for a rotating lidar, the time of its last beam [s]."""
    ranges: Annotated[Array, Form("one per beam [m]; infinite as in ROS REP 117", packed="<f8")]
    """Ranges along the beams, shape (beams,) [m]."""
    angle_min: Annotated[float, Form("Of the first beam, left positive [rad]")]
    """Angle of the first beam in the sensor frame, left positive [rad]."""
    angle_increment: Annotated[float, Form("From beam to beam [rad]")]
    """Angle between neighbouring beams [rad]."""
    range_min: Annotated[float, Form("[m]")]
    """[m]"""
    range_max: Annotated[float, Form("[m]")]
    """[m]"""
    intensities: Annotated[Array | None, Form("one per beam; omitted unless the lidar measures them", packed="<f8")] = (
        None
    )
    """Intensity of each return, relative to a white wall at normal incidence, shape (beams,); None if not measured."""
    time_increment: Annotated[float | None, Form("From beam to beam [s]; omitted if all have the same time")] = None
    """Time between neighbouring beams of a rotating lidar; each beam is in the sensor frame at its own time. None if
    all beams have the same time [s]."""

    def times(self) -> Array:
        """Return the time of each beam relative to the stamp, not above zero, shape (beams,) [s]."""
        return np.asarray((self.time_increment or 0.0) * np.arange(1 - len(self.ranges), 1), dtype=float)

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

    stamp: Stamp
    """End of the revolution [s]."""
    points: Annotated[
        NDArray[np.float32],
        Form("x, y and z of each in the sensor's frame at its time [m]", shape=(-1, 3), packed="<f4"),
    ]
    """Points in the sensor frame, x forward, y left, z up, shape (n, 3) [m]."""
    times: Annotated[NDArray[np.float32], Form("when each was measured, after the stamp [s]", packed="<f4")]
    """Time of each point relative to the stamp, not above zero, shape (n,) [s]."""
    intensities: Annotated[NDArray[np.float32], Form("strength of each return", packed="<f4")]
    """Intensity of each return, relative to a white wall at normal incidence, shape (n,)."""
    rings: Annotated[NDArray[np.uint16], Form("which beam, from 0 for the lowest", packed="<u2")]
    """Ring of each point, 0 for the lowest; 0 for a rosette, shape (n,)."""

    def __post_init__(self) -> None:
        """Check that all arrays have one row per point."""
        if len({len(part) for part in (self.points, self.times, self.intensities, self.rings)}) > 1:
            raise ValueError(f"a cloud of {len(self.points)} points with unequal counts of times, intensities or rings")

    def rows(self) -> NDArray[np.void]:
        """Return one record per point with the fields of `CLOUD_FIELDS`, shape (n,)."""
        rows = np.empty(len(self.points), dtype=[*CLOUD_FIELDS.items()])
        rows["x"], rows["y"], rows["z"] = self.points.T
        rows["intensity"], rows["time"], rows["ring"] = self.intensities, self.times, self.rings
        return rows


@dataclass(frozen=True, slots=True, eq=False)
class ImuReading:
    """A reading of an inertial sensor: the mean since its last reading, in its own frame."""

    stamp: Stamp
    """End of its averaging period [s]."""
    acceleration: Annotated[Array, Form("[m/s^2]", shape=(3,))]
    """Specific force, (0, 0, 9.81) at rest, shape (3,) [m/s^2]; NaN from a sensor of a log without accelerometers."""
    turn: Annotated[Array, Form("[rad/s]", shape=(3,))]
    """Angular velocity about x, y and z, shape (3,) [rad/s]; NaN from a sensor of a log that has no gyroscopes."""
    name: str = "imu"
    """Name of the sensor."""


@dataclass(frozen=True, slots=True, eq=False)
class Odometry:
    """Motion since the last tick measured by the wheels, in the robot frame at that tick.

    Examples:
        >>> import mjsim
        >>> import numpy as np
        >>> moved = mjsim.Odometry(0.02, 0.0, 0.125, np.diag([1e-6, 1e-8, 1e-6]))
        >>> mjsim.Pose(1.0, 0.0, 0.0) @ mjsim.Pose(moved.forward, moved.left, moved.turn)
        Pose(x=1.02, y=0.0, heading=0.125)
    """

    forward: Annotated[float, Form("[m]")]
    """[m]"""
    left: Annotated[float, Form("[m]")]
    """[m]"""
    turn: Annotated[float, Form("[rad]")]
    """[rad]"""
    covariance: Annotated[Array, Form("Of (forward, left, turn), 3 x 3", shape=(3, 3))]
    """Covariance of (forward, left, turn), shape (3, 3) [m, m, rad]."""
    stamp: Annotated[float | None, Form("When the motion ended, if not at the time of the tick [s]"), CLOCK_TIME] = None
    """When the motion ended, if not at the time of the observation: in a log, at the scan that came with it [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class Sighting:
    """A beacon seen from the robot.

    Examples:
        >>> import mjsim
        >>> import numpy as np
        >>> seen = mjsim.Sighting(0.04, "door", 2.0, 0.5, np.diag([0.01, 0.0004]))
        >>> seen.name, seen.range
        ('door', 2.0)
    """

    stamp: Annotated[float, Form("[s]"), CLOCK_TIME]
    """[s]"""
    name: Annotated[str | None, Form("Omitted if the sensor does not identify it")]
    """Name of the beacon; None if the sensor does not identify it."""
    range: Annotated[float, Form("Horizontal, from the robot's origin [m]")]
    """Horizontal distance from the robot's origin [m]."""
    bearing: Annotated[float, Form("From the robot's x axis, left positive [rad]")]
    """Bearing from the robot's x axis, left positive, in [-pi, pi) [rad]."""
    covariance: Annotated[Array, Form("Of (range, bearing), 2 x 2", shape=(2, 2))]
    """Covariance of (range, bearing), shape (2, 2): of this sighting alone.

    The errors of sightings from pictures (with `corners`) are correlated: all sightings in an image shift together as
    the robot pitches, and the error of a beacon hardly changes from one image to the next. A filter that treats them as
    independent becomes overconfident, and its NIS does not show it: a textbook EKF has a NEES of 107 (3 expected) with
    a NIS of 2. `mjsim.algorithms.picture_errors:PictureErrors` gives the joint covariance of a tick's sightings.
    """
    corners: Annotated[
        Array | None,
        Form(
            "u, v of 4 corners, clockwise from the top left of the beacon's picture [px]; omitted if none",
            shape=(-1, 2),
        ),
    ] = None
    """Outline in the image, shape (4, 2) [px], clockwise from the picture's own top left."""


@dataclass(frozen=True, slots=True)
class AnchorRanges:
    """Ranges from a tag to radio anchors."""

    stamp: Stamp
    """When it was measured [s]."""
    ranges: Annotated[
        Mapping[str, float],
        Form("Distance in space to each of them [m]", names="anchors"),
    ]
    """Name of an anchor -> 3-D distance from the tag to its centre [m]; anchors not received are omitted."""
    variance: Annotated[float, Form("Of each range in line of sight [m^2]")]
    """Variance of each range in line of sight, from the data sheet [m^2]; without line of sight the error is larger."""


@dataclass(frozen=True, slots=True)
class WheelTicks:
    """Encoder counts of the driven wheels since the start, forward positive."""

    stamp: Stamp
    """When they were read [s]."""
    counts: Annotated[tuple[int, ...], Form("Steps of each driven wheel since the start")]
    """Counts of the wheels, in the order of `RobotInfo.wheels`, from -2^(bits - 1) to 2^(bits - 1) - 1."""
    resolution: Annotated[int, Form("Steps per turn of a wheel", is_fixed=True)]
    """Counts per revolution of a wheel."""
    bits: Annotated[int, Form("Width of the counters, which wrap around", is_fixed=True)] = 32
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


@dataclass(frozen=True, slots=True)
class CompassReading:
    """The heading that a compass measures."""

    stamp: Stamp
    """When it was measured [s]."""
    heading: Annotated[float, Form("Counter-clockwise from magnetic east [rad]", bounds=(-math.pi, math.pi))]
    """Heading of the robot, counter-clockwise from magnetic east, in [-pi, pi) [rad]."""
    variance: Annotated[float, Form("Of its white noise [rad^2]")]
    """Variance of its white noise, from the data sheet [rad^2]; errors that depend on the place come in addition."""


@dataclass(frozen=True, slots=True, eq=False)
class JointState:
    """State of joints or driven wheels, as measured by encoders; each array has shape (joints,)."""

    stamp: Stamp
    """When they were read [s]."""
    positions: Annotated[Array, Form("[rad], or [m] of joints that slide")]
    """[rad], or [m] of joints that slide; wheels count from the start, forward positive, relative to the body."""
    velocities: Annotated[Array, Form("[rad/s], or [m/s]")]
    """[rad/s], or [m/s]."""
    torques: Annotated[Array, Form("Of the motors at the joints [N m], or [N]")]
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
    """Readings since the last call, one sensor after the other. The first call has one reading, of the robot held at
    rest."""


@dataclass(frozen=True, slots=True)
class Message:
    """A message from another robot."""

    sender: Annotated[str, Form("Robot")]
    """Name of the robot."""
    stamp: Annotated[float, Form("[s]"), CLOCK_TIME]
    """When it was sent [s]."""
    text: Annotated[str, Form("Content as JSON")] = field(repr=False)
    """The content as JSON."""

    @property
    def content(self) -> Any:
        """A copy of what was sent: numbers, strings, None, lists and dicts; arrays and tuples become lists."""
        return json.loads(self.text)


@dataclass(frozen=True, slots=True, eq=False)
class Observation:
    """All sensor readings of a robot at one tick."""

    time: float
    """Simulated time of the tick [s]."""
    dt: float
    """Since the last tick [s]."""
    odometry: Annotated[Odometry, Form("Motion since the last tick as measured by the wheels")]
    """Motion since the last tick, as measured by the wheels."""
    sightings: Annotated[tuple[Sighting, ...], Form("Beacons seen")] = ()
    """Sightings of the beacon sensor, and of the observer once it has run."""
    cameras: Annotated[Mapping[str, CameraFrame], Form("Pictures")] = field(default_factory=dict)
    """By camera name, only those due at this tick."""
    scans: Annotated[Mapping[str, Scan], Form("Of lidars, where due")] = field(default_factory=dict)
    """By lidar name, only those due at this tick."""
    imu: Annotated[tuple[ImuReading, ...], Form("Since the last tick")] = ()
    """Readings since the last tick, one sensor after the other."""
    ranges: Annotated[Mapping[str, AnchorRanges], Form("To radio anchors, where due")] = field(default_factory=dict)
    """Ranges to radio anchors by the name of the tag, only those due at this tick."""
    encoders: Annotated[Mapping[str, WheelTicks], Form("Of wheel encoders, where due")] = field(default_factory=dict)
    """Counts of the driven wheels by the name of the sensor, only those due at this tick."""
    proximity: Annotated[Array, Form("Ring of ranges, first ahead, then counter-clockwise [m]", is_distance=True)] = (
        field(default_factory=lambda: np.full(16, np.inf))
    )
    """Ring of 16 ranges from the robot's rim, from straight ahead counter-clockwise [m]; +inf for no object."""
    bump: Annotated[tuple[float, ...], Form("Bearings of contacts, left positive [rad]")] = ()
    """Bearings of contacts since the last tick, left positive [rad]; empty without contact."""
    messages: Annotated[tuple[Message, ...], Form("Received by radio")] = ()
    """Messages from other robots received since the last tick."""
    joints: Annotated[Mapping[str, JointState], Form("Encoders of arms")] = field(default_factory=dict)
    """Joint states by the name of the arm."""
    clouds: Annotated[Mapping[str, PointCloud], Form("Of 3-D lidars, where due")] = field(default_factory=dict)
    """By the name of the 3-D lidar, only those due at this tick."""
    compasses: Annotated[Mapping[str, CompassReading], Form("Of compasses, where due")] = field(default_factory=dict)
    """By the name of the compass, only those due at this tick."""

    @property
    def moment(self) -> float:
        """When the motion of this tick ended: the time of the robot's pose [s]."""
        return self.time if self.odometry.stamp is None else self.odometry.stamp
