"""Goals of seated figures: a seat, and targets for hands, feet and eyes."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from mjsim.geometry import Array

TOOLS: Mapping[str, str] = {"fist": "grip", "thumb": "thumb_tip", "finger": "fingertip"}
"""Landmark of a hand by its contact point."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Seating:
    """A seat for a figure."""

    world_from_seat: Array
    """The hip point in the middle of the travel, x forward, z up, shape (4, 4) [m]."""
    back: float | None = None
    """Backward lean of the backrest from vertical [rad]; None for a stool."""
    travel: tuple[float, float] = (0.0, 0.0)
    """Adjustment range of the hip point, along and up, from end to end [m]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Goals:
    """Targets of a seated figure; points in the world frame, shape (3,) each [m]."""

    hands: Mapping[str, tuple[str, Array]] = field(default_factory=dict)
    """By side: a key of `TOOLS`, and the target position."""
    feet: Mapping[str, Array] = field(default_factory=dict)
    """By side: the target position of the ball of the foot; feet without one stand flat on the floor."""
    gaze: Array | None = None
    """Target of the normal line of sight."""
    floor: float | None = 0.0
    """Height on which feet without a pedal stand [m]; None lets them hang."""
    leans: bool = True
    """Whether the back touches the backrest."""
