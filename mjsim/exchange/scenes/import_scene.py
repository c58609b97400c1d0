"""Imports scenes of Gazebo, MuJoCo and Webots as worlds."""

from pathlib import Path

from mjsim.errors import UsageError
from mjsim.exchange.maps import name_of
from mjsim.exchange.scenes.build import build_world
from mjsim.exchange.scenes.mjcf_in import read_mjcf
from mjsim.exchange.scenes.scene_solids import Scene
from mjsim.exchange.scenes.sdf_in import read_sdf
from mjsim.exchange.scenes.wbt_in import read_wbt
from mjsim.exchange.start_place import with_newcomer
from mjsim.exchange.world_comment import world_text
from mjsim.exchange.world_import import SCENE_SUFFIXES, Brought, Newcomer
from mjsim.inventory import inventory
from mjsim.sentences import number_of
from mjsim.world import World, solid

_SIMULATORS = {".xml": "MuJoCo", ".mjcf": "MuJoCo", ".wbt": "Webots"}
"""Suffix -> simulator, if it is not Gazebo."""


def is_scene(path: Path) -> bool:
    """Return whether a file is a scene of another simulator, judging by its suffix."""
    return path.suffix.lower() in SCENE_SUFFIXES


def bring_scene(path: Path, *, robot: Newcomer | None, search: list[Path], folder: str) -> Brought:
    """Return the world of a scene, with a robot unless `robot` is None.

    Args:
        path: An SDF world or model, an MJCF file, or a world of Webots.
        robot: The robot to add; it starts where the first robot of the scene does, if there is space.
        search: Folders with folders of models.
        folder: Name of the folder for the model files, beside the world.

    Raises:
        UsageError: The file cannot be read, or leaves no space for the robot.
    """
    simulator = _SIMULATORS.get(path.suffix.lower(), "Gazebo")
    try:
        if simulator == "Gazebo":
            scene = read_sdf(path, search=search)
        else:
            scene = read_wbt(path) if simulator == "Webots" else read_mjcf(path)
    except ValueError as error:
        raise UsageError(f"'{path}': {error}") from None
    if not scene.things:
        lost = "; ".join(inventory(scene.items))[:400]
        raise UsageError(f"'{path}' has nothing that a robot could touch or sense{f' ({lost})' if lost else ''}")
    world, files = build_world(scene, name=name_of(path), folder=folder)
    things = number_of(len(world.obstacles), "thing")
    report = [f"{path}: {_counted(scene)}; {number_of(len(world.walls), 'wall')}, {things}{_size(world)}"]
    whole, told = with_newcomer(world, robot, start=scene.starts[0] if scene.starts else None)
    notes = [f"From the scene {path.name} of {simulator}."]
    return Brought(world_text(whole, notes=notes), [*report, *told, *inventory(scene.items)], files)


def _counted(scene: Scene) -> str:
    solids = sum(len(thing.solids) for thing in scene.things)
    return f"{number_of(len(scene.things), 'model')} of {number_of(solids, 'shape')}"


def _size(world: World) -> str:
    """Return the size of all solid parts, for the report; empty if there are none."""
    shape = solid(world)
    if shape.is_empty:
        return ""
    low_x, low_y, high_x, high_y = shape.bounds
    return f", {high_x - low_x:.2f} x {high_y - low_y:.2f} m"
