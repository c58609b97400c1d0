"""Runs of an independent EKF-SLAM, and how far poses are from the truth."""

from pathlib import Path

import numpy as np

from mjsim.geometry import Array

DATA = Path(__file__).parents[1] / "data" / "ekf"


def golden(name: str) -> dict[str, Array]:
    with np.load(DATA / f"{name}.npz") as file:
        return dict(file)


def mean_error(poses: Array, truth: Array) -> float:
    return float(np.hypot(*(poses - truth)[:, :2].T).mean())
