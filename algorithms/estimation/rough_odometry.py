"""Evidence that odometry is rougher than stated, such as with wheels that spin now and then.

A graph has one covariance for each step of odometry. How well it predicts sightings of the map is compared with how
well a robot would do on the same map with rougher odometry.
"""

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import Sighting

from .constant_errors import DECIDED
from .ekf_models import innovation, range_bearing

ROUGH = 9.0
"""Ratio of the variance of rough odometry to that of its data sheet."""
ROUGH_ODDS = 0.1
"""Prior odds of rough odometry against odometry as stated."""
MAX_GAIN = 5.0
"""Maximum evidence from one sighting, which may be wrong."""
MIN_EVIDENCE = -5.0
"""Minimum evidence: wheels that begin to spin after a long drive are noticed."""


class RoughOdometry:
    """Two robots on the map of a graph, one with odometry as stated, the other with rough odometry."""

    def __init__(self) -> None:
        """Start where the map begins."""
        self.evidence = 0.0
        """Logarithm of the Bayes factor of rough odometry against odometry as stated."""
        self._covariances = np.zeros((2, 3, 3))
        self._offsets = np.zeros((2, 3))

    @property
    def odds(self) -> float:
        """Odds of rough odometry."""
        return float(ROUGH_ODDS * np.exp(min(self.evidence, DECIDED)))

    def move(self, F: Array, covariance: Array) -> None:
        """Propagate through a step: Jacobian of the new pose by the old one and the stated covariance, (3, 3) each."""
        added = np.array([1.0, ROUGH])[:, None, None] * covariance
        self._covariances = F @ self._covariances @ F.T + added
        self._offsets = self._offsets @ F.T
        self._offsets[1] -= self._offsets[0]  # The first one is the graph, which has been solved since.
        self._offsets[0] = 0.0

    def see(self, pose: Array, landmark: Array, sighting: Sighting) -> None:
        """Correct both robots by a sighting.

        Args:
            pose: Pose of the robot at the sighting as the graph predicts it, map frame, shape (3,).
            landmark: Position of the landmark in the map, shape (2,) [m].
            sighting: The sighting of it.
        """
        likelihoods = np.zeros(2)
        for row, (offset, P) in enumerate(zip(self._offsets, self._covariances, strict=True)):
            expected, H_pose, _ = range_bearing(pose + offset, landmark[None])
            nu, H = innovation(np.array([[sighting.range, sighting.bearing]]), expected)[0], H_pose[0]
            # A landmark is about as uncertain as a single sighting of it.
            S = H @ P @ H.T + 2.0 * sighting.covariance
            K = np.linalg.solve(S, H @ P).T
            likelihoods[row] = -0.5 * (nu @ np.linalg.solve(S, nu) + np.linalg.slogdet(S)[1])
            self._offsets[row], self._covariances[row] = offset + K @ nu, P - K @ H @ P
        self.evidence = max(self.evidence + min(float(likelihoods[1] - likelihoods[0]), MAX_GAIN), MIN_EVIDENCE)
