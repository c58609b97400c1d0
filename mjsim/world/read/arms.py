"""Arms without a world: a preset by its name, or a file that holds what stands below one of `arms`."""

from pathlib import Path

from pydantic import ValidationError

from mjsim.errors import UsageError, WorldError, did_you_mean
from mjsim.mechanics import Arm
from mjsim.world.items import RobotArm, arm_names
from mjsim.world.read.reader import faults_of, read_file
from mjsim.world.yaml import problems_at, read_text


def arm(name: str | Path) -> Arm:
    """Return an arm by the name of its preset, or of a YAML file.

    Args:
        name: Such as 'motoman_up6', or a path that ends in `.yaml`; the file holds what a world has below one of its
            `arms`: `dh`, `tool`, and so on.

    Raises:
        UsageError: There is no such preset, and no such file.
        WorldError: Something in the file is wrong; every fault is told with its line and column.
    """
    return arm_item(name).arm


def arm_item(name: str | Path) -> RobotArm:
    """Return an arm as `arm` does, with all that a world file says of it."""
    if str(name) in arm_names():
        return RobotArm.model_validate({"preset": str(name), "name": str(name)})
    if not str(name).endswith((".yaml", ".yml")):
        raise UsageError(f"no arm '{name}'{did_you_mean(str(name), arm_names())}; or name a YAML file")
    return _from_file(Path(name))


def _from_file(path: Path) -> RobotArm:
    node, problems = read_text(read_file(path), file=str(path))
    if node is None or problems:
        raise WorldError(problems)
    keys = {"name": "arm", **node.value} if isinstance(node.value, dict) else node.value
    try:
        return RobotArm.model_validate(keys)
    except ValidationError as error:
        raise WorldError(problems_at(node, str(path), faults_of(error, RobotArm))) from None
