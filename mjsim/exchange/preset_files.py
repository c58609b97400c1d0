"""Robots of worlds that are made: of a preset that comes with mjsim, or of a file in the folder of the new world."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from mjsim.errors import UsageError
from mjsim.world import Robot, Run, Source, World


def robot_of(keys: Mapping[str, Any], folder: Path | None) -> Robot:
    """Return the robot that keys of a world describe.

    Args:
        keys: As a world file has them.
        folder: Where that will be, for the file of a preset.

    Raises:
        UsageError: The preset does not exist, or its file is wrong.
    """
    try:
        return Robot.model_validate(dict(keys), context={"source": Source(folder=folder)})
    except ValidationError as error:
        raise UsageError(error.errors()[0]["msg"].removeprefix("Value error, ")) from None


def inhabited(world: World, robot: Robot, run: Run, folder: Path | None) -> World:
    """Return a world with a robot, which will be in a folder: what it names is looked for there."""
    whole = world.model_copy(update={"robots": (robot,), "run": run})
    whole._source = replace(world.source, folder=folder)
    return whole
