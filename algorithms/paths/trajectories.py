"""Trajectories: a spline through points, minimum jerk between two states, and the fastest motion along a path."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline

from mjsim.geometry import Array

SAMPLES_PER_METRE = 20
"""Samples of a path per metre when its speed profile is computed."""


class SplinePath:
    """A smooth path through points: a natural cubic spline over the length of the straight lines between them.

    References:
        de Boor, A Practical Guide to Splines (1978), chapter IV.
    """

    def __init__(self, points: ArrayLike) -> None:
        """Fit the spline.

        Args:
            points: At least two, shape (n, 2) [m]; consecutive points differ.
        """
        corners = np.asarray(points, dtype=float)
        steps = np.hypot(*np.diff(corners, axis=0).T)
        if corners.ndim != 2 or corners.shape[1] != 2 or len(corners) < 2 or (steps == 0.0).any():
            raise ValueError(f"points has shape {corners.shape}; give two or more [x, y], consecutive ones different")
        self._spline = CubicSpline(np.concatenate([[0.0], np.cumsum(steps)]), corners, bc_type="natural")
        knots = self._spline.x
        fine = np.linspace(knots[0], knots[-1], 1 + int(np.ceil(knots[-1] * 10 * SAMPLES_PER_METRE)))
        speed = np.hypot(*self._spline(fine, 1).T)
        self._u = fine
        self._s = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(fine))])

    @property
    def length(self) -> float:
        """From end to end along the curve [m]."""
        return float(self._s[-1])

    def at(self, along: ArrayLike) -> Array:
        """Return positions at distances along the curve [m], shape (..., 2) [m]."""
        return np.asarray(self._spline(np.interp(np.asarray(along, dtype=float), self._s, self._u)))

    def heading(self, along: ArrayLike) -> Array:
        """Return the direction of the curve at distances along it [m], shape (...) [rad]."""
        dx, dy = np.moveaxis(self._spline(np.interp(np.asarray(along, dtype=float), self._s, self._u), 1), -1, 0)
        return np.asarray(np.arctan2(dy, dx))

    def curvature(self, along: ArrayLike) -> Array:
        """Return the curvature at distances along the curve [m], left positive, shape (...) [1/m]."""
        u = np.interp(np.asarray(along, dtype=float), self._s, self._u)
        (dx, dy), (ddx, ddy) = (np.moveaxis(self._spline(u, order), -1, 0) for order in (1, 2))
        return np.asarray((dx * ddy - dy * ddx) / (dx**2 + dy**2) ** 1.5)


def minimum_jerk(start: ArrayLike, end: ArrayLike, duration: float) -> np.polynomial.Polynomial:
    """Return the minimum-jerk motion between two states of one coordinate: a polynomial of degree 5 in time.

    Args:
        start: Position, velocity and acceleration at time 0, shape (3,) [m, m/s, m/s^2].
        end: The same at the end, shape (3,).
        duration: Time from start to end [s].

    Returns:
        A polynomial p(t); `p.deriv()` is the velocity.

    References:
        Flash, Hogan, The Coordination of Arm Movements, J. Neuroscience 5(7), 1985, appendix A.
    """
    (p0, v0, a0), (p1, v1, a1) = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    T = duration
    A = np.array([[T**3, T**4, T**5], [3 * T**2, 4 * T**3, 5 * T**4], [6 * T, 12 * T**2, 20 * T**3]])
    b = np.array([p1 - p0 - v0 * T - 0.5 * a0 * T**2, v1 - v0 - a0 * T, a1 - a0])
    return np.polynomial.Polynomial([p0, v0, 0.5 * a0, *np.linalg.solve(A, b)])


@dataclass(frozen=True, slots=True, eq=False)
class SpeedProfile:
    """Speed along a path: distances and the times at which they are reached."""

    along: Array
    """Distance along the path, shape (n,) [m]."""
    times: Array
    """Time at which it is reached, shape (n,) [s]."""
    speeds: Array
    """Speed there, shape (n,) [m/s]."""

    @property
    def duration(self) -> float:
        """From start to end [s]."""
        return float(self.times[-1])

    def speed(self, along: ArrayLike) -> Array:
        """Return the speed at distances along the path [m], shape (...) [m/s]."""
        # Between two points the acceleration is constant: the square of the speed is a straight line.
        return np.asarray(np.sqrt(np.interp(np.asarray(along, dtype=float), self.along, self.speeds**2)))


def fastest_profile(
    path: SplinePath, *, speed: float, turn: float, acceleration: float, turn_acceleration: float
) -> SpeedProfile:
    """Return the fastest motion along a path from rest to rest within a robot's limits.

    Args:
        path: The path.
        speed: Largest speed [m/s].
        turn: Largest turn rate [rad/s].
        acceleration: Largest change of speed [m/s^2].
        turn_acceleration: Largest change of the turn rate [rad/s^2].

    Raises:
        ImportError: toppra is not installed.
        ValueError: The curve is too sharp for the limits.

    References:
        Pham, Pham, A New Approach to Time-Optimal Path Parameterization Based on Reachability Analysis, IEEE T-RO
        34(3), 2018; toppra is its authors' library. The robot's two coordinates are distance and heading.
    """
    try:
        from toppra import SplineInterpolator
        from toppra.algorithm import TOPPRA
        from toppra.constraint import JointAccelerationConstraint, JointVelocityConstraint
    except ImportError:
        raise ImportError("the fastest speeds need toppra, which is not installed; type: pip install toppra") from None

    along = np.linspace(0.0, path.length, max(20, int(path.length * SAMPLES_PER_METRE)) + 1)
    heading = np.unwrap(path.heading(along))
    limits = np.array([[-speed, speed], [-turn, turn]])
    changes = np.array([[-acceleration, acceleration], [-turn_acceleration, turn_acceleration]])
    constraints = [JointVelocityConstraint(limits), JointAccelerationConstraint(changes)]
    geometry = SplineInterpolator(along, np.column_stack([along, heading]))
    solver = TOPPRA(constraints, geometry, gridpoints=along, parametrizer="ParametrizeConstAccel")
    _, speeds, _ = solver.compute_parameterization(0.0, 0.0)
    if speeds is None:
        raise ValueError("no motion along this path is within the limits; its curve is too sharp")
    speeds = np.asarray(speeds, dtype=float)
    # Constant acceleration between grid points: time is distance over the mean speed.
    steps = np.diff(along) / np.maximum(0.5 * (speeds[1:] + speeds[:-1]), 1e-9)
    return SpeedProfile(along, np.concatenate([[0.0], np.cumsum(steps)]), speeds)
