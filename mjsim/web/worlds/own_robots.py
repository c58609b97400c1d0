"""URDF files of robots, which become presets when they are chosen."""

import re

from mjsim.exchange import RobotOptions, bring_robot
from mjsim.output import write_files
from mjsim.web.worlds.folder import Folder
from mjsim.web.worlds.items import Json
from mjsim.web.worlds.world_files import source_of


def preset_of(folder: Folder, file: str, *, world: str | None) -> Json:
    """Write the preset of a robot beside a world.

    Args:
        folder: Folder of the studio.
        file: URDF or xacro of the robot, relative to the folder of the world.
        world: The world; by default in the folder of the studio.

    Returns:
        `path` of the preset relative to the world, and `report`: what was kept, guessed and added.

    Raises:
        UsageError: The file cannot be converted, or there is a preset of that name.
    """
    place = source_of(folder, world or "").folder or folder.root
    path = folder.path(file if place == folder.root else f"{folder.name(place)}/{file}")
    name = re.sub(r"[^A-Za-z0-9_-]+", "_", path.stem).strip("_-") or "robot"
    brought = bring_robot(path, name=name, options=RobotOptions(), packages={}, arguments={}, environment={})
    preset = f"{name}.yaml"
    with folder.writing:
        write_files(place, {preset: brought.text.encode(), **brought.files}, overwrite=False)
    return {"path": preset, "report": list(brought.report)}
