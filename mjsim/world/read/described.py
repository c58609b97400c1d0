"""Reads YAML files other than worlds: validated by a model, every error with its position."""

from pathlib import Path
from typing import TypeVar

from pydantic import ValidationError

from mjsim.errors import WorldError
from mjsim.world.ground import Model
from mjsim.world.read.world_reader import faults_of, read_file
from mjsim.world.yaml import problems_at, read_text

M = TypeVar("M", bound=Model)


def read_described(path: str | Path, model: type[M], *, what: str = "a YAML file") -> M:
    """Return the content of a YAML file.

    Args:
        path: The file.
        model: Model of the content.
        what: What the user should name if it is not a file.

    Raises:
        UsageError: The file does not exist.
        WorldError: The file is invalid; every error is reported with its line and column.
    """
    node, problems = read_text(read_file(Path(path), what=what), file=str(path))
    if node is None or problems:
        raise WorldError(problems)
    try:
        return model.model_validate(node.value)
    except ValidationError as error:
        raise WorldError(problems_at(node, str(path), faults_of(error, model))) from None
