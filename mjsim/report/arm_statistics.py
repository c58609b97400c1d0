"""Statistics of arms: tracking errors of joints, torques, and the path of the tool."""

from typing import Any

import numpy as np

from mjsim.geometry import Array
from mjsim.record import JointTrack
from mjsim.world import World


def arm_figures(track: JointTrack) -> dict[str, Any]:
    """Return the statistics of one arm: tracking errors [rad, m], torques, and length of the tool's path."""
    error = track.goal - track.positions
    known = np.isfinite(error).all(axis=1)
    if not known.any():
        return dict.fromkeys(("goal_error", "torque_max", "tool_distance_m"))
    each = {
        name: {"max": float(np.abs(column).max()), "rms": float(np.sqrt(np.mean(column**2)))}
        for name, column in zip(track.names, error[known].T, strict=True)
    }
    return {
        "goal_error": each,
        "torque_max": dict(zip(track.names, np.abs(track.torques[known]).max(axis=0).tolist(), strict=True)),
        "tool_distance_m": float(np.linalg.norm(np.diff(track.tool[known, :3], axis=0), axis=1).sum()),
    }


def slides_of(world: World, robot: str, arm: str) -> Array:
    """Return which joints of an arm are prismatic, bool, shape (joints,)."""
    items = next(each.arms for each in world.robots if each.name == robot)
    return np.array([link.slide for item in items if item.name == arm for link in item.arm.links])
