"""One turn of the loop, as it is recorded and shown."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from mjsim.geometry import Array, Pose, Pose3
from mjsim.interface import Command, Estimate, Observation, Sighting, WheelCommand
from mjsim.mechanics import JointMotion, SensorReadings
from mjsim.world import Looks, WorldEvent

EventKind = Literal["bump", "blocked", "fall", "fault", "changed"]
"""bump: it touched something; blocked: a command was not let through; fall: it fell over; fault: a module failed;
changed: somebody changed how far it errs."""


@dataclass(frozen=True, slots=True)
class RobotEvent:
    """Something that happened to a robot."""

    time: float
    """[s]"""
    kind: EventKind
    text: str
    """For people."""
    bearing: float | None = None
    """Where it was touched, left positive [rad]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Order:
    """What the modules of one robot made of one tick."""

    command: Command | WheelCommand
    """What the drive is told, after avoidance and bump reaction."""
    wanted: Command | WheelCommand
    """What the navigator asked for."""
    estimate: Estimate
    dead_reckoning: Pose
    """Odometry summed from the prior."""
    dead_reckoning_covariance: Array
    """Shape (3, 3) [m, m, rad]."""
    sightings: tuple[Sighting, ...] = ()
    """All of this tick, of the sensor and of the observer."""
    events: tuple[RobotEvent, ...] = ()
    timing: Mapping[str, float] = field(default_factory=dict)
    """Wall-clock time of each module [s]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Tick:
    """The whole of one turn of the loop. The truth is here, never in an Observation."""

    time: float
    """[s]"""
    truth: Mapping[str, Pose]
    """Of each robot whose place is known, seen from above, world frame."""
    poses: Mapping[str, Pose3]
    """Of the same robots: the pose of the base in space, world frame."""
    seen: Mapping[str, Observation]
    orders: Mapping[str, Order]
    qpos: Array
    """State of MuJoCo, so that pictures can be drawn again."""
    qvel: Array
    timing: Mapping[str, float] = field(default_factory=dict)
    """Wall-clock time of sensing and physics [s]."""
    events: tuple[WorldEvent, ...] = ()
    """What has happened to the world since the tick before."""
    things: Mapping[str, Pose] = field(default_factory=dict)
    """Where everything is that can move but robots, by its name in the scene: `obstacle/NAME`, `door/NAME`."""
    joints: Mapping[str, JointMotion] = field(default_factory=dict)
    """How the joints of each arm and each mechanism move, by `ROBOT/ARM` and by the mechanism's name."""
    readings: Mapping[str, SensorReadings] = field(default_factory=dict)
    """What the sensors of each mechanism read."""
    looks: Looks | None = None
    """Light, and what is no longer there; None in a world that knows no such thing."""
    identities: Mapping[str, tuple[str | None, ...]] = field(default_factory=dict)
    """Which beacon each of a robot's sensors' sightings is of, None for one of nothing; they come before those of the
    observer."""
