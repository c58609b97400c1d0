"""Radio tags: ranges to anchors, and their errors with and without line of sight."""

import numpy as np
from numpy.typing import NDArray

from mjsim.compile import robot_from_sensor
from mjsim.geometry import Array
from mjsim.interface import AnchorRanges, SensorInfo
from mjsim.sim.rays import HIDDEN, Rays
from mjsim.sim.sensors.device import Mounting
from mjsim.world import sensors

MAX_OCCLUDER_DEPTH = 0.005
"""Objects this close in front of an anchor do not block it: the wall that it is fixed to [m]."""
MIN_DEVIATION = 1e-3
"""Minimum standard deviation in a data sheet [m]."""


class UwbDevice:
    """A tag of a robot in a running simulation; each reading draws the same number of random values, one per anchor.

    A range is the 3-D distance plus a constant error of its anchor, white noise, and, without line of sight, an
    exponentially distributed excess, because the first arriving path is longer.

    References:
        Guvenc and Chong, A Survey on TOA Based Wireless Localization and NLOS Mitigation Techniques, IEEE
        Communications Surveys and Tutorials 11(3), 2009, section II, for noise and positive bias of a range. O'Lone,
        Dhillon, Buehrer, A Mathematical Justification for Exponentially Distributed NLOS Bias, GLOBECOM 2019
        (arXiv:1905.00603), for its distribution.
    """

    def __init__(self, uwb: sensors.Uwb, mounting: Mounting) -> None:
        """Draw the constant errors of the run.

        Args:
            uwb: Tag of the world file.
            mounting: Its mounting; each option has its own random stream.
        """
        model, robot = mounting.model, mounting.robot.name
        self._model, self._data, self._streams = model, mounting.data, mounting.streams
        # A robot knows the distance of its own anchor.
        self._names = [beacon.name for beacon in mounting.beacons if beacon.anchor and beacon.on != robot]
        self._geoms = np.array([model.geom(f"beacon/{name}").id for name in self._names], dtype=int)
        self._rays = Rays(model, mounting.data, robot, capacity=len(self._names))
        self._bias = uwb.bias * mounting.streams("bias").standard_normal(len(self._names))
        self._nearest, self._farthest = uwb.range
        self.retune(uwb)

    def retune(self, uwb: sensors.Uwb) -> None:
        """Use the noise of this model from now on; the constant errors stay."""
        self._uwb, streams = uwb, self._streams
        self._noise = streams("range") if uwb.noise.range else None
        self._missed = streams("missed") if uwb.missed else None
        self._excess = streams("nlos") if uwb.nlos.bias else None
        self._lost = streams("nlos/missed") if uwb.nlos.missed else None

    def info(self) -> SensorInfo:
        """Return its data sheet."""
        uwb = self._uwb
        return SensorInfo(
            kind="uwb",
            robot_from_sensor=robot_from_sensor(uwb.at, yaw_deg=0.0),
            rate_hz=uwb.rate_hz,
            noise={"range": uwb.noise.range, "bias": uwb.bias},
            latency=uwb.latency,
            range=(self._nearest, self._farthest),
        )

    def take(self, stamp: float) -> AnchorRanges:
        """Return the current ranges; `stamp` is the simulated time [s]."""
        distances, in_reach, blocked = self._truth()
        noise, excess, missed, lost = self._chances()
        measured = np.maximum(distances + self._bias + noise + np.where(blocked, excess, 0.0), 0.0)
        received = in_reach & ~missed & ~(blocked & lost)
        return AnchorRanges(
            stamp=stamp,
            ranges={self._names[index]: float(measured[index]) for index in np.flatnonzero(received).tolist()},
            variance=max(self._uwb.noise.range, MIN_DEVIATION) ** 2,
        )

    def pass_over(self) -> None:
        """Draw the random numbers of a reading that was not requested."""
        self._chances()

    def _truth(self) -> tuple[Array, NDArray[np.bool_], NDArray[np.bool_]]:
        """Return for each anchor the distance [m], whether it is in range, and whether it is obstructed, (n,)."""
        place, axes = self._rays.pose()
        start = place + axes @ np.array(self._uwb.at)
        offsets = self._data.geom_xpos[self._geoms] - start
        distances = np.sqrt(np.einsum("ij,ij->i", offsets, offsets))
        inside = (distances >= self._nearest) & (distances <= self._farthest)
        # A removed anchor stays in place, but in an invisible group.
        in_reach = inside & (self._model.geom_group[self._geoms] != HIDDEN)
        blocked = np.zeros(len(distances), dtype=bool)
        candidates = np.flatnonzero(in_reach & (distances > MAX_OCCLUDER_DEPTH))
        if candidates.size:
            far = distances[candidates]
            free = self._rays.cast(start, offsets[candidates] / far[:, None], limit=float(far.max()))
            blocked[candidates] = free < far - MAX_OCCLUDER_DEPTH
        return distances, in_reach, blocked

    def _chances(self) -> tuple[Array, Array, NDArray[np.bool_], NDArray[np.bool_]]:
        """Return noise and NLOS excess [m], and which are missed with and without line of sight, (n,)."""
        uwb, count = self._uwb, len(self._names)
        none, never = np.zeros(count), np.zeros(count, dtype=bool)
        return (
            uwb.noise.range * self._noise.standard_normal(count) if self._noise is not None else none,
            uwb.nlos.bias * self._excess.standard_exponential(count) if self._excess is not None else none,
            self._missed.random(count) < uwb.missed if self._missed is not None else never,
            self._lost.random(count) < uwb.nlos.missed if self._lost is not None else never,
        )
