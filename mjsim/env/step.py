"""One step of an episode, as those see it who reward it."""

from collections.abc import Mapping
from dataclasses import dataclass

from mjsim.geometry import Pose
from mjsim.interface import Command, Estimate, Observation, WheelCommand
from mjsim.record import RobotEvent
from mjsim.world import WorldEvent


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Step:
    """What one step came to. It holds the truth, which is the trainer's: no observation of the environment has it."""

    time: float
    """At the end of the step, since the start of the episode [s]."""
    truth: Mapping[str, Pose]
    """Where every robot is now, world frame."""
    before: Mapping[str, Pose]
    """Where every robot was before the step; the same as now at the start of an episode."""
    things: Mapping[str, Pose]
    """Where everything else is now that can move: `obstacle/NAME`, `door/NAME`."""
    seen: Mapping[str, Observation]
    """What each robot that is driven or has modules senses now, with what its observer saw."""
    belief: Mapping[str, Estimate]
    """What the same robots' estimators believe now; dead reckoning of those without one."""
    wanted: Mapping[str, Command | WheelCommand]
    """What their navigators or actions asked for in this step; empty at the start."""
    command: Mapping[str, Command | WheelCommand]
    """What their drives were told in this step, after avoidance and bump reaction; empty at the start."""
    events: Mapping[str, tuple[RobotEvent, ...]]
    """Of the same robots: `bump` when one begins now, `blocked` when a command begins not to be let through."""
    happened: tuple[WorldEvent, ...] = ()
    """What happened to the world in this step: doors, lamps, what was moved or removed."""
