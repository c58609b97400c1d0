"""Worlds of the Benchmark for Autonomous Robot Navigation (BARN): fields of cylinders that a Jackal has to cross."""

from importlib import resources
from pathlib import Path

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.preset_files import inhabited, robot_of
from mjsim.geometry import Array
from mjsim.world import CylinderObstacle, Floor, Modules, Run, Use, World

WORLD_COUNT, TEST_STRIDE = 300, 6
"""Number of worlds of the benchmark; the challenge tests on every sixth of them, and these are not shipped."""
RADIUS, HEIGHT = 0.075, 1.0
"""Radius and height of the cylinders; the height is an assumption [m]."""
START, HEADING_DEG, GOAL = (-2.25, 3.0), 90.0, (-2.25, 13.0)
"""Position [m] and heading of the robot at the start, and its goal [m]."""
TIME_LIMIT = 100.0
"""Time within which it has to arrive [s]."""
CELL, ORIGIN = 0.15, (-4.575, 5.075)
"""Side of a cell of the reference path, and position of its cell (0, 0) [m]."""
ROBOT = "scout"


def barn_world(
    number: int, *, name: str | None = None, preset: str | None = "jackal", folder: Path | None = None
) -> World:
    """Return a world of the benchmark, with a robot that drives to the goal without a map.

    Args:
        number: Number of the world, 1 to 299, but not a multiple of 6.
        name: Name of the world; None for 'barn-NUMBER'.
        preset: Preset of the robot; None for no robot.
        folder: Folder in which the world will be saved; the preset may be a file in it.

    Raises:
        UsageError: There is no such world, or no such preset.

    References:
        Perille, Truong, Xiao, Stone, Benchmarking Metric Ground Navigation, SSRR 2020.
    """
    things = tuple(
        CylinderObstacle(name=f"post-{place}", at=(x, y), cylinder=(RADIUS, HEIGHT), color="#8c8878")
        for place, (x, y) in enumerate(np.round(_array("cylinders", number), 3).tolist(), start=1)
    )
    world = World(name=name or f"barn-{number}", obstacles=things, floor=Floor(texture="floors/concrete.jpg"))
    if preset is None:
        return world
    robot = robot_of({"name": ROBOT, "preset": preset, "at": list(START), "heading_deg": HEADING_DEG}, folder)
    goal = Use.model_validate({"use": "mjsim.algorithms.go_to_goal:GoToGoal", "goals": [list(GOAL)]})
    run = Run(seconds=TIME_LIMIT, drivers={ROBOT: Modules(navigator=goal)})
    return inhabited(world, robot, run, folder)


def barn_path_length(number: int) -> float:
    """Return the length of the reference path from the start through its cells to the goal [m]."""
    cells = _array("path", number) * CELL + np.array(ORIGIN)
    return float(np.hypot(*np.diff(np.concatenate([[START], cells, [GOAL]]), axis=0).T).sum())


def barn_score(arrival: float | None, length: float) -> float:
    """Return the metric of the challenge, 0 to 0.5.

    Args:
        arrival: Time from the first 0.1 m of motion to the goal [s]; None if the robot touched something, or was late.
        length: Length of the reference path [m].
    """
    optimal = length / 2.0
    return 0.0 if arrival is None else optimal / min(max(arrival, 2.0 * optimal), 8.0 * optimal)


def _array(kind: str, number: int) -> Array:
    """Return an array of a world; raises UsageError if it is not shipped."""
    if not 0 <= number < WORLD_COUNT or not number % TEST_STRIDE:
        raise UsageError(
            f"no BARN world {number}; give a number from 1 to {WORLD_COUNT - 1} that is not a multiple of {TEST_STRIDE}"
        )
    with resources.files("mjsim.assets").joinpath("barn/barn.npz").open("rb") as file, np.load(file) as worlds:
        return np.asarray(worlds[f"{kind}_{number}"], dtype=float)
