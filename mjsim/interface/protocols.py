"""Protocols of modules: observer, estimator, navigator, avoidance, controller and user-defined drive."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from numpy.random import Generator

from mjsim.geometry import Pose
from mjsim.interface.readings import FastReading, Observation, Sighting
from mjsim.interface.values import BeaconInfo, Command, Estimate, RobotInfo, WheelCommand, WorldMap


@runtime_checkable
class TakesMap(Protocol):
    """An observer, estimator or avoidance that also needs the map; a navigator gets it in `start`."""

    def take_map(self, map: WorldMap | None) -> None:
        """Get the map before `start`; None unless the world says `map: known`."""


@runtime_checkable
class HasPath(Protocol):
    """An estimator that also provides a final trajectory, estimated from all measurements of the run."""

    def path(self) -> Sequence[tuple[float, Pose]]:
        """Return strictly ascending times [s] and poses in the frame of the estimates; called once, at the end."""


@runtime_checkable
class SaysLost(Protocol):
    """An estimator that also says when its robot is lost; recorded as the events `lost` and, afterwards, `found`."""

    def lost(self) -> bool:
        """Return whether what the robot senses does not fit its estimate; called once after each update."""


@runtime_checkable
class SaysBlocked(Protocol):
    """A navigator that also says why its robot makes no progress; recorded as the event `blocked` when it begins."""

    def blocked(self) -> str | None:
        """Return the reason, at most 200 characters, or None; called once after each command."""


@runtime_checkable
class TakesGoals(Protocol):
    """A navigator that also takes goals while it runs, from the event `goal`."""

    def take_goal(self, x: float, y: float, heading: float | None) -> None:
        """Take a goal in place of all others, before the command of the tick.

        Args:
            x: x in the frame of the estimate [m].
            y: y in the frame of the estimate [m].
            heading: Heading at the goal [rad]; None for any.
        """


@runtime_checkable
class DriveModel(Protocol):
    """A user-defined drive: linear conversion between twist and wheel speeds."""

    wheels: Sequence[str]
    """Names of the wheel hinges in the robot's file; each has a velocity servo of the same name."""

    def wheels_from_twist(self, forward: float, left: float, turn: float) -> Sequence[float]:
        """Return the speeds of the wheels [rad/s] for a twist of the robot's origin [m/s, m/s, rad/s]."""

    def twist_from_wheels(self, speeds: Sequence[float]) -> tuple[float, float, float]:
        """Return the twist for wheel speeds, or, for rotations [rad], the small motion [m, m, rad] for odometry."""


@runtime_checkable
class Observer(Protocol):
    """Turns pictures and scans into sightings of beacons."""

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: Generator) -> None:
        """Get ready for a run; called once before the first tick."""

    def observe(self, seen: Observation) -> Sequence[Sighting]:
        """Return the sightings of this tick."""


@runtime_checkable
class Estimator(Protocol):
    """Estimates the robot's pose, and optionally a map."""

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
    """Changes a command so that the robot avoids obstacles."""

    def start(self, robot: RobotInfo, rng: Generator) -> None:
        """Get ready for a run; called once before the first tick."""

    def adjust(self, command: Command, seen: Observation) -> Command:
        """Return the safe command closest to the one given."""


@runtime_checkable
class Controller(Protocol):
    """Controls the motors of one part of a robot between ticks: a balancing base, or an arm."""

    def start(self, robot: RobotInfo, part: str, rng: Generator) -> None:
        """Get ready for a run; `part` is 'drive', or the name of the arm. Called once before the first step."""

    def torques(self, sensed: FastReading, wanted: Command) -> Sequence[float]:
        """Return the torque of each motor until the next call [N m], on the side of the wheel or joint.

        Args:
            sensed: Readings of encoders and inertial sensors.
            wanted: Set-points: what the navigator commanded, within the limits of the drive.
        """


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlLoop:
    """A controller with rate and latency."""

    controller: Controller
    """The controller, not yet started."""
    rate_hz: float = 250.0
    """Rate of calls; the period is a whole number of physics steps."""
    latency: int = 0
    """Delay from sensing to actuation [physics steps]."""
