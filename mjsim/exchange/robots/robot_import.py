"""Inputs and results of the importer of robots; without loading the importer."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotOptions:
    """What the user specifies where the file is ambiguous."""

    left: Sequence[str] = ()
    """Joints of the left wheels."""
    right: Sequence[str] = ()
    steering: Sequence[str] = ()
    """Steering joints."""
    drive: str | None = None
    """Kind of drive."""
    forward: str | None = None
    """Forward direction in the file frame: +x, -x, +y or -y."""
    model: str = ""
    """Name of the robot in an SDF file with several."""


@dataclass(frozen=True, slots=True)
class BroughtRobot:
    """The preset of a robot."""

    text: str
    """Text of a world with only this robot, which other worlds use as a preset."""
    files: Mapping[str, bytes] = field(default_factory=dict)
    """Its model and all files that it refers to, by paths relative to the preset."""
    report: Sequence[str] = ()
    """Lines for the user: what was found and what was changed."""
