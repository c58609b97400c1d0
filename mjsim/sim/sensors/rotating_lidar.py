"""2-D lidars that measure while they rotate and the robot moves."""

import math

import numpy as np

from mjsim.geometry import Array
from mjsim.sim.rays import BatchRays
from mjsim.sim.sensors.device import CarriedSensor, Device, Mounting
from mjsim.sim.sensors.lidar import LidarDevice
from mjsim.world import sensors

EPSILON = 1e-9
"""Share of a step by which a beam may miss the end of the step through rounding."""


class RotatingLidarDevice(LidarDevice):
    """A lidar that makes one revolution per period and fires each beam at its own time; the last one is at the tick.

    Between the states after two steps of the physics, the sensor moves evenly. Rays are only cast on request.
    """

    def __init__(self, lidar: sensors.Lidar, mounting: Mounting) -> None:
        """Initialise.

        Args:
            lidar: Lidar of the world file.
            mounting: Its mounting; each option has its own random stream.
        """
        self._count = 0
        super().__init__(lidar, mounting)

    def _aim(self, fan: Array, mount: CarriedSensor) -> None:
        """Distribute the rays over the steps of the physics before a tick."""
        lidar, model = self._lidar, self._mounting.model
        self._increment = self._step / (2.0 * math.pi * lidar.rate_hz)
        before = self._increment / model.opt.timestep * np.arange(lidar.beams - 1, -1, -1)
        steps = np.floor(before + EPSILON).astype(int)
        batches = int(steps[0]) + 1
        spots = len(fan) // lidar.beams
        # The rays of one beam, at its centre and at the edges of its spot, follow each other.
        self._order = np.arange(len(fan)).reshape(spots, lidar.beams).T.ravel()
        self._shares = np.repeat(1.0 - (before - steps), spots)
        self._beams = fan[self._order]
        edges = np.searchsorted(batches - 1 - steps, np.arange(batches + 1)) * spots
        self._turn = BatchRays(
            model, self._mounting.robot.name, carrier=mount.carrier, mount=mount.carrier_from_sensor, edges=edges
        )
        if not self._count:
            self._states = np.empty((batches + 1, model.nq))

    def after_step(self) -> None:
        """Store the state after a step of the physics."""
        self._states[self._count % len(self._states)] = self._mounting.data.qpos
        self._count += 1

    def _cast(self, count: int) -> tuple[Array, Array | None]:
        if not self._count:
            self._states[:] = self._mounting.data.qpos
        newest, kept = self._count - 1, len(self._states)
        # Before the first step, everything is assumed to be at rest.
        states = self._states[np.arange(newest - kept + 1, newest + 1).clip(0) % kept]
        hits = self._turn.cast_between(self._beams, states, self._shares, limit=self._farthest)
        distances = np.empty(len(self._order))
        distances[self._order] = hits.distances
        if not self._lidar.intensity:
            return distances, None
        centres = slice(None, None, len(self._order) // count)
        geoms, facing = hits.geoms[centres], hits.facing[centres]
        return distances, np.where(geoms >= 0, self._brightness[geoms] * facing, 0.0)


def lidar_device(lidar: sensors.Lidar, mounting: Mounting) -> Device:
    """Return the device of a 2-D lidar."""
    return RotatingLidarDevice(lidar, mounting) if lidar.rotating else LidarDevice(lidar, mounting)
