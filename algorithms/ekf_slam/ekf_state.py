"""Mean and covariance of pose, constant errors and landmarks, stored together; landmarks have names."""

from collections.abc import Hashable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mjsim.geometry import Array

from ..estimation.ekf_models import Places


class SlamState:
    """One Gaussian: mean (x, y, heading, errors of motion, errors of the sensor, x_1, y_1, ...), joint covariance P."""

    def __init__(self, pose: ArrayLike, covariance: ArrayLike | None, *, parameters: int, sensor: int) -> None:
        """Start without landmarks.

        Args:
            pose: Mean of (x, y, heading), shape (3,) [m, m, rad].
            covariance: Covariance of the pose, shape (3, 3); None for zeros.
            parameters: Number p of constant errors of the motion, initially 0 and certain.
            sensor: Number s of constant errors of the sensor, initially 0 and certain.
        """
        self._sensor = slice(3 + parameters, 3 + parameters + sensor)
        self._common = np.concatenate([np.arange(3), np.arange(self._sensor.start, self._sensor.stop)])
        self._base = self._sensor.stop  # landmarks stand behind all of these
        self._order: dict[Hashable, int] = {}  # name -> where its x stands in the mean
        self._mean, self._P = np.zeros(35), np.zeros((35, 35))
        self._anchor = np.zeros(35)  # where derivatives are taken
        self._sighting_counts = np.zeros(35, dtype=np.intp)  # at each landmark, beside its x
        self._spare = np.empty(35 * 35)
        self._mean[:3] = self._anchor[:3] = pose
        if covariance is not None:
            self._P[:3, :3] = covariance

    @property
    def pose(self) -> Array:
        """Mean of (x, y, heading), shape (3,) [m, m, rad]."""
        return self._mean[:3].copy()

    @property
    def covariance(self) -> Array:
        """Covariance of the pose, shape (3, 3)."""
        return self._P[:3, :3].copy()

    @property
    def parameters(self) -> Array:
        """Mean of the motion's constant errors, shape (p,)."""
        return self._mean[3 : self._sensor.start].copy()

    @property
    def sensor_errors(self) -> tuple[Array, Array]:
        """Mean (s,) and covariance (s, s) of the sensor's constant errors."""
        return self._mean[self._sensor].copy(), self._P[self._sensor, self._sensor].copy()

    @property
    def joint_covariance(self) -> Array:
        """Covariance of the pose, then each landmark in the order of `landmarks`, shape (3 + 2 n, 3 + 2 n)."""
        return self.joint_covariance_of(self.names())

    def joint_covariance_of(self, names: Sequence[Hashable]) -> Array:
        """Return the covariance of the pose and k landmarks together, shape (3 + 2 k, 3 + 2 k)."""
        rows = np.concatenate([np.arange(3), (self._places(names)[:, None] + (0, 1)).ravel()])
        return np.asarray(self._P[np.ix_(rows, rows)])

    def __contains__(self, name: Hashable) -> bool:
        """Return whether this landmark is in the map."""
        return name in self._order

    def landmarks(self, names: Sequence[Hashable] | None = None) -> dict[Hashable, tuple[Array, Array]]:
        """Return mean (2,) [m] and covariance (2, 2) [m^2] of landmarks by name; by default of all, oldest first."""
        return {
            name: (self._mean[at : at + 2].copy(), self._P[at : at + 2, at : at + 2].copy())
            for name in (self._order if names is None else names)
            for at in (self._order[name],)
        }

    def names(self) -> tuple[Hashable, ...]:
        """Return the names of all landmarks, oldest first."""
        return tuple(self._order)

    def positions(self, names: Sequence[Hashable]) -> Array:
        """Return the positions of k landmarks of the map, shape (k, 2) [m]."""
        return np.asarray(self._mean[self._places(names)[:, None] + (0, 1)])

    def remove(self, name: Hashable) -> None:
        """Remove a landmark from the map; its effect on the pose and on other landmarks is kept."""
        rest = np.delete(np.arange(self._size), self._order[name] + np.arange(2))
        at, size = self._order.pop(name), len(rest)
        self._order = {other: row - 2 * (row > at) for other, row in self._order.items()}
        for array in (self._mean, self._anchor, self._sighting_counts):
            array[:size] = array[rest]
        self._P[:size, :size] = self._P[np.ix_(rest, rest)]

    @property
    def _size(self) -> int:
        return self._base + 2 * len(self._order)

    def _places(self, names: Sequence[Hashable]) -> Places:
        return np.array([self._order[name] for name in names], dtype=np.intp)

    def _point_rows(self) -> NDArray[np.intp]:
        """Return the indices of x and y of the position and the landmarks in the state, shape (1 + n, 2)."""
        return np.concatenate([np.arange(2), np.arange(self._base, self._size)]).reshape(-1, 2)

    def shared_rows(self, other: "SlamState") -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return the rows of pose and landmarks in this state, and in another one with the same landmarks."""
        rows = np.concatenate([np.arange(3), np.arange(self._base, self._size)])
        return rows, np.where(rows < 3, rows, rows + other._base - self._base)

    def _grow(self) -> None:
        """Double the capacity for landmarks, so that n landmarks cost O(n^2) copying in total."""
        size, room = len(self._mean), 2 * len(self._mean) + 1
        self._mean, self._anchor, self._sighting_counts = (
            np.concatenate([array, np.zeros(room - size, dtype=array.dtype)])
            for array in (self._mean, self._anchor, self._sighting_counts)
        )
        P = np.zeros((room, room))
        P[:size, :size] = self._P
        self._P = P
        self._spare = np.empty(room * room)
