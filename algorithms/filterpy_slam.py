"""Example of using your own filter: a short EKF-SLAM with filterpy's ExtendedKalmanFilter.

The filter is dense and standard; `ekf_slam` is faster and stays consistent. Copy this file beside your world, put
your own filter in, and name it there: `estimator: {use: "filterpy_slam.py:FilterpySlam"}`.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter
from numpy.random import Generator

from mjsim.geometry import Array, Pose, wrap_angle
from mjsim.interface import BeaconInfo, Estimate, Observation, RobotInfo, Sighting

from .estimation.ekf_models import landmark_from, odometry_motion, range_bearing


class FilterpySlam:
    """Estimates the pose and a map of named beacons.

    References:
        Thrun, Burgard, Fox, Probabilistic Robotics (2005), table 10.1.
    """

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: Generator) -> None:
        """Begin at the robot's prior with an empty map."""
        self._names: list[str] = []
        self._filter: Any = ExtendedKalmanFilter(dim_x=3, dim_z=2)
        self._filter.x = robot.prior.as_array()
        self._filter.P = np.array(robot.prior_covariance, dtype=float)
        self._motion = odometry_motion()

    def update(self, seen: Observation) -> Estimate:
        """Return the belief after this tick's odometry and sightings."""
        self._predict(seen)
        for sighting in seen.sightings:
            if sighting.name is None:
                continue
            if sighting.name not in self._names:
                self._add(sighting)
            else:
                self._correct(sighting)
        # Rounding makes the covariance asymmetric, and each precise sighting amplifies the asymmetry.
        self._filter.P = 0.5 * (self._filter.P + self._filter.P.T)
        x, P = self._filter.x, self._filter.P
        places = {name: slice(3 + 2 * i, 5 + 2 * i) for i, name in enumerate(self._names)}
        return Estimate(
            pose=Pose.from_array(x[:3]),
            covariance=P[:3, :3].copy(),
            landmarks={name: (x[place].copy(), P[place, place].copy()) for name, place in places.items()},
        )

    def _predict(self, seen: Observation) -> None:
        """Move the robot; landmarks stay."""
        moved, ekf = seen.odometry, self._filter
        pose, F, G = self._motion(ekf.x[:3], np.array([moved.forward, moved.left, moved.turn]))
        ekf.x[:3] = pose
        ekf.P[:3, 3:] = F @ ekf.P[:3, 3:]
        ekf.P[3:, :3] = ekf.P[:3, 3:].T
        ekf.P[:3, :3] = F @ ekf.P[:3, :3] @ F.T + G @ moved.covariance @ G.T

    def _correct(self, sighting: Sighting) -> None:
        place = slice(3 + 2 * self._names.index(sighting.name or ""), None)

        def jacobian(x: Array) -> Array:
            _, H_pose, H_landmark = range_bearing(x[:3], x[place][None, :2])
            H = np.zeros((2, len(x)))
            H[:, :3], H[:, place][:, :2] = H_pose[0], H_landmark[0]
            return H

        self._filter.update(
            np.array([sighting.range, sighting.bearing]),
            HJacobian=jacobian,
            Hx=lambda x: range_bearing(x[:3], x[place][None, :2])[0][0],
            R=sighting.covariance,
            residual=_difference,
        )
        self._filter.x[2] = wrap_angle(self._filter.x[2])

    def _add(self, sighting: Sighting) -> None:
        """Add a beacon to the map: state and covariance grow by two."""
        ekf, size = self._filter, len(self._filter.x)
        landmark, J = landmark_from(ekf.x[:3], np.array([sighting.range, sighting.bearing]))
        dx, dy = landmark - ekf.x[:2]
        by_pose = np.array([[1.0, 0.0, -dy], [0.0, 1.0, dx]])
        grown: Any = ExtendedKalmanFilter(dim_x=size + 2, dim_z=2)
        grown.x, grown.P = np.append(ekf.x, landmark), np.zeros((size + 2, size + 2))
        grown.P[:size, :size] = ekf.P
        grown.P[size:, :size] = by_pose @ ekf.P[:3]
        grown.P[:size, size:] = grown.P[size:, :size].T
        grown.P[size:, size:] = by_pose @ ekf.P[:3, :3] @ by_pose.T + J @ sighting.covariance @ J.T
        self._filter = grown
        self._names.append(sighting.name or "")


def _difference(one: Array, other: Array) -> Array:
    """Return one measurement less another, the bearing in [-pi, pi)."""
    return np.array([one[0] - other[0], wrap_angle(float(one[1] - other[1]))])
