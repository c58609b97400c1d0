"""The outline of a body from above."""

import math

import numpy as np

from mjsim.geometry import Array

MAX_RADIUS_RATIO = 1.1
"""A body is treated as round if its largest radius is at most this many times its smallest."""


def is_round(outline: Array) -> bool:
    """Return whether an outline around the origin, shape (n, 2), is nearly a circle."""
    reach = np.hypot(outline[:, 0], outline[:, 1])
    return bool(reach.max() < MAX_RADIUS_RATIO * reach.min()) and len(outline) > 8


def rim(outline: Array, bearing: float) -> float:
    """Return the distance from the origin to an outline, shape (n, 2), along a bearing [m]."""
    start = outline
    edge = np.roll(start, -1, axis=0) - start
    along = np.array([math.cos(bearing), math.sin(bearing)])
    across = along[0] * edge[:, 1] - along[1] * edge[:, 0]
    safe = np.where(across == 0.0, np.inf, across)
    distance = (start[:, 0] * edge[:, 1] - start[:, 1] * edge[:, 0]) / safe
    share = (start[:, 0] * along[1] - start[:, 1] * along[0]) / safe
    hit = (across != 0.0) & (share >= -1e-9) & (share <= 1 + 1e-9) & (distance >= 0.0)
    return float(np.where(hit, distance, 0.0).max())
