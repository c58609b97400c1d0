"""Results of modules (commands and estimates), and their information about robot and world."""

import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.interface.readings import Intrinsics, Picture, Sighting
from mjsim.interface.shown import Shown

if TYPE_CHECKING:  # most robots have no arm
    from mjsim.mechanics import Arm


@dataclass(frozen=True, slots=True, kw_only=True)
class JointGoal:
    """Set-points of the joints of an arm and their motion until the next goal; one number per joint."""

    positions: tuple[float, ...]
    """[rad], or [m] of joints that slide."""
    velocities: tuple[float, ...] | None = None
    """[rad/s], or [m/s]; by default at rest."""
    accelerations: tuple[float, ...] | None = None
    """[rad/s^2], or [m/s^2]; 0 unless given."""
    torques: tuple[float, ...] | None = None
    """Feed-forward torques, added to the controller's [N m], or [N]."""

    def after(self, seconds: float) -> "JointGoal":
        """Return the goal after a time [s], extrapolated with its velocities and accelerations."""
        if self.velocities is None:
            return self
        speeds = self.velocities
        faster = self.accelerations or (0.0,) * len(speeds)
        both = [(speed, more) for speed, more in zip(speeds, faster, strict=True)]
        displacements = [seconds * speed + 0.5 * seconds * seconds * more for speed, more in both]
        return JointGoal(
            positions=tuple(
                place + displacement for place, displacement in zip(self.positions, displacements, strict=True)
            ),
            velocities=tuple(speed + seconds * more for speed, more in both),
            accelerations=self.accelerations,
            torques=self.torques,
        )


@dataclass(frozen=True, slots=True)
class Command:
    """A twist in the robot frame, and goals of its arms, held until the next tick.

    Examples:
        >>> import mjsim
        >>> mjsim.Command(forward=0.3, turn=0.1).forward
        0.3
    """

    forward: float = 0.0
    """[m/s]"""
    left: float = 0.0
    """[m/s]; 0 for robots that cannot move sideways."""
    turn: float = 0.0
    """Counter-clockwise [rad/s]."""
    messages: tuple[Any, ...] = ()
    """Messages to all other robots, sent once: numbers, strings, None, and lists and dicts of these."""
    joints: Mapping[str, JointGoal] = field(default_factory=dict)
    """Goals by the name of the arm; other arms keep their goals."""


@dataclass(frozen=True, slots=True)
class WheelCommand:
    """Angular speeds of the driven wheels, in the order of `RobotInfo.wheels`."""

    speeds: tuple[float, ...]
    """[rad/s]"""


@dataclass(frozen=True, slots=True, eq=False)
class Detection:
    """A beacon found in a picture."""

    name: str
    """Name of the beacon."""
    position: Array
    """Its centre in the camera's optical frame (x right, y down, z ahead), shape (3,) [m]."""
    covariance: Array
    """Covariance of the position, shape (3, 3) [m^2]."""
    corners: Array
    """Shape (4, 2) [px], clockwise from the picture's own top left."""


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """The result of an estimator.

    Examples:
        >>> import mjsim
        >>> import numpy as np
        >>> estimate = mjsim.Estimate(mjsim.Pose(1.0, 2.0, 0.0), np.diag([0.01, 0.01, 0.001]))
        >>> estimate.covariance.shape
        (3, 3)
    """

    pose: Pose
    """Mean pose, in the frame of the prior of `RobotInfo`."""
    covariance: Array
    """Covariance of (x, y, heading), shape (3, 3) [m, m, rad]."""
    landmarks: Mapping[Hashable, tuple[Array, Array]] = field(default_factory=dict)
    """Name or index -> mean (2,) [m], covariance (2, 2) [m^2]."""
    innovations: tuple[tuple[Hashable, Array, Array], ...] = ()
    """Innovations of this tick: name, nu (2,) [m, rad], S (2, 2)."""
    joint_covariance: Array | None = None
    """Joint covariance of the pose, then each landmark in the order of `landmarks`, shape (3 + 2 n, 3 + 2 n);
    optional."""
    show: tuple[Shown, ...] = field(default=(), kw_only=True)
    """Items to display: points, lines, grids and texts; recorded, and drawn by the studio and Foxglove."""


@dataclass(frozen=True, slots=True)
class MarkerInfo:
    """A square fiducial marker."""

    dictionary: str
    """Dictionary as in the world file: '4x4_50', 'apriltag_36h11' and so on."""
    id: int
    """Its number in the dictionary."""


@dataclass(frozen=True, slots=True, eq=False)
class BeaconInfo:
    """A beacon in the catalogue: picture or marker and printed size, but not its position."""

    name: str
    """Name in the world file."""
    picture: Picture | None
    """RGB; None for a marker, a reflector or an anchor."""
    width: float
    """Width of the picture, or of the marker's black square without its white border [m]."""
    height: float
    """The same [m]."""
    pose: Pose | None = None
    """Pose in the world frame, facing along its heading; only if the world says `map: known` and its carrier does not
    move."""
    center: float | None = None
    """Height of its centre above the floor [m]; only with a pose."""
    marker: MarkerInfo | None = None
    """None for a picture, a reflector or an anchor."""
    anchor: bool = False
    """Whether it has a radio anchor."""


@dataclass(frozen=True, slots=True, eq=False)
class SensorInfo:
    """The data sheet of a sensor."""

    kind: str
    """'camera' and so on: the key that names it in a world file."""
    robot_from_sensor: Array
    """Homogeneous transform, shape (4, 4) [m]; a camera's frame is optical (x right, y down, z ahead). On an arm, the
    one at the start."""
    rate_hz: float
    """Readings per second [Hz]."""
    noise: Mapping[str, float] = field(default_factory=dict)
    """Standard deviations by the names that the world file uses."""
    intrinsics: Intrinsics | None = None
    """Intrinsics of a camera."""
    latency: int = 0
    """Delay of a reading [ticks]; its stamp is the time of measurement."""
    range: tuple[float, float] | None = None
    """Minimum and maximum range [m]; None if unlimited."""
    fov: float | None = None
    """Horizontal field of view [rad]; None if it has none."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BalancingInfo:
    """The data sheet of a balancing base; the body is everything except the wheels."""

    wheel_mass: float
    """Mass of each wheel [kg]."""
    wheel_inertia: float
    """Inertia of each wheel about the axle [kg m^2]."""
    wheel_across: float
    """Inertia of each wheel about the vertical through its centre [kg m^2]."""
    body_mass: float
    """[kg]"""
    center: float
    """Height of the body's centre of mass above the axle [m]."""
    pitch_inertia: float
    """Inertia of the body about an axis parallel to the axle through its centre of mass [kg m^2]."""
    yaw_inertia: float
    """Inertia of the body about the vertical through its centre of mass [kg m^2]."""
    max_torque: float
    """Maximum torque of each wheel's motor [N m]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ArmInfo:
    """The data sheet of an arm; each array has shape (joints,)."""

    joints: tuple[str, ...]
    """Names, from the base outwards."""
    lower: Array
    """Lower limits, -inf if there is none [rad], or [m] of joints that slide."""
    upper: Array
    """Upper limits, inf if there is none."""
    max_velocity: Array
    """Maximum speeds, infinite if unknown [rad/s], or [m/s]."""
    max_torque: Array
    """Maximum torques at the joint, infinite if unknown [N m], or [N]."""
    model: "Arm"
    """Its kinematics and dynamics, in the robot frame."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RobotInfo:
    """The data sheet of the robot, given to its modules."""

    name: str
    """Name in the world file."""
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
    """Distance between the left and right wheels, as used to compute turns [m]."""
    radius: float
    """Radius of the circle about the origin that contains the body [m]."""
    dt: float
    """Period of the control loop [s]."""
    prior: Pose
    """Mean of the initial pose."""
    prior_covariance: Array
    """Covariance of the initial (x, y, heading), shape (3, 3)."""
    sensors: Mapping[str, SensorInfo] = field(default_factory=dict)
    """Data sheets of its sensors, by name."""
    max_left: float = 0.0
    """Maximum sideways speed [m/s]; 0 for robots that cannot move sideways."""
    max_curvature: float = math.inf
    """Maximum curvature [1/m]; infinite for robots that can turn on the spot."""
    twist_from_wheels: Array | None = None
    """Matrix from wheel speeds to the twist (forward, left, turn), shape (3, wheels) [m/rad, m/rad, 1], for straight
    steering."""
    outline: Array | None = None
    """Outline of the body from above, in its frame, counter-clockwise, shape (n, 2) [m]; None means the circle."""
    balancing: BalancingInfo | None = None
    """Masses of a balancing base; its wheel encoders measure relative to the pitching body."""
    arms: Mapping[str, ArmInfo] = field(default_factory=dict)
    """By their names."""


@dataclass(frozen=True, slots=True, eq=False)
class WorldMap:
    """The map of walls and obstacles, given to modules if the world says `map: known`."""

    segments: Array
    """Faces of walls and obstacles in the plane, shape (n, 2, 2) [m]."""
    beacons: Mapping[str, Pose]
    """Beacons with their poses, world frame."""


def sightings_from(
    detections: Sequence[Detection], robot_from_camera: Array, *, stamp: float = 0.0
) -> tuple[Sighting, ...]:
    """Convert detections in a camera frame to horizontal range and bearing from the robot's origin.

    Args:
        detections: Beacons found in one picture.
        robot_from_camera: Homogeneous transform of the optical frame, shape (4, 4) [m].
        stamp: When the picture was taken [s].

    Returns:
        One sighting per detection, with its covariance propagated to first order.

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
