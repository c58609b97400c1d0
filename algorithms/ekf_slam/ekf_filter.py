"""EKF-SLAM with range and bearing to landmarks of known identity: the mathematics, apart from any robot."""

import math
from collections.abc import Hashable, Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mjsim.geometry import Array, wrap_angle

from ..estimation.ekf_models import (
    MotionModel,
    Places,
    Slopes,
    corrected,
    couple,
    gain,
    innovation,
    landmark_from,
    measured,
    projected,
    range_bearing,
    together,
)
from .ekf_group import shear, turned_left
from .ekf_state import SlamState

Jacobians = Literal["standard", "first-estimates"]
YOUNG, STRAYED = 3, 0.2
"""Up to this many sightings, a first estimate is replaced if the newest one differs by more than this ratio to the
distance of the landmark. Later both move together as loops close, and Jacobians should not follow."""
ITERATIONS, STILL = 10, 1e-3
"""Maximum number of iterations, and change of the pose at convergence [m, rad]."""


class EkfSlamFilter(SlamState):
    """The pose and all landmarks in one Gaussian: mean (x, y, heading, x_1, y_1, ...), joint covariance P.

    A robot that only sees landmarks relative to itself cannot observe the origin and orientation of the world. The
    standard filter evaluates each Jacobian at the newest estimate; as estimates move, the Jacobians of one landmark at
    different times become inconsistent, and the filter gains spurious information about its heading: it becomes
    overconfident. With first-estimates Jacobians, every Jacobian is evaluated at the first estimate of the pose (before
    its update) and of the landmark (when it was added), so that unobservable directions stay unobservable. A first
    estimate that later sightings show to have been poor is replaced.

    References:
        Thrun, Burgard, Fox, Probabilistic Robotics (2005), table 10.1.
        Huang, Mourikis, Roumeliotis, Observability-based Rules for Designing Consistent EKF SLAM Estimators,
        IJRR 29(5), 2010, section 5.1: first-estimates Jacobians.
    """

    def __init__(
        self,
        *,
        jacobians: Jacobians = "standard",
        pose: ArrayLike = (0.0, 0.0, 0.0),
        covariance: ArrayLike | None = None,
        parameters: int = 0,
        sensor: int = 0,
        renew: float = math.inf,
        far: float = math.inf,
    ) -> None:
        """Start without landmarks.

        Args:
            jacobians: Where Jacobians are evaluated: at the newest estimates or at the first ones.
            pose: Mean of (x, y, heading), shape (3,) [m, m, rad].
            covariance: Covariance of the pose (3, 3); None for zeros, which makes the start the origin of the map.
            parameters: Number p of systematic errors of the motion, estimated too; initially 0 and certain.
            sensor: Number s of systematic errors of sightings, 2, 3 or 0, as in `measured`; also initially 0.
            renew: A first estimate is replaced if the newest one differs by more than this ratio to the distance of
                the landmark: its Jacobians no longer describe the measurement.
            far: A correction is iterated if it turns the robot by more than this [rad], or moves the robot or a visible
                landmark by more than this ratio to the distance between them: Jacobians from before do not hold
                after it.
        """
        if jacobians not in ("standard", "first-estimates"):
            raise ValueError(f"jacobians is {jacobians!r}; it must be 'standard' or 'first-estimates'")
        super().__init__(pose, covariance, parameters=parameters, sensor=sensor)
        self._first = jacobians == "first-estimates"
        self._renewed_at, self._far = renew, far

    def predict(
        self,
        motion: MotionModel,
        control: ArrayLike,
        control_covariance: ArrayLike,
        *,
        slopes: ArrayLike | None = None,
        wander: ArrayLike | None = None,
    ) -> None:
        """Move the pose.

        Args:
            motion: motion(pose, control) -> new pose (3,), F (3, 3), G (3, m). The displacement must not depend on the
                world's origin, as with any motion in the robot's frame.
            control: Shape (m,).
            control_covariance: Shape (m, m).
            slopes: Derivative of the control by the systematic errors, shape (m, p): control + slopes @ errors acts.
            wander: Growth of the variances of the systematic errors, shape (p,); by default none.

        References:
            Probabilistic Robotics, table 10.1 lines 2 to 5. First estimates: F depends on the pose by the
            displacement alone, so F from the first estimate differs by what the last update has moved
            (Huang et al. 2010, equation 42).
        """
        old, P, size, base = self._mean[:3], self._P, self._size, self._sensor.start
        control = np.asarray(control, dtype=float)
        if slopes is not None:
            control = control + np.asarray(slopes) @ self._mean[3:base]
        new, F, G = motion(old.copy(), control)
        if self._first:
            F = F.copy()
            F[0, 2] -= old[1] - self._anchor[1]
            F[1, 2] += old[0] - self._anchor[0]
        P[:3, :3] = F @ P[:3, :3] @ F.T + G @ np.asarray(control_covariance, dtype=float) @ G.T
        P[:3, 3:size] = F @ P[:3, 3:size]
        if slopes is not None:
            couple(P[:size, :size], G @ np.asarray(slopes))
        if wander is not None:
            P[range(3, base), range(3, base)] += np.asarray(wander, dtype=float)
        P[3:size, :3] = P[:3, 3:size].T
        self._mean[:3] = self._anchor[:3] = new

    def expect(self, names: Sequence[Hashable]) -> tuple[Array, Array]:
        """Return the expected measurements of landmarks in the map, individually.

        Args:
            names: k landmarks that are in the map.

        Returns:
            z: Range [m] and bearing [rad, left positive], shape (k, 2).
            C: Its covariance from the belief, H P H^T without that of a measurement, shape (k, 2, 2).
        """
        places = self._places(names)
        z, slopes = self._expect(places)
        columns = np.concatenate([np.tile(self._common, (len(places), 1)), places[:, None] + (0, 1)], axis=1)
        P = self._P[columns[:, :, None], columns[:, None, :]]
        H = np.concatenate([slopes.pose, slopes.sensor, slopes.landmark], axis=2)
        return z, H @ P @ H.transpose(0, 2, 1)

    def expect_together(self, names: Sequence[Hashable]) -> Array:
        """Return the joint covariance of the expected measurements of k landmarks, H P H^T, shape (2 k, 2 k)."""
        places = self._places(names)
        _, H = self._expect(places)
        return projected(self._P[: self._size, : self._size], places, H, self._sensor)[1]

    def innovations(
        self, names: Sequence[Hashable], measurements: ArrayLike, measurement_covariance: ArrayLike
    ) -> tuple[Array, Array]:
        """Return the innovations of sightings of landmarks in the map, individually.

        Args:
            names: k landmarks that are in the map.
            measurements: Range [m] and bearing [rad, left positive], shape (k, 2).
            measurement_covariance: Covariance of each (k, 2, 2), or one for all (2, 2).

        Returns:
            nu: Innovations, shape (k, 2) [m, rad].
            S: Their covariances, shape (k, 2, 2).
        """
        z, C = self.expect(names)
        nu = innovation(np.asarray(measurements, dtype=float).reshape(-1, 2), z)
        return nu, C + np.asarray(measurement_covariance, dtype=float)

    def update(self, names: Sequence[Hashable], measurements: ArrayLike, measurement_covariance: ArrayLike) -> float:
        """Correct by simultaneous sightings, all at once; then add the new landmarks.

        Args:
            names: k landmarks.
            measurements: Range [m] and bearing [rad, left positive], shape (k, 2).
            measurement_covariance: Covariance of each (k, 2, 2), one for all (2, 2), or the joint one (2 k, 2 k) if
                errors are correlated.

        Returns:
            Logarithm of the likelihood of the sightings of landmarks that were known, less a constant for each.
        """
        Z = np.asarray(measurements, dtype=float).reshape(-1, 2)
        if len(names) != len(Z):
            raise ValueError(f"{len(names)} names for {len(Z)} measurements; give one name per measurement")
        R = together(np.asarray(measurement_covariance, dtype=float), len(Z))
        known = [i for i, name in enumerate(names) if name in self._order]
        new = [i for i, name in enumerate(names) if name not in self._order and name not in names[:i]]
        again = sorted(set(range(len(Z))).difference(known, new))  # seen twice in their first batch
        likelihood = 0.0
        if known:
            likelihood = self._correct(self._places([names[i] for i in known]), Z[known], R[known][:, :, known])
        for i in new:
            self._add(names[i], Z[i], R[i, :, i])
        if again:
            self._correct(self._places([names[i] for i in again]), Z[again], R[again][:, :, again])
        return likelihood

    def unite(self, kept: Hashable, gone: Hashable, variance: float) -> None:
        """Merge two landmarks: correct by the constraint that they are at one place, and remove the second.

        The constraint has a variance in each direction [m^2], because of errors of sightings.
        """
        at, other = self._order[kept] + np.arange(2), self._order[gone] + np.arange(2)
        HP = self._P[at, : self._size] - self._P[other, : self._size]
        S = HP[:, at] - HP[:, other] + variance * np.eye(2)
        self._apply(*gain(HP, S, self._mean[other] - self._mean[at])[:2])
        self.remove(gone)

    def mark(self, name: Hashable) -> None:
        """Add the robot's position as a point that is never seen: later corrections of the past move it."""
        self._append(
            name, self._mean[:2].copy(), self._anchor[:2].copy(), np.zeros((2, 2)), np.zeros((2, len(self._common) - 3))
        )

    def relocate(self, pose: ArrayLike, covariance: ArrayLike) -> None:
        """Move the robot elsewhere on its map: its pose information is discarded, and first estimates are reset.

        Args:
            pose: Mean of (x, y, heading), shape (3,) [m, m, rad].
            covariance: Covariance of the pose, shape (3, 3); it is independent of the map.
        """
        size = self._size
        if self._first:
            self._reanchor(self._point_rows())
        self._mean[:3] = pose
        self._anchor[:size] = self._mean[:size]
        self._P[:3, :size], self._P[:size, :3] = 0.0, 0.0
        self._P[:3, :3] = covariance

    def assume(self, variances: ArrayLike) -> None:
        """Add variances to those of the first errors of the sensor, before the first landmark."""
        rows = range(self._sensor.start, self._sensor.start + len(np.asarray(variances)))
        self._P[rows, rows] += np.asarray(variances, dtype=float)

    def constrain(self, variances: ArrayLike) -> None:
        """Correct by a measurement that the sensor's errors are zero, with variances (s,)."""
        HP = self._P[self._sensor, : self._size]
        S = HP[:, self._sensor] + np.diag(np.asarray(variances, dtype=float))
        self._apply(*gain(HP, S, -self._mean[self._sensor])[:2])

    def _expect(self, places: Places) -> tuple[Array, Slopes]:
        """Return expected measurements (k, 2) and their derivatives."""
        columns = places[:, None] + (0, 1)
        expected, H_pose, H_landmark = range_bearing(self._mean[:3], self._mean[columns])
        if self._first:
            _, H_pose, H_landmark = range_bearing(self._anchor[:3], self._anchor[columns])
        return measured(expected, H_pose, H_landmark, self._mean[self._sensor])

    def _correct(self, places: Places, Z: Array, R: Array) -> float:
        """Update mean and covariance: P - K S K^T as P - W^T W with S = L L^T and W = L^-1 H P; return the likelihood.

        Each row of H has five nonzero columns, so H P costs O(n k) and the whole O(n^2 k). W^T W is symmetric
        to the last bit, and so stays P.
        """
        expected, H = self._expect(places)
        step, W, likelihood = self._gained(places, H, innovation(Z, expected), R)
        if self._is_far(step, places):
            step, W = self._iterated(places, Z, R, step, W)
        self._apply(step, W)
        if self._first:
            self._renew(places)
        return likelihood

    def _gained(self, places: Places, H: Slopes, nu: Array, R: Array) -> tuple[Array, Array, float]:
        """Return what `gain` does: the step K nu, shape (m,), W, shape (2 k, m), and the log-likelihood."""
        HP, C = projected(self._P[: self._size, : self._size], places, H, self._sensor)
        return gain(HP, C + R.reshape(C.shape), nu.ravel())

    def _is_far(self, step: Array, places: Places) -> bool:
        """Return whether derivatives from before a step are invalid after it."""
        if abs(step.item(2)) > self._far:
            return True
        columns = places[:, None] + (0, 1)
        moved, before = step[columns] - step[:2], self._mean[columns] - self._mean[:2]
        return bool(np.any((moved * moved).sum(axis=1) > self._far**2 * (before * before).sum(axis=1)))

    def _iterated(self, places: Places, Z: Array, R: Array, step: Array, W: Array) -> tuple[Array, Array]:
        """Return step and W with derivatives at the result of the step; the given ones without convergence.

        References:
            Bell, Cathey, The Iterated Kalman Filter Update as a Gauss-Newton Method, IEEE TAC 38(2), 1993, equation 21.
        """
        columns, plain = places[:, None] + (0, 1), (step, W)
        for _ in range(ITERATIONS):
            mean = self._moved(step)
            expected, H = measured(*range_bearing(mean[:3], mean[columns]), mean[self._sensor])
            by_pose, by_landmark = self._by_step(H.pose, H.landmark, step, columns)
            nu = innovation(Z, expected) + by_pose @ step[:3] + np.einsum("kij,kj->ki", by_landmark, step[columns])
            nu += H.sensor @ step[self._sensor]
            before = step[:3]
            step, W, _ = self._gained(places, Slopes(by_pose, by_landmark, H.sensor), nu, R)
            if np.abs(step[:3] - before).max() < STILL:
                return step, W
        return plain

    def _moved(self, step: Array) -> Array:
        """Return the mean after a step, shape (m,)."""
        return np.asarray(self._mean[: self._size] + step)

    def _by_step(self, H_pose: Array, H_landmark: Array, step: Array, columns: NDArray[np.intp]) -> tuple[Array, Array]:
        """Return derivatives by the step, (k, 2, 3) and (k, 2, 2), from those by pose and landmark."""
        return H_pose, H_landmark

    def _renew(self, places: Places) -> None:
        """Replace first estimates by the newest ones for landmarks that differ too much."""
        counts = self._sighting_counts[places] + 1
        self._sighting_counts[places] = counts
        columns = places[:, None] + (0, 1)
        strayed_by = np.hypot(*(self._mean[columns] - self._anchor[columns]).T)
        limits = np.where(counts <= YOUNG, STRAYED, self._renewed_at)
        strayed = columns[strayed_by > limits * np.hypot(*(self._mean[columns] - self._mean[:2]).T)]
        if len(strayed):
            self._reanchor(strayed)

    def _reanchor(self, rows: NDArray[np.intp]) -> None:
        """Set the first estimates of points (n, 2) to the newest ones.

        A rotation of everything by the heading's error moves a point about the origin, from its first estimate. From
        another one it moves it elsewhere: without this change of P the filter would gain information about its heading.
        """
        size, moved = self._size, turned_left(self._mean[rows] - self._anchor[rows])
        shear(self._P[:size, :size], moved, rows, np.zeros((0, size)), self._spare)
        self._anchor[rows] = self._mean[rows]

    def _apply(self, step: Array, W: Array) -> None:
        """Correct the mean by a step, shape (m,), and subtract W^T W from P, W of shape (k, m)."""
        size = self._size
        self._mean[:size] += step
        self._mean[2] = wrap_angle(self._mean[2])
        loss = self._spare[: size * size].reshape(size, size)
        self._P[:size, :size] -= np.matmul(W.T, W, out=loss)

    def _add(self, name: Hashable, z: Array, R: Array) -> None:
        """Add a landmark at its first sighting.

        With landmark = position + turned(range, bearing), its error is J_pose times the error of the pose plus J
        times that of the measurement (Probabilistic Robotics, section 10.2.2, without its infinite variance), and those
        of the sensor's errors.
        """
        true, J_sighting, J_sensor = corrected(z, self._mean[self._sensor])
        landmark, J = landmark_from(self._mean[:3], true)
        J_sighting = J @ J_sighting
        self._append(name, landmark, landmark, J_sighting @ R @ J_sighting.T, J @ J_sensor)

    def _append(self, name: Hashable, mean: Array, anchor: Array, noise: Array, J_sensor: Array) -> None:
        """Write mean and covariance of a new point behind the others.

        It moves rigidly with the robot, apart from its noise and the errors of the sensor times J_sensor (2, s).
        """
        at, size = self._size, self._size + 2
        if size > len(self._mean):
            self._grow()
        P = self._P
        from_x, from_y = anchor - self._anchor[:2] if self._first else mean - self._mean[:2]
        J = np.hstack([np.array([[1.0, 0.0, -from_y], [0.0, 1.0, from_x]]), J_sensor])
        P[at:size, :at] = J @ P[self._common, :at]
        P[:at, at:size] = P[at:size, :at].T
        own = J @ P[self._common[:, None], self._common] @ J.T + noise
        P[at:size, at:size] = 0.5 * (own + own.T)
        self._mean[at:size], self._anchor[at:size] = mean, anchor
        self._sighting_counts[at], self._order[name] = 1, at
