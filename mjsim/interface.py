"""What user modules meet: the values that they get and give, and the protocols that they follow.

Metres, seconds and radians. The robot's frame has x ahead and y to the left, its origin on the floor where
its drive turns about. Nothing here holds the truth; a module senses what a robot of that kind would sense.
"""

import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array, Pose
from mjsim.readings import CameraFrame as CameraFrame
from mjsim.readings import ImuReading as ImuReading
from mjsim.readings import Intrinsics as Intrinsics
from mjsim.readings import Message as Message
from mjsim.readings import Picture as Picture
from mjsim.readings import Scan as Scan


@dataclass(frozen=True, slots=True)
class Command:
    """A twist in the robot's frame, held until the next tick."""

    forward: float = 0.0
    """[m/s]"""
    left: float = 0.0
    """[m/s]; 0 for robots that cannot move sideways."""
    turn: float = 0.0
    """Counter-clockwise [rad/s]."""
    messages: tuple[Any, ...] = ()
    """What to send to all other robots, once: numbers, texts, None, and lists and dicts of these."""


@dataclass(frozen=True, slots=True)
class WheelCommand:
    """Angular speeds of the driven wheels, in the order of `RobotInfo.wheels`."""

    speeds: tuple[float, ...]
    """[rad/s]"""


@dataclass(frozen=True, slots=True, eq=False)
class Odometry:
    """Motion since the last tick as the wheels tell it, in the robot's frame at that tick."""

    forward: float
    """[m]"""
    left: float
    """[m]"""
    turn: float
    """[rad]"""
    covariance: Array
    """Of (forward, left, turn), shape (3, 3) [m, m, rad]."""


@dataclass(frozen=True, slots=True, eq=False)
class Sighting:
    """A beacon seen from the robot."""

    stamp: float
    """[s]"""
    name: str | None
    """None when the sensor cannot tell which beacon it is."""
    range: float
    """Horizontal distance from the robot's origin [m]."""
    bearing: float
    """From the robot's x axis, left positive, in [-pi, pi) [rad]."""
    covariance: Array
    """Of (range, bearing), shape (2, 2)."""
    corners: Array | None = None
    """Outline in the picture, shape (4, 2) [px], from the picture's own top left clockwise."""


@dataclass(frozen=True, slots=True, eq=False)
class Detection:
    """A beacon found in a picture."""

    name: str
    position: Array
    """Its centre in the camera's optical frame (x right, y down, z ahead), shape (3,) [m]."""
    covariance: Array
    """Of the position, shape (3, 3) [m^2]."""
    corners: Array
    """Shape (4, 2) [px], from the picture's own top left clockwise."""


@dataclass(frozen=True, slots=True, eq=False)
class Observation:
    """All that a robot senses at one tick."""

    time: float
    """[s]"""
    dt: float
    """Since the last tick [s]."""
    odometry: Odometry
    sightings: tuple[Sighting, ...] = ()
    """Of the beacon sensor, and of the observer once it has looked."""
    cameras: Mapping[str, CameraFrame] = field(default_factory=dict)
    """By camera name, only those due at this tick."""
    scans: Mapping[str, Scan] = field(default_factory=dict)
    """By lidar name, only those due at this tick."""
    imu: tuple[ImuReading, ...] = ()
    """Readings since the last tick, one sensor after the other."""
    proximity: Array = field(default_factory=lambda: np.full(16, np.inf))
    """Ring of 16 ranges from the robot's rim, first ahead, then counter-clockwise [m]; +inf for nothing near."""
    bump: tuple[float, ...] = ()
    """Bearings of contacts now, left positive [rad]; empty when free."""
    messages: tuple[Message, ...] = ()
    """What other robots sent and the radio brought since the last tick."""


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """What an estimator believes."""

    pose: Pose
    """Mean, in the frame in which the prior of `RobotInfo` is given."""
    covariance: Array
    """Of (x, y, heading), shape (3, 3) [m, m, rad]."""
    landmarks: Mapping[Hashable, tuple[Array, Array]] = field(default_factory=dict)
    """Name or index -> mean (2,) [m], covariance (2, 2) [m^2]."""
    innovations: tuple[tuple[Hashable, Array, Array], ...] = ()
    """Of this tick: name, nu (2,) [m, rad], S (2, 2)."""
    joint_covariance: Array | None = None
    """Of the pose, then each landmark in the order of `landmarks`, shape (3 + 2 n, 3 + 2 n); optional."""


@dataclass(frozen=True, slots=True)
class MarkerInfo:
    """A square marker that computers read."""

    dictionary: str
    """As the world file names it: '4x4_50', 'apriltag_36h11' and so on."""
    id: int
    """Its number in the dictionary."""


@dataclass(frozen=True, slots=True, eq=False)
class BeaconInfo:
    """What the catalogue tells of a beacon: picture or marker and its printed size, not where it hangs."""

    name: str
    picture: Picture | None
    """RGB; None for a marker or a reflector."""
    width: float
    """Of the picture, or of the marker's black square without the white border around it [m]."""
    height: float
    """The same [m]."""
    pose: Pose | None = None
    """World frame, facing along its heading; only when the world says `map: known`, and it hangs on nothing that
    moves."""
    center: float | None = None
    """Height of its middle above the floor [m]; only where there is a pose."""
    marker: MarkerInfo | None = None
    """None for a picture or a reflector."""


@dataclass(frozen=True, slots=True, eq=False)
class SensorInfo:
    """A sensor as its data sheet gives it."""

    kind: str
    """'camera' and so on: the key that names it in a world file."""
    robot_from_sensor: Array
    """Homogeneous transform, shape (4, 4) [m]; a camera's frame is optical (x right, y down, z ahead)."""
    rate_hz: float
    noise: Mapping[str, float] = field(default_factory=dict)
    """Standard deviations by the names that the world file uses."""
    intrinsics: Intrinsics | None = None
    """Of a camera."""
    latency: int = 0
    """How many ticks a reading comes after it was taken; its stamp tells when it was."""
    range: tuple[float, float] | None = None
    """Nearest and farthest distance that it measures [m]; None where there is no such limit."""
    fov: float | None = None
    """Horizontal field of view [rad]; None where it sees no things."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RobotInfo:
    """What a module is told of the robot that it works for."""

    name: str
    drive: str
    """'differential' and so on."""
    max_speed: float
    """[m/s]"""
    max_turn: float
    """[rad/s]"""
    max_acceleration: float
    """[m/s^2]"""
    max_turn_acceleration: float
    """[rad/s^2]"""
    wheels: tuple[str, ...]
    """Driven wheels, in the order of `WheelCommand.speeds`."""
    wheel_radius: float
    """[m]"""
    track: float
    """Distance between the wheels to the left and to the right, as wide as turns are computed with [m]."""
    radius: float
    """Of the circle about the origin around the body [m]."""
    dt: float
    """Period of the loop [s]."""
    prior: Pose
    """Mean of the pose at the start."""
    prior_covariance: Array
    """Of (x, y, heading) at the start, shape (3, 3)."""
    sensors: Mapping[str, SensorInfo] = field(default_factory=dict)
    max_left: float = 0.0
    """Largest speed sideways [m/s]; 0 for robots that cannot move so."""
    max_curvature: float = math.inf
    """Of the sharpest arc that it can drive [1/m]; infinite for robots that can turn on the spot."""
    twist_from_wheels: Array | None = None
    """Twist (forward, left, turn) of wheel speeds, a matrix, shape (3, wheels) [m/rad, m/rad, 1]; steering straight."""
    outline: Array | None = None
    """Of the body from above, in its frame, counter-clockwise, shape (n, 2) [m]; None means the circle."""


@dataclass(frozen=True, slots=True, eq=False)
class WorldMap:
    """The walls and obstacles that a module is given when the world says `map: known`."""

    segments: Array
    """Faces of walls and obstacles in the plane, shape (n, 2, 2) [m]."""
    beacons: Mapping[str, Pose]
    """Where the beacons hang, world frame."""


@runtime_checkable
class TakesMap(Protocol):
    """An observer, estimator or avoidance that wants the map as well; a navigator is given it at its start."""

    def take_map(self, map: WorldMap | None) -> None:
        """Get the map before `start`; None unless the world says `map: known`."""


@runtime_checkable
class DriveModel(Protocol):
    """A drive of the user's own: how a twist and the speeds of wheels belong together; both ways linear."""

    wheels: Sequence[str]
    """Names of the hinges in the robot's file, which have velocity servos of the same names."""

    def wheels_from_twist(self, forward: float, left: float, turn: float) -> Sequence[float]:
        """Return the speeds of the wheels [rad/s] for a twist of the robot's origin [m/s, m/s, rad/s]."""

    def twist_from_wheels(self, speeds: Sequence[float]) -> tuple[float, float, float]:
        """Return the twist of speeds; of rotations [rad], the small motion [m, m, rad] that odometry tells."""


@runtime_checkable
class Observer(Protocol):
    """Turns pictures and scans into sightings of beacons."""

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: Generator) -> None:
        """Get ready for a run; called once before the first tick."""

    def observe(self, seen: Observation) -> Sequence[Sighting]:
        """Return what is seen at this tick."""


@runtime_checkable
class Estimator(Protocol):
    """Estimates the robot's pose, and a map if it likes."""

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: Generator) -> None:
        """Get ready for a run; called once before the first tick."""

    def update(self, seen: Observation) -> Estimate:
        """Return the belief after this tick's observation."""


@runtime_checkable
class Navigator(Protocol):
    """Decides where to go."""

    def start(self, robot: RobotInfo, map: WorldMap | None, rng: Generator) -> None:
        """Get ready for a run; called once before the first tick."""

    def command(self, seen: Observation, belief: Estimate) -> Command | WheelCommand:
        """Return the command until the next tick."""


@runtime_checkable
class Avoidance(Protocol):
    """Changes a command so that the robot does not run into things."""

    def start(self, robot: RobotInfo, rng: Generator) -> None:
        """Get ready for a run; called once before the first tick."""

    def adjust(self, command: Command, seen: Observation) -> Command:
        """Return the command that is safe, as near as can be to the one given."""


def sightings_from(
    detections: Sequence[Detection], robot_from_camera: Array, *, stamp: float = 0.0
) -> tuple[Sighting, ...]:
    """Turn detections in a camera's frame into horizontal range and bearing from the robot's origin.

    Args:
        detections: Beacons found in one picture.
        robot_from_camera: Homogeneous transform of the optical frame, shape (4, 4) [m].
        stamp: When the picture was taken [s].

    Returns:
        One sighting a detection, its covariance carried over to first order.

    References:
        Thrun, Burgard, Fox, Probabilistic Robotics (2005), section 6.6 for range and bearing; section 3.3
        for the linear propagation of covariance.
    """
    rotation, offset = robot_from_camera[:3, :3], robot_from_camera[:3, 3]
    sightings = []
    for found in detections:
        x, y = (rotation @ found.position + offset)[:2]
        squared = x * x + y * y
        distance = np.sqrt(squared)
        jacobian = np.array([[x / distance, y / distance], [-y / squared, x / squared]]) @ rotation[:2]
        sightings.append(
            Sighting(
                stamp=stamp,
                name=found.name,
                range=float(distance),
                bearing=float(np.arctan2(y, x)),
                covariance=jacobian @ found.covariance @ jacobian.T,
                corners=found.corners,
            )
        )
    return tuple(sightings)
