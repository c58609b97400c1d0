"""Odometry from scans, for robots and hand-held lidars without odometry of their own.

A log without odometry, such as those of hand-held or flying lidars, has an unknown motion in each tick: its
increments are zero, with a large covariance.
"""

from collections import deque

import numpy as np

from mjsim.geometry import Array, wrap_angle
from mjsim.interface import Observation, Odometry

from ..estimation.pose_graph import compose, step_between
from ..estimation.pose_matrices import inverse
from .level_scan import LevelScan
from .scan_matching import Match, WallField
from .scan_search import FEWEST, covariance_of, hypotheses
from .scan_walls import Surface, placed, rotation

UNKNOWN = 0.25
"""Odometry whose variance grows faster than this is ignored [m^2/s]; that of wheels at 3 m/s grows by 0.01."""
SPEED = np.array([0.5, 0.2, 0.7])
"""Standard deviation of the velocity forward, to the left and about z [m/s, m/s, rad/s]."""
LASTING = 1.5
"""Time constant of the velocity [s]."""
JITTER = 0.4
"""Standard deviation of the stamps of scans, relative to the time between them: logs often have the time of arrival."""
GYROSCOPE = 0.05
"""Standard deviation of the turn rate by a gyroscope with its bias [rad/s]."""
FLOOR = np.array([0.01, 0.01, 0.004])
"""Constant part of the standard deviation of a predicted step [m, m, rad]."""
REFERENCES = 4
"""Number of earlier scans whose walls a new one is matched to."""
SPACING = np.array([0.3, 0.25])
"""Distance [m] and turn [rad] after which a scan becomes a reference; the robot does not drift while it stands."""


SHARE = 0.4
"""Minimum ratio of a scan's walls on earlier ones for a match."""
NARROWEST, WIDEST = np.array([0.05, 0.05, 0.03]), np.array([0.6, 0.6, 0.5])
"""Smallest and largest search window around the prediction [m, m, rad]."""


class ScanOdometry:
    """Motion from consecutive scans: each is matched to earlier ones, near where its velocity predicts it.

    A Kalman filter estimates the velocity, which is constant but for random accelerations and decays slowly. The turn
    is predicted by the gyroscope if there is an inertial sensor. Along a bare
    corridor, where walls do not constrain it, the velocity lasts for some seconds.

    References:
        Singer, Estimating Optimal Tracking Filter Performance for Manned Maneuvering Targets, IEEE Transactions on
        Aerospace and Electronic Systems 6, 1970 (without the state of acceleration).
    """

    def __init__(self) -> None:
        """Start at rest."""
        self._references: deque[tuple[Array, Surface]] = deque(maxlen=REFERENCES)
        self._pose, self._velocity = np.zeros(3), np.zeros(3)
        self._P = np.zeros((6, 6))  # Covariance of pose and velocity, in the robot's frame.
        self._stamp = -np.inf
        self._reported = np.zeros(3)
        self._usual = 0.0
        self._turned, self._has_gyroscope = 0.0, False

    @staticmethod
    def is_needed(seen: Observation) -> bool:
        """Return whether the odometry of a tick has no information about the motion."""
        return bool(seen.odometry.covariance[0, 0] > UNKNOWN * seen.dt)

    def update(self, seen: Observation, level_scan: LevelScan | None, walls: Surface | None) -> Odometry:
        """Return the motion since the last tick; call it at every tick.

        Args:
            seen: Observation of this tick; its odometry is not used.
            level_scan: The scan of this tick, if there is one.
            walls: Its walls, in the robot's frame (`walls_of`).
        """
        rates = [float(reading.turn[2]) for reading in seen.imu if np.isfinite(reading.turn[2])]
        if rates:
            self._has_gyroscope = True
            self._turned += float(np.mean(rates)) * seen.dt
        covariance = np.diag((SPEED * seen.dt) ** 2) * 0.01
        if level_scan is not None and walls is not None:
            self._match(level_scan.scan.stamp, walls)
            covariance = covariance + self._P[:3, :3]
        ahead = 0.0 if not self._references else seen.moment - self._stamp
        pose = compose(self._pose, self._velocity * ahead)
        forward, left, turn = step_between(self._reported, pose).tolist()
        self._reported = pose
        return Odometry(forward, left, wrap_angle(turn), covariance)

    def _match(self, stamp: float, surface: Surface) -> None:
        """Move to where the walls in a scan fit those in earlier ones."""
        since, self._stamp = stamp - self._stamp, stamp
        if not self._references:
            self._references.append((self._pose, surface))
            self._P[3:, 3:] = np.diag(SPEED**2)
            return
        self._predict(since)
        origin, _ = self._references[-1]
        guess = step_between(origin, self._pose)
        R = np.eye(3)
        R[:2, :2] = rotation(float(guess[2]))
        found = _found(surface, self._walls(origin), guess, R @ self._P[:3, :3] @ R.T)
        if found:
            correction = found[0].pose - guess
            correction[2] = wrap_angle(float(correction[2]))
            self._pose = compose(origin, found[0].pose)
            self._correct(R.T @ correction, R.T @ covariance_of(found) @ R)
        step = step_between(origin, self._pose)
        if not found or np.hypot(*step[:2]) > SPACING[0] or abs(step[2]) > SPACING[1]:
            self._references.append((self._pose, surface))

    def _predict(self, since: float) -> None:
        """Move by the velocity for some time [s]."""
        decay = np.exp(-since / LASTING)
        mean = LASTING * (1.0 - decay)
        step = self._velocity * mean
        self._usual = since if self._usual == 0.0 else 0.9 * self._usual + 0.1 * min(since, 4.0 * self._usual)
        unsure = JITTER * self._usual * (np.abs(self._velocity) + 0.3 * SPEED)
        turned, self._turned = self._turned, 0.0
        if self._has_gyroscope:
            step[2] = turned
        self._pose, self._velocity = compose(self._pose, step), decay * self._velocity
        F = np.eye(6)
        F[:2, :2] = rotation(-float(step[2]))
        F[:3, 3:], F[3:, 3:] = mean * np.eye(3), decay * np.eye(3)
        # Random accelerations, integrated over the time.
        over = 2.0 * since / LASTING - 3.0 + 4.0 * decay - decay**2
        Q = np.zeros((6, 6))
        Q[:3, :3] = np.diag((SPEED * LASTING) ** 2 * over + FLOOR**2 + unsure**2)
        Q[:3, 3:] = Q[3:, :3] = np.diag(SPEED**2 * LASTING * (1.0 - decay) ** 2)
        Q[3:, 3:] = np.diag(SPEED**2 * (1.0 - decay**2))
        before = self._P[2, 2]
        self._P = F @ self._P @ F.T + Q
        if self._has_gyroscope:
            self._P[2, :], self._P[:, 2] = 0.0, 0.0
            self._P[2, 2] = before + FLOOR[2] ** 2 + (GYROSCOPE * since) ** 2

    def _correct(self, correction: Array, covariance: Array) -> None:
        """Correct the velocity after a match has corrected the predicted pose and left it with a covariance."""
        prior = self._P[:3, :3]
        gain = self._P[3:, :3] @ inverse(prior)
        self._velocity = self._velocity + gain @ correction
        self._P[3:, 3:] -= gain @ (prior - covariance) @ gain.T
        self._P[3:, :3] = gain @ covariance
        self._P[:3, 3:] = self._P[3:, :3].T
        self._P[:3, :3] = covariance

    def _walls(self, origin: Array) -> Surface:
        """Return the walls of the references in the frame of a pose (3,)."""
        poses = np.array([pose for pose, _ in self._references])
        return placed([surface for _, surface in self._references], step_between(origin, poses))


def _found(scan: Surface, walls: Surface, guess: Array, covariance: Array) -> list[Match]:
    """Return the matches of a scan to walls near a guess (3,) with a covariance (3, 3), the best first; or none."""
    if len(walls.points) < FEWEST or len(scan.points) < FEWEST:
        return []
    window = np.clip(3.0 * np.sqrt(np.diag(covariance)), NARROWEST, WIDEST)
    found = hypotheses(WallField(walls), scan, guess, inverse(covariance), window)
    return found if found[0].share > SHARE else []
