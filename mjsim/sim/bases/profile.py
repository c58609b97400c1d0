"""Velocity profiles: apply the limits of a base and motor noise to commands."""

import math
from collections.abc import Sequence
from typing import Protocol

from mjsim.interface import Command, WheelCommand
from mjsim.sim.odometry import Twist
from mjsim.world import DriveNoise

STANDSTILL = 1e-3
"""A car that is slower cannot turn; its steering stays as it is [m/s]."""


class VelocityProfile(Protocol):
    """Interface of all bases: converts commands to set-points of servos."""

    def command(self, command: Command | WheelCommand) -> None:
        """Take a command, held until the next."""

    def advance(self) -> Sequence[float]:
        """Return what the servos are told to reach in the next tick: wheels [rad/s], then steering [rad]."""

    def retune(self, noise: DriveNoise) -> None:
        """Use this noise from now on."""


def reach(dt: float, lag: float) -> float:
    """Return by how much more than a change to ask for; a servo comes 1 - exp(-dt / lag) of the way in one tick."""
    return 1.0 / -math.expm1(-dt / lag)


def within(value: float, limit: float) -> float:
    """Return the value nearest to one that is wanted, of those from -limit to limit."""
    return min(max(value, -limit), limit)


def scaled(twist: Twist, limits: Twist) -> Twist:
    """Return the twist, made slower as a whole until all parts keep their limits."""
    forward, left, turn = twist
    if limits[1] == 0.0:
        excess = max(1.0, abs(forward) / limits[0], abs(turn) / limits[2])
        return forward / excess, 0.0, turn / excess
    excess = max(1.0, abs(forward) / limits[0], abs(left) / limits[1], abs(turn) / limits[2])
    return forward / excess, left / excess, turn / excess
