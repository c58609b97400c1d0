"""Modules named in one word, as command lines do: 'place:Class', or 'place:Class{key: value}'."""

from pathlib import Path
from typing import Any

from pydantic import ValidationError
from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

from mjsim.errors import UsageError
from mjsim.world.running import Use
from mjsim.world.source import Source
from mjsim.world.use import make_module
from mjsim.world.words import path_of, sentence


def module_of(spec: str) -> tuple[Any, Use]:
    """Return an instance of the class that a text names, and what the text says, its path as it is written there.

    Args:
        spec: 'dotted.module:Class' or 'path/file.py:Class', from the working folder; then keyword arguments as YAML
            in braces, such as 'mjsim.algorithms.ekf_slam:EkfSlam{jacobians: standard}'.

    Raises:
        UsageError: It is not written so, there is no such module or class, or it does not take these arguments.
    """
    named, brace, rest = spec.partition("{")
    place, _, name = named.strip().rpartition(":")
    file = Path(place)
    folder, use = (file.parent, f"{file.name}:{name}") if place.endswith(".py") else (None, f"{place}:{name}")
    try:
        made = Use.model_validate({**_arguments(spec, brace + rest), "use": use})
    except ValidationError as error:
        first = error.errors()[0]
        raise UsageError(f"'{spec}': {sentence(first, path_of(first), Use)}") from None
    return make_module(made, Source(folder=folder)), made.model_copy(update={"use": named.strip()})


def _arguments(spec: str, text: str) -> dict[str, Any]:
    """Return the keyword arguments that a mapping in braces holds."""
    if not text:
        return {}
    try:
        values = YAML(typ="safe", pure=True).load(text)
    except YAMLError:
        values = None
    if not isinstance(values, dict) or not all(isinstance(key, str) for key in values):
        raise UsageError(f"'{spec}': the part in braces is not YAML; write it as {{key: value, other: value}}")
    return values
