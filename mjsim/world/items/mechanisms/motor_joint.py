"""Joints with a motor, as of doors."""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorJoint:
    """A joint with one degree of freedom and a motor; its value is an angle [rad] or a distance [m].

    Below, N stands for N m, kg for kg m^2 and so on if the joint is revolute.
    """

    name: str
    """Its name in the scene, also of its motor and its lock: `MECHANISM/JOINT`."""
    kind: Literal["revolute", "prismatic"] = "revolute"
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    """Axis in the frame of the body that it moves, right-handed."""
    start: float = 0.0
    """Its value at the start."""
    lower: float
    upper: float
    damping: float = 0.0
    """[N s]"""
    stiffness: float = 0.0
    """Stiffness of a spring that pulls it to 0 [N]."""
    locked: bool = False
    """Whether it is locked while its motor does not move it; otherwise it moves freely."""
    inertia: float
    """Mass that its motor moves [kg]."""
    effort: float
    """Largest force of its motor [N]."""
    speed: float
    """Speed at which its motor moves it [1/s]."""
    lead: float
    """Largest lead of the motor's set-point over a joint that is obstructed."""
    tolerance: float
    """The motion has ended when the joint is this close to its goal, and this slow [1/s]."""
