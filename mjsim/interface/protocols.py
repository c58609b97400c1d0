"""What modules of users follow: observer, estimator, navigator, avoidance, controller, and a drive of their own."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from numpy.random import Generator

from mjsim.geometry import Pose
from mjsim.interface.readings import FastReading, Observation, Sighting
from mjsim.interface.values import BeaconInfo, Command, Estimate, RobotInfo, WheelCommand, WorldMap


@runtime_checkable
class TakesMap(Protocol):
    """An observer, estimator or avoidance that wants the map as well; a navigator is given it at its start."""

    def take_map(self, map: WorldMap | None) -> None:
        """Get the map before `start`; None unless the world says `map: known`."""


@runtime_checkable
class HasPath(Protocol):
    """An estimator that also tells its final trajectory: where the robot was, by all that it saw until the end."""

    def path(self) -> Sequence[tuple[float, Pose]]:
        """Return times, strictly ascending [s], and poses in the frame of the estimates; asked once, at the end."""


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


@runtime_checkable
class Controller(Protocol):
    """Drives the motors of one part of a robot between ticks: a balancing base, or an arm."""

    def start(self, robot: RobotInfo, part: str, rng: Generator) -> None:
        """Get ready for a run; `part` is 'drive', or the name of the arm. Called once before the first step."""

    def torques(self, sensed: FastReading, wanted: Command) -> Sequence[float]:
        """Return the torque of each motor until the next call [N m], on the side of the wheel or joint.

        Args:
            sensed: What encoders and inertial sensors tell.
            wanted: Set-points: what the navigator commanded, within the limits of the drive.
        """


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlLoop:
    """A controller with its rate and its latency."""

    controller: Controller
    rate_hz: float = 250.0
    """How often it is asked; a period is a whole number of physics steps."""
    latency: int = 0
    """Physics steps from what it senses until its torques act."""
