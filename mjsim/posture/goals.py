"""What is asked of figures that sit: a seat, and what hands, feet and eyes meet."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from mjsim.geometry import Array

TOOLS: Mapping[str, str] = {"fist": "grip", "thumb": "thumb_tip", "finger": "fingertip"}
"""Landmark of a hand by what touches."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Seating:
    """A seat, as whoever sits on it meets it."""

    world_from_seat: Array
    """The hip point in the middle of the travel, x ahead, z up, shape (4, 4) [m]."""
    back: float | None = None
    """How far the backrest leans back from upright; None for a stool [rad]."""
    travel: tuple[float, float] = (0.0, 0.0)
    """How far the hip point can be set, along and up, from end to end [m]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Goals:
    """What a sitting figure holds, steps on and looks at; points in the world, shape (3,) each [m]."""

    hands: Mapping[str, tuple[str, Array]] = field(default_factory=dict)
    """By side: a key of `TOOLS`, and where it is to be."""
    feet: Mapping[str, Array] = field(default_factory=dict)
    """By side: where the ball of the foot is to be; others stand flat on the floor."""
    gaze: Array | None = None
    """What the normal line of sight meets."""
    floor: float | None = 0.0
    """Height that feet without a pedal stand on [m]; None lets them hang."""
    leans: bool = True
    """Whether the back touches the backrest."""
