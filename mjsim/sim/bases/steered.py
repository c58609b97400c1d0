"""Base class of the velocity profiles of bases with a steered wheel: limits, noise, speed and angle."""

import math

from numpy.random import Generator

from mjsim.compile import LAG
from mjsim.sim.bases.profile import reach
from mjsim.world import AckermannDrive, DriveNoise, TricycleDrive


class SteeredProfile:
    """The limits of a base with a steered wheel, and its current speed and steering angle."""

    def __init__(self, drive: AckermannDrive | TricycleDrive, *, dt: float, stream: Generator) -> None:
        """Initialise, standing still, steering straight ahead; two random numbers are drawn per tick."""
        self._limits = drive.max_speed, 0.0, math.radians(drive.max_turn_deg)
        self._max_steer = math.radians(drive.max_steer_deg)
        self._changes = drive.max_acceleration * dt, math.radians(drive.max_steer_rate_deg) * dt
        self._root = math.sqrt(dt)
        self.retune(drive.noise)
        self._reach = reach(dt, LAG)
        self._stream = stream
        self._target = self._state = 0.0, 0.0

    def retune(self, noise: DriveNoise) -> None:
        """Use this noise from now on."""
        self._noise = noise.speed / self._root, noise.turn / self._root
