"""Compasses: the heading from magnetic east, with a bias that depends on the place."""

import math

import numpy as np

from mjsim.compile import robot_from_sensor
from mjsim.geometry import Array, wrap_angle
from mjsim.interface import CompassReading, SensorInfo
from mjsim.sim.sensors.device import Mounting
from mjsim.world import sensors

WAVE_COUNT = 128
"""Number of plane waves whose sum is the field of a bias; its values are nearly normal."""
FINEST = math.radians(0.1)
"""Minimum standard deviation in a data sheet [rad]."""


class SmoothField:
    """A stationary random field in the plane with mean 0, variance 1 and a squared exponential correlation.

    References:
        Rahimi and Recht, Random Features for Large-Scale Kernel Machines, NIPS 2007, section 3.
    """

    def __init__(self, seed: int, length: float) -> None:
        """Draw the waves.

        Args:
            seed: Seed of the field.
            length: Correlation length: exp(-d^2 / (2 length^2)) at the distance d [m].
        """
        rng = np.random.default_rng([seed, *b"compass/field"])
        self._numbers, self._phases = (
            rng.standard_normal((WAVE_COUNT, 2)) / length,
            rng.uniform(0.0, math.tau, WAVE_COUNT),
        )

    def at(self, places: Array) -> Array:
        """Return the values at places, shape (..., 2) [m]."""
        return np.asarray(math.sqrt(2.0 / WAVE_COUNT) * np.cos(places @ self._numbers.T + self._phases).sum(axis=-1))


class CompassDevice:
    """A compass of a robot in a running simulation; each reading draws one random number."""

    def __init__(self, compass: sensors.Compass, mounting: Mounting) -> None:
        """Draw the field of its bias.

        Args:
            compass: Compass of the world file.
            mounting: Its mounting.
        """
        self._base, self._white = mounting.data.body(f"{mounting.robot.name}/base"), mounting.streams("heading")
        self._field = SmoothField(compass.bias.seed, compass.bias.length)
        self.retune(compass)

    def retune(self, compass: sensors.Compass) -> None:
        """Use the noise of this model from now on; the field stays."""
        self._compass, self._noise = compass, math.radians(compass.noise.heading_deg)
        self._amplitude = math.radians(compass.bias.amplitude_deg)

    def info(self) -> SensorInfo:
        """Return its data sheet."""
        return SensorInfo(
            kind="compass",
            robot_from_sensor=robot_from_sensor(self._compass.at, yaw_deg=0.0),
            rate_hz=self._compass.rate_hz,
            noise={"heading": self._noise, "bias": self._amplitude},
            latency=self._compass.latency,
        )

    def take(self, stamp: float) -> CompassReading:
        """Return the current heading; `stamp` is the simulated time [s]."""
        axes = self._base.xmat.reshape(3, 3)
        place = self._base.xpos + axes @ self._compass.at
        heading = math.atan2(axes[1, 0], axes[0, 0]) + math.radians(self._compass.declination_deg)
        error = self._amplitude * self._field.at(place[:2]) + self._noise * self._white.standard_normal()
        return CompassReading(stamp, wrap_angle(float(heading + error)), max(self._noise, FINEST) ** 2)

    def pass_over(self) -> None:
        """Draw the random number of a reading that was not requested."""
        self._white.standard_normal()
