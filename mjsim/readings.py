"""What sensors and the radio give: values that stand in an `Observation`; `mjsim.interface` has them too."""

import json
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array

Picture = NDArray[np.uint8]
"""RGB picture, shape (height, width, 3), uint8."""
LONGEST_MESSAGE = 1 << 20
"""Characters of JSON in one message, at most."""


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
    """As OpenCV orders them: k1, k2, p1, p2, k3 of Brown's model, k1 to k4 of a fisheye; none for a pinhole."""

    def matrix(self) -> Array:
        """Return the calibration matrix, shape (3, 3) [px]."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])


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
    """Name of each instance: 'beacon/NAME', 'obstacle/NAME', the name of a robot, 'wall', 'floor' and so on."""


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """One turn of a 2-D lidar: a range for each beam, from the right to the left.

    +inf where nothing came back, -inf where something is too near to be measured.

    References:
        ROS REP 117, Informational Distance Measurements.
    """

    stamp: float
    """When it was taken [s]."""
    ranges: Array
    """From the sensor along each beam, shape (beams,) [m]."""
    angle_min: float
    """Of the first beam, in the sensor's frame, left positive [rad]."""
    angle_increment: float
    """From one beam to the next [rad]."""
    range_min: float
    """[m]"""
    range_max: float
    """[m]"""
    intensities: Array | None = None
    """Strength of each return, of that of a white wall hit squarely, shape (beams,); None unless the lidar tells."""

    def angles(self) -> Array:
        """Return the angle of each beam in the sensor's frame, left positive, shape (beams,) [rad]."""
        return np.asarray(self.angle_min + self.angle_increment * np.arange(len(self.ranges)), dtype=float)

    def points(self) -> Array:
        """Return where beams met something, in the plane of the sensor's frame, shape (n, 2) [m]."""
        met = np.isfinite(self.ranges)
        angles, ranges = self.angles()[met], self.ranges[met]
        return np.stack([ranges * np.cos(angles), ranges * np.sin(angles)], axis=-1)


@dataclass(frozen=True, slots=True, eq=False)
class ImuReading:
    """What an inertial sensor felt, as the mean since its last reading, in its own frame."""

    stamp: float
    """When its period ended [s]."""
    acceleration: Array
    """Specific force: what it is pushed by, (0, 0, 9.81) at rest, shape (3,) [m/s^2]."""
    turn: Array
    """Angular velocity about x, y and z, shape (3,) [rad/s]."""
    name: str = "imu"
    """Of the sensor."""


@dataclass(frozen=True, slots=True)
class Message:
    """What another robot sent over the radio."""

    sender: str
    """Name of the robot."""
    stamp: float
    """When it was sent [s]."""
    text: str = field(repr=False)
    """The content as JSON."""

    @property
    def content(self) -> Any:
        """What was sent, a copy of its own: numbers, texts, None, lists and dicts; arrays and tuples come as lists."""
        return json.loads(self.text)


def message_text(content: object) -> str:
    """Return a message's content as JSON, exactly.

    Raises:
        ValueError: It holds what JSON has no word for, or is too long.
    """
    try:
        text = json.dumps(content, allow_nan=False, separators=(",", ":"), default=_plain)
    except (TypeError, ValueError, RecursionError) as error:
        raise ValueError(
            f"a message that cannot be sent ({error}); it holds finite numbers, texts, None, lists and dicts"
        ) from None
    if len(text) > LONGEST_MESSAGE:
        raise ValueError(f"a message of {len(text)} characters as JSON; {LONGEST_MESSAGE} can be sent")
    return text


def _plain(value: object) -> object:
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError(f"a value of type {type(value).__name__}")
