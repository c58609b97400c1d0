"""One iteration of the loop, as it is recorded and shown."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from mjsim.geometry import Array, Pose, Pose3
from mjsim.interface import Command, Estimate, Observation, Sighting, WheelCommand
from mjsim.mechanics import JointMotion, SensorReadings
from mjsim.world import Looks, WorldEvent

EventKind = Literal["bump", "blocked", "lost", "found", "fall", "fault", "changed"]
"""bump: contact; blocked: a command was not executed, or the navigator finds no path; lost, found: what the robot
senses no longer fits its estimate, or fits again; fall: it fell over; fault: a module failed; changed: its noise was
changed."""


@dataclass(frozen=True, slots=True)
class RobotEvent:
    """An event of a robot."""

    time: float
    """[s]"""
    kind: EventKind
    text: str
    """Description."""
    bearing: float | None = None
    """Bearing of the contact, left positive [rad]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Order:
    """The results of one robot's modules at one tick."""

    command: Command | WheelCommand
    """Command given to the drive, after avoidance and bump reaction."""
    wanted: Command | WheelCommand
    """Command of the navigator."""
    estimate: Estimate
    dead_reckoning: Pose
    """Odometry integrated from the prior."""
    dead_reckoning_covariance: Array
    """Shape (3, 3) [m, m, rad]."""
    sightings: tuple[Sighting, ...] = ()
    """All sightings of this tick, from the sensors and the observer."""
    events: tuple[RobotEvent, ...] = ()
    timing: Mapping[str, float] = field(default_factory=dict)
    """Wall-clock time of each module [s]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Tick:
    """Everything about one iteration of the loop. The truth is here, never in an Observation."""

    time: float
    """[s]"""
    truth: Mapping[str, Pose]
    """Pose of each robot whose place is known, seen from above, world frame."""
    poses: Mapping[str, Pose3]
    """3-D pose of the base of the same robots, world frame."""
    seen: Mapping[str, Observation]
    """Observation of each robot with a driver, by name."""
    orders: Mapping[str, Order]
    """Results of the modules of these robots, by name."""
    qpos: Array
    """State of MuJoCo, so that pictures can be rendered again."""
    qvel: Array
    """Velocities of MuJoCo, shape (nv,)."""
    timing: Mapping[str, float] = field(default_factory=dict)
    """Wall-clock time of sensing and physics [s]."""
    events: tuple[WorldEvent, ...] = ()
    """Events of the world since the previous tick."""
    things: Mapping[str, Pose] = field(default_factory=dict)
    """Poses of all movable things except robots, by their names in the scene: `obstacle/NAME`, `door/NAME`."""
    joints: Mapping[str, JointMotion] = field(default_factory=dict)
    """Motion of the joints of each arm and each mechanism, by `ROBOT/ARM` and by the mechanism's name."""
    readings: Mapping[str, SensorReadings] = field(default_factory=dict)
    """Sensor readings of each mechanism."""
    looks: Looks | None = None
    """Light and removed things; None in a world where these cannot change."""
    identities: Mapping[str, tuple[str | None, ...]] = field(default_factory=dict)
    """True beacon of each sighting of a robot's sensors, None for a false sighting; sightings of the observer follow
    them."""
