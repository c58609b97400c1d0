"""Robots of generated worlds: from a shipped preset, or from a preset file in the folder of the new world."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from mjsim.errors import UsageError
from mjsim.world import Robot, Run, Source, World

NO_NOISE = {"distance": 0.0, "turn": 0.0}
"""Odometry noise of a robot that follows its path by dead reckoning alone."""


def robot_of(keys: Mapping[str, Any], folder: Path | None) -> Robot:
    """Return the robot described by keys of a world file.

    Args:
        keys: The keys, as in a world file.
        folder: Folder in which the world will be saved, where a preset file is looked up.

    Raises:
        UsageError: The preset does not exist, or its file is invalid.
    """
    try:
        return Robot.model_validate(dict(keys), context={"source": Source(folder=folder)})
    except ValidationError as error:
        first = error.errors()[0]
        says = first["msg"].removeprefix("Value error, ")
        if first["msg"].startswith("Input should"):
            # The model's message about a bound names neither the key nor the value.
            key = ".".join(str(part) for part in first["loc"] if isinstance(part, str))
            says = f"the robot's {key} is {str(first['input'])[:40]}; it{says.removeprefix('Input')}"
        raise UsageError(says) from None


def inhabited(world: World, robot: Robot, run: Run, folder: Path | None) -> World:
    """Return a world with a robot; files that the robot names are looked up in the world's future folder."""
    whole = world.model_copy(update={"robots": (robot,), "run": run})
    whole._source = replace(world.source, folder=folder)
    return whole
