"""Velocity profiles: apply the limits of a base and motor noise to commands."""

import math
from collections.abc import Sequence
from typing import Protocol

from mjsim.interface import Command, WheelCommand
from mjsim.sim.odometry import Twist
from mjsim.world import DriveNoise

MIN_STEERING_SPEED = 1e-3
"""A car slower than this keeps its steering angle [m/s]."""


class VelocityProfile(Protocol):
    """Interface of all bases: converts commands to set-points of servos."""

    def command(self, command: Command | WheelCommand) -> None:
        """Take a command, held until the next."""

    def advance(self) -> Sequence[float]:
        """Return the set-points of the servos for the next tick: wheels [rad/s], then steering [rad]."""

    def retune(self, noise: DriveNoise) -> None:
        """Use this noise from now on."""


def reach(dt: float, lag: float) -> float:
    """Return the factor by which to increase a change, because a servo reaches 1 - exp(-dt / lag) of it in one tick."""
    return 1.0 / -math.expm1(-dt / lag)


def within(value: float, limit: float) -> float:
    """Return a value limited to -limit to limit."""
    return min(max(value, -limit), limit)


def scaled(twist: Twist, limits: Twist) -> Twist:
    """Return the twist, scaled down until all components are within their limits."""
    forward, left, turn = twist
    if limits[1] == 0.0:
        excess = max(1.0, abs(forward) / limits[0], abs(turn) / limits[2])
        return forward / excess, 0.0, turn / excess
    excess = max(1.0, abs(forward) / limits[0], abs(left) / limits[1], abs(turn) / limits[2])
    return forward / excess, left / excess, turn / excess
