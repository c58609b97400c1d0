"""How consistent a filter is: its normalised error (NEES) on a loop whose true poses are known."""

import numpy as np

from mjsim.algorithms.ekf_slam.ekf_slam import EkfSlamFilter, odometry_motion
from mjsim.algorithms.estimation.ekf_models import range_bearing
from mjsim.geometry import Array, wrap_angles


def ring_nees(slam: EkfSlamFilter, seed: int) -> Array:
    """Return the pose NEES after each update on one loop of 10 m radius among 40 landmarks, poorly seen at first.

    The filter starts at (10, 0) and looks north.
    """
    rng = np.random.default_rng(seed)
    angles = rng.uniform(0, 2 * np.pi, 40)
    places = np.stack([np.cos(angles), np.sin(angles)], axis=1) * rng.uniform(7.0, 13.0, (40, 1))
    motion = odometry_motion()
    Q, noise = np.diag([0.02, 1e-6, np.radians(0.6)]) ** 2, np.diag([0.1, np.radians(3.0)]) ** 2
    truth, nees = slam.pose, []
    step = np.array([0.2, 0.0, 0.02])
    for k in range(314):
        truth = motion(truth, step)[0]
        slam.predict(motion, step + rng.normal(0, np.sqrt(np.diag(Q))), Q)
        if k % 4 == 3:
            z, _, _ = range_bearing(truth, places)
            near = np.flatnonzero(z[:, 0] < 5.0)
            slam.update(near.tolist(), z[near] + rng.normal(0, np.sqrt(np.diag(noise)), (len(near), 2)), noise)
            error = slam.pose - truth
            error[2] = wrap_angles(error[2])
            nees.append(error @ np.linalg.solve(slam.covariance, error))
    return np.array(nees)
