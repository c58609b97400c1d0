"""Arms without a world: from a preset, from a file with the content of one of `arms`, or from MJCF or URDF."""

import json
import re
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from pydantic import ValidationError

from mjsim.errors import Problem, UsageError, WorldError, did_you_mean
from mjsim.mechanics import Arm
from mjsim.sentences import Sentence
from mjsim.world.files import Source, read_asset
from mjsim.world.items import RobotArm, World, arm_names
from mjsim.world.read.world_reader import faults_of, parse_world, read_file
from mjsim.world.yaml import problems_at, read_text

MODELS = (".xml", ".mjcf", ".urdf", ".xacro")
_PLACED = re.compile(r".{1,400}?:(\d+):(\d+): (.*)", re.DOTALL)
"""An error with line and column in the file of an arm."""
NONE: Mapping[str, str] = MappingProxyType({})
MAX_PARENTS = 4
"""Number of parent folders of a model that may contain its meshes."""


def arm(name: str | Path, end: str | None = None, arguments: Mapping[str, str] = NONE) -> Arm:
    """Return an arm by the name of its preset, or from a file.

    Args:
        name: A preset such as 'motoman_up6'; a path that ends in `.yaml`, of a file with the keys of one of `arms`:
            `dh`, `tool`, and so on; or an MJCF (`.xml`), URDF (`.urdf`) or xacro (`.xacro`) file.
        end: Body, site or joint of a model at the end of the chain, with the frame of the flange; needed only if
            ambiguous.
        arguments: Values of `xacro:arg`, for a model in xacro.

    Raises:
        UsageError: There is no such preset or file.
        WorldError: The file is invalid; every error is reported with its line and column.
    """
    return arm_item(name, end, arguments).arm


def arm_item(name: str | Path, end: str | None = None, arguments: Mapping[str, str] = NONE) -> RobotArm:
    """Return an arm as by `arm`, with all its keys of a world file."""
    if str(name).lower().endswith(MODELS):
        return _from_model(Path(name), end, arguments)
    if arguments:
        raise UsageError(Sentence("--arg is for xacro models; '{name}' is not one", name))
    if end is not None:
        raise UsageError(Sentence("end is '{end}'; it is for models (.xml, .urdf), '{name}' is not one", end, name))
    if str(name) in arm_names():
        return RobotArm.model_validate({"preset": str(name), "name": str(name)})
    if not str(name).endswith((".yaml", ".yml")):
        known = did_you_mean(str(name), arm_names())
        raise UsageError(
            Sentence("'{name}' is neither an arm preset nor a file (.yaml, .xml, .urdf, .xacro){known}", name, known)
        )
    return _from_file(Path(name))


def arm_world(name: str | Path, end: str | None = None, arguments: Mapping[str, str] = NONE) -> World:
    """Return a world with only an arm, 'arm' of the robot 'robot' on a fixed base; arguments as for `arm`."""
    arm_item(name, end, arguments)  # whose errors name the arm's own file
    keys: dict[str, Any]
    source = Source()
    if str(name).lower().endswith(MODELS):
        keys, source = _model_keys(Path(name), end, arguments)
    elif str(name) in arm_names():
        keys = {"preset": str(name)}
    else:
        path = Path(name)
        node, _ = read_text(read_file(path), file=str(path))
        assert node is not None
        keys, source = dict(node.value), Source(file=str(path), folder=path.parent)
    robot = {"name": "robot", "base": "fixed", "at": [0, 0], "arms": [{**keys, "name": "arm"}]}
    text = json.dumps({"mjsim": 1, "name": Path(name).stem, "robots": [robot], "run": {"seconds": 86400}})
    return parse_world(text, source=source)


def _from_file(path: Path) -> RobotArm:
    text = read_file(path, what="a YAML file with `dh`, MJCF or URDF")
    if not text.strip():
        raise WorldError([Problem(str(path), 1, 1, "the file is empty; an arm has the key 'dh'")])
    node, problems = read_text(text, file=str(path))
    if node is None or problems:
        raise WorldError(problems)
    keys = {"name": "arm", **node.value} if isinstance(node.value, dict) else node.value
    try:
        return RobotArm.model_validate(keys, context={"source": Source(file=str(path), folder=path.parent)})
    except ValidationError as error:
        raise WorldError(problems_at(node, str(path), faults_of(error, RobotArm))) from None


def _from_model(path: Path, end: str | None, arguments: Mapping[str, str]) -> RobotArm:
    """Return the arm of a model; errors name the place in its text."""
    from mjsim.models import ArmFileError, read_arm, text_place

    if not path.is_file():
        raise UsageError(Sentence("no file '{path}'; name an MJCF (.xml), URDF (.urdf) or xacro (.xacro) file", path))
    keys, source = _model_keys(path, end, arguments)
    inner, whole = keys["model"], path.resolve()
    try:
        return RobotArm.model_validate(keys, context={"source": source})
    except ValidationError as error:
        message = "; ".join(details["msg"] for details in error.errors(include_url=False)).replace(inner, path.name)
        element = ""
        try:
            read_arm(inner, lambda name: read_asset(name, source), end, arguments)
        except ArmFileError as found:
            element = found.element
        except ValueError:
            pass
        line, column = text_place(whole.read_bytes(), element)
        if placed := _PLACED.fullmatch(message):
            line, column, message = int(placed[1]), int(placed[2]), placed[3]
        raise WorldError([Problem(str(path), line, column, message)]) from None


def _model_keys(path: Path, end: str | None, arguments: Mapping[str, str]) -> tuple[dict[str, Any], Source]:
    """Return the keys of a world file for the arm of a model, and their source."""
    whole = path.resolve()
    folder = _package(whole)
    keys: dict[str, Any] = {"name": "arm", "model": whole.relative_to(folder).as_posix()}
    keys |= {"arguments": dict(arguments)} if arguments else {}
    return keys | ({} if end is None else {"end": end}), Source(file=str(path), folder=folder)


def _package(path: Path) -> Path:
    """Return the folder that may contain the files of a model: that of its package, or some folders up."""
    above = list(path.parents)[: MAX_PARENTS + 1]
    package = next((folder for folder in above if (folder / "package.xml").is_file()), None)
    return package.parent if package is not None else above[-1]
