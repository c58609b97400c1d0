"""Statistics of innovations that prove that a robot has moved in a way that neither odometry nor its noise explains.

Wheels that spin, or a push of a few decimetres, displace a robot by less than what makes it lost: each sighting stays
near the gate, and a filter that is sure of its pose follows slowly, with a covariance that does not know of it. But the
squared innovations of two seconds add up to what chance never gives. Then the covariance of the pose grows by their
excess.

References:
    Mehra, On the Identification of Variances and Adaptive Kalman Filtering, IEEE TAC 15(2), 1970: the sequence of
    innovations tells whether a filter is right. Zhou, Frank, Strong Tracking Filtering of Nonlinear Time-Varying
    Stochastic Systems, Int. J. of Control 65(2), 1996: the covariance is enlarged until it explains them.
"""

import math
from collections import deque
from collections.abc import Sequence

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import Sighting

WINDOW = 2.0
"""Time over which innovations are added [s]."""
MIN_LOOKS = 2
"""Least number of looks in it: the sightings of one share the tilt of the robot."""
IMPROBABLE = 4.26
"""Standard deviations of a normal distribution beyond which nothing happens by chance: 1 in 100,000."""
MAX_DISTANCE, MAX_TURN = 1.0, 0.5
"""Displacements beyond these are left to relocation [m, rad]."""


class Misfit:
    """Adds squared innovations of named sightings."""

    def __init__(self) -> None:
        """Start with nothing seen."""
        self._rows: deque[tuple[float, ...]] = deque()

    def excess(self, time: float, sightings: Sequence[Sighting], nu: Array, S: Array, *, gate: float) -> Array | None:
        """Return variances of x, y [m^2] and heading [rad^2] that the innovations of two seconds prove; else None.

        Args:
            time: Current time [s].
            sightings: Of one look.
            nu: Their innovations, shape (k, 2) [m, rad].
            S: Covariances of these, shape (k, 2, 2).
            gate: Squared Mahalanobis distance above which a sighting may be wrong. Such are left out if there are fewer
                of them than of others.
        """
        while self._rows and self._rows[0][0] < time - WINDOW:
            self._rows.popleft()
        squared = np.einsum("ki,ki->k", nu, np.linalg.solve(S, nu[..., None])[..., 0])
        for each, off, covariance, distance in zip(sightings, nu.tolist(), S, squared.tolist(), strict=True):
            # Displacements across and along the line of sight, less what is expected.
            turned, moved = off[1] ** 2 - covariance[1, 1], off[0] ** 2 - covariance[0, 0]
            self._rows.append((time, min(distance, gate), float(moved + each.range**2 * turned), float(turned)))
        times, distances, moved, turned = np.array(self._rows).T
        counted = distances < gate
        if 2 * counted.sum() < len(counted):
            counted[:] = True
        if len(set(times[counted])) < MIN_LOOKS or distances[counted].sum() < improbable(2 * int(counted.sum())):
            return None
        position, heading = max(0.5 * float(moved[counted].mean()), 0.0), max(float(turned[counted].mean()), 0.0)
        if position > MAX_DISTANCE**2 or heading > MAX_TURN**2:
            return None
        self._rows.clear()
        return np.array([position, position, heading])


def improbable(freedom: int) -> float:
    """Return the value that chi-square with so many degrees of freedom never exceeds (Wilson and Hilferty, 1931)."""
    part = 2.0 / (9.0 * freedom)
    return freedom * (1.0 - part + IMPROBABLE * math.sqrt(part)) ** 3
