"""Items that a navigator that samples motions shows of its plan: goals, costs and candidates."""

from collections.abc import Sequence

import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.interface import Shown, ShownGrid, ShownLines, ShownPoints

from .path_integral import PathIntegral
from .way_plan import WayPlan

AROUND = 4.0
"""Costs are shown in a square around the robot, from its middle to its sides [m]."""
CANDIDATES = 40
"""Maximum number of sampled motions that are shown."""
ARROW = 0.4
"""Length of the line that shows the heading of a goal [m]."""
GOAL, CANDIDATE = "#e8590c", "#15aabf"


def shown_plan(way: WayPlan, local: PathIntegral, goals: Sequence[Array], place: Array) -> tuple[Shown, ...]:
    """Return items in the frame of the estimate.

    Args:
        way: Its costs.
        local: Its sampled motions.
        goals: Those left, rows of x, y [m] and heading [rad], NaN for any.
        place: Place of the robot, shape (2,) [m].
    """
    costs, (x, y) = way.costs(place, half=AROUND)
    left = np.array(goals)
    headed = left[np.isfinite(left[:, 2])]
    tips = headed[:, :2] + ARROW * np.stack([np.cos(headed[:, 2]), np.sin(headed[:, 2])], axis=-1)
    arrows = np.stack([headed[:, :2], tips], axis=1).reshape(-1, 2)
    ways = local.candidates(CANDIDATES)
    pieces = np.stack([ways[:, :-1], ways[:, 1:]], axis=2).reshape(-1, 2)
    return (
        ShownGrid(name="costs", cells=costs, resolution=way.cell, origin=Pose(float(x), float(y), 0.0)),
        ShownLines(name="candidates", points=pieces, joined=False, width=0.01, color=CANDIDATE),
        ShownPoints(name="goals", points=left[:, :2], size=0.15, color=GOAL),
        ShownLines(name="goals", points=arrows, joined=False, color=GOAL),
    )
