"""One step of an episode, the input of reward functions."""

from collections.abc import Mapping
from dataclasses import dataclass

from mjsim.geometry import Pose
from mjsim.interface import Command, Estimate, Observation, WheelCommand
from mjsim.record import RobotEvent
from mjsim.world import WorldEvent


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Step:
    """One step, including the truth, which is for the trainer: no observation of the environment has it."""

    time: float
    """Time at the end of the step, since the start of the episode [s]."""
    truth: Mapping[str, Pose]
    """Pose of every robot, world frame."""
    before: Mapping[str, Pose]
    """Pose of every robot before the step; at the start of an episode, the same as `truth`."""
    things: Mapping[str, Pose]
    """Poses of all other movable things: `obstacle/NAME`, `door/NAME`."""
    seen: Mapping[str, Observation]
    """Observation of each robot that is controlled or has modules, including the sightings of its observer."""
    belief: Mapping[str, Estimate]
    """Estimates of the same robots; dead reckoning without an estimator."""
    wanted: Mapping[str, Command | WheelCommand]
    """Commands of their navigators or actions in this step; empty at the start."""
    command: Mapping[str, Command | WheelCommand]
    """Commands given to their drives in this step, after avoidance and bump reaction; empty at the start."""
    events: Mapping[str, tuple[RobotEvent, ...]]
    """Events of the same robots: `bump` when a contact starts, `blocked` when avoidance starts to block a command."""
    happened: tuple[WorldEvent, ...] = ()
    """Events of the world in this step: doors, lamps, moved and removed things."""
