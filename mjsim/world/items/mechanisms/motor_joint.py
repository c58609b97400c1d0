"""Mechanisms: bodies that joints hold to the world and to each other; doors are the first kind."""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorJoint:
    """A joint with one degree of freedom and a motor; its value is an angle [rad] or a distance [m].

    Below, N stands for N m, kg for kg m^2 and so on where the joint is revolute.
    """

    name: str
    """In the scene, that of its motor and of its lock too: `MECHANISM/JOINT`."""
    kind: Literal["revolute", "prismatic"] = "revolute"
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    """In the frame of the body that it moves, right-handed."""
    start: float = 0.0
    """Its value at the start."""
    lower: float
    upper: float
    damping: float = 0.0
    """[N s]"""
    stiffness: float = 0.0
    """Of a spring that pulls it to 0 [N]."""
    locked: bool = False
    """Whether it is held where it is while its motor does not move it; else it moves freely."""
    inertia: float
    """That its motor moves [kg]."""
    effort: float
    """Largest of its motor [N]."""
    speed: float
    """At which its motor moves it [1/s]."""
    lead: float
    """How far the motor's set-point may go ahead of a joint that something holds up."""
    tolerance: float
    """The motor has done its work when the joint is as near to its goal as this, and as slow [1/s]."""
