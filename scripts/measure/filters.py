"""Print how long the EKF-SLAM filters take by the size of the map, with filterpy's dense EKF beside them.

    python scripts/measure/filters.py [--runs 60]

One BLAS thread. The time is that of the processor, so that other programs disturb it less; least and median of a run.
An update has 10 sightings. filterpy takes them one after the other and has no way to move the pose alone.
"""

import argparse
import time
from collections.abc import Callable, Iterator

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter
from threadpoolctl import threadpool_limits

from mjsim.algorithms.ekf_models import odometry_motion, range_bearing
from mjsim.algorithms.ekf_slam import EkfSlamFilter, InvariantEkfSlamFilter
from mjsim.geometry import wrap_angles

R = np.diag([0.05, np.radians(1.0)]) ** 2
SIZES = (10, 100, 200, 1000)
SEEN = 10


def places(landmarks: int) -> np.ndarray:
    """Return landmarks around the origin, shape (n, 2) [m]."""
    return np.random.default_rng(0).uniform(-10.0, 10.0, (landmarks, 2))


def ours(slam: EkfSlamFilter, landmarks: int) -> tuple[Callable[[], None], Callable[[], None]]:
    """Return a prediction and an update of one of our filters."""
    Z, motion, rng = range_bearing(np.zeros(3), places(landmarks))[0], odometry_motion(), np.random.default_rng(1)
    slam.update(range(landmarks), Z, R)

    def update() -> None:
        seen = rng.choice(landmarks, SEEN, replace=False)
        slam.update(seen.tolist(), Z[seen], R)

    return lambda: slam.predict(motion, (0.0, 0.0, 0.0), 1e-6 * np.eye(3)), update


def dense(landmarks: int) -> tuple[Callable[[], None], Callable[[], None]]:
    """Return a prediction and an update of filterpy's EKF with the whole state in it."""
    hung, rng = places(landmarks), np.random.default_rng(1)
    size = 3 + 2 * landmarks
    ekf = ExtendedKalmanFilter(dim_x=size, dim_z=2)
    ekf.x, ekf.P, ekf.R = np.concatenate([np.zeros(3), hung.ravel()]), 0.01 * np.eye(size), R
    ekf.Q = np.zeros((size, size))
    ekf.Q[:3, :3] = 1e-6 * np.eye(3)

    def residual(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.array([a[0] - b[0], wrap_angles(a[1] - b[1])])

    def update() -> None:
        for k in rng.choice(landmarks, SEEN, replace=False).tolist():
            at = 3 + 2 * k

            def slope(x: np.ndarray, at: int = at) -> np.ndarray:
                _, H_pose, H_landmark = range_bearing(x[:3], x[None, at : at + 2])
                H = np.zeros((2, size))
                H[:, :3], H[:, at : at + 2] = H_pose[0], H_landmark[0]
                return H

            def expected(x: np.ndarray, at: int = at) -> np.ndarray:
                return np.asarray(range_bearing(x[:3], x[None, at : at + 2])[0][0])

            ekf.update(range_bearing(np.zeros(3), hung[[k]])[0][0], slope, expected, residual=residual)

    return ekf.predict, update


def processor_ms(step: Callable[[], None], runs: int) -> tuple[float, float]:
    """Return least and median time of a step on the processor [ms]."""
    step()
    times = []
    for _ in range(runs):
        began = time.process_time()
        step()
        times.append(1e3 * (time.process_time() - began))
    return min(times), float(np.median(times))


def rows(runs: int) -> Iterator[str]:
    """Yield the table, a line for each filter and size."""
    yield "| filter | landmarks | predict, least and median [ms] | update with 10 sightings [ms] |"
    yield "|---|---|---|---|"
    for landmarks in SIZES:
        filters = {
            "`standard`": ours(EkfSlamFilter(), landmarks),
            "`first-estimates`": ours(EkfSlamFilter(jacobians="first-estimates"), landmarks),
            "`invariant`": ours(InvariantEkfSlamFilter(), landmarks),
            "filterpy, dense": dense(landmarks),
        }
        for name, (predict, update) in filters.items():
            count = max(runs // 20, 3) if name.startswith("filterpy") and landmarks == SIZES[-1] else runs
            (p, p_mid), (u, u_mid) = processor_ms(predict, count), processor_ms(update, count)
            yield f"| {name} | {landmarks} | {p:.3f}, {p_mid:.3f} | {u:.2f}, {u_mid:.2f} |"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=60)
    options = parser.parse_args()
    with threadpool_limits(1, user_api="blas"):
        for row in rows(options.runs):
            print(row, flush=True)


if __name__ == "__main__":
    main()
