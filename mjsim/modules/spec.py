"""Modules named in one word, as on command lines: 'place:Class', or 'place:Class{key: value}'."""

from typing import Any

from pydantic import ValidationError

from mjsim.errors import UsageError
from mjsim.modules.use import host_of, make_module
from mjsim.sentences import Sentence
from mjsim.world import Source, Use, path_of, read_value, sentence


def module_of(spec: str, *, role: str, robot: str) -> tuple[Any, Use]:
    """Return an instance of the module that a text names, and the parsed text with the path as written.

    Args:
        spec: 'dotted.module:Class', 'path/file.py:Class', 'path/file.m' or 'exec:path/program --flag', from the working
            folder; then keyword arguments as YAML in braces, such as
            'mjsim.algorithms.ekf_slam:EkfSlam{jacobians: standard}'.
        role: One of `ROLES`.
        robot: The robot that it drives.

    Raises:
        UsageError: The text is malformed, there is no such module or class, or it does not accept these arguments.
        ModuleFault: It fails, or lacks a method that its role needs.
    """
    named, brace, rest = spec.partition("{")
    try:
        folder, use = host_of(named.strip()).at_hand(named.strip())
        made = Use.model_validate({**_arguments(spec, brace + rest), "use": use})
    except ValidationError as error:
        first = error.errors()[0]
        raise UsageError(Sentence("'{spec}': {sentence}", spec, sentence(first, path_of(first), Use))) from None
    module = make_module(made, Source(folder=folder), role=role, robot=robot)
    return module, made.model_copy(update={"use": named.strip()})


def _arguments(spec: str, text: str) -> dict[str, Any]:
    """Return the keyword arguments in a mapping in braces."""
    if not text:
        return {}
    try:
        values = read_value(text)
    except ValueError:
        values = None
    if not isinstance(values, dict) or not all(isinstance(key, str) for key in values):
        raise UsageError(
            Sentence("'{spec}': the part in braces is not YAML; write it as {{key: value, other: value}}", spec)
        )
    return values
