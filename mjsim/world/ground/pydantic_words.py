"""Messages for pydantic errors: the wrong value, then what would be right."""

import difflib
import math
import re
from collections.abc import Iterable, Mapping
from typing import Any, get_args, get_origin

from pydantic import BaseModel
from pydantic_core import ErrorDetails

from mjsim.errors import did_you_mean
from mjsim.sentences import Sentence
from mjsim.world.ground.descriptions import description_of
from mjsim.world.ground.model_base import (
    COLOR_PATTERN,
    COMPLEX_PATTERN,
    JOINT_PATTERN,
    KEY,
    NAME_PATTERN,
    PART_PATTERN,
    PLAIN_PATTERN,
    PLANT_PATTERN,
    POINT_PATTERN,
    TARGET_PATTERN,
    USE_PATTERN,
)

Path = tuple[str | int, ...]

_PATTERNS = {
    NAME_PATTERN: "a name of letters, digits, '_', '.' and '-', which begins with a letter, a digit or '_'",
    COLOR_PATTERN: 'a colour such as "#e8e4da", in quotes',
    PART_PATTERN: "ARM/link1 and so on, or ARM/tool",
    JOINT_PATTERN: "a name of letters, digits, '_' and '-'; a dot separates it from the part on it",
    POINT_PATTERN: "NAME, or NAME.POINT",
    TARGET_PATTERN: "THING.TARGET",
    PLAIN_PATTERN: "a name or a path, without control characters",
    PLANT_PATTERN: "NAME, or NAME/PART",
    COMPLEX_PATTERN: "a number such as -1+2j",
    USE_PATTERN: "'module:Class', 'file.py:Class', 'file.m' or 'exec:./program'",
}
_KINDS = {
    "float_type": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "bool_type": "true or false",
    "string_type": "text",
    "string_unicode": "text",
    "finite_number": "a finite number",
    "tuple_type": "a list",
    "dict_type": "keys with values",
    "mapping_type": "keys with values",
    "model_type": "keys with values",
    "model_attributes_type": "keys with values",
}
_BOUNDS = {
    "greater_than": ("above", "gt"),
    "greater_than_equal": ("at least", "ge"),
    "less_than": ("below", "lt"),
    "less_than_equal": ("at most", "le"),
}
_SHAPE = re.compile(r"(\[\w+(?:, \w+)+\])( each)?")
_UNIT = re.compile(r"\[([^\[\]]*)\]\W*$")
_ITEMS = ("{count} item", "{count} items")
_CHARACTERS = ("{count} character", "{count} characters")
_UNITS_OF_KEYS = {"_deg": "deg", "_hz": "Hz"}


def path_of(error: ErrorDetails) -> Path:
    """Return the path of the wrong value, below the validated one."""
    return (*error["loc"], *error.get("ctx", {}).get("path", ()))


def sentence(error: ErrorDetails, path: Path, model: type[BaseModel]) -> str:
    """Return a message for the value at a path below a model: what is wrong and what would be right."""
    kind, context, value = error["type"], error.get("ctx", {}), error["input"]
    name = _name(path)
    if kind == "extra_forbidden" and path[-1] == "<<":
        return "merge key '<<' is not supported; write its keys out"
    if kind == "extra_forbidden":
        return Sentence("unknown key '{key}'{meant}", path[-1], did_you_mean(str(path[-1]), keys_at(model, path[:-1])))
    if kind == "missing":
        return Sentence("key '{key}' is missing; add it{described}", path[-1], _described(model, path))
    if kind == "mjsim" or "error" in context:
        return str(context.get("text", context.get("error")))
    if path and path[-1] == KEY:
        return Sentence("key {value} is not valid; it must be {right}", shown(value), _PATTERNS[NAME_PATTERN])
    shape = _shape(model, path) if kind in ("too_short", "too_long", "tuple_type") else ""
    right = Sentence("it must be {right}", shape) if shape else _right(kind, context, value, error["msg"])
    return Sentence("{name} is {value}; {right}", name, shown(value, unit=_unit(model, path)), right)


def _right(kind: str, context: Mapping[str, Any], value: Any, otherwise: str) -> str:
    """Return what would be right, as the second half of a message."""
    if kind in _KINDS:
        return Sentence("it must be {right}", _KINDS[kind])
    if kind in _BOUNDS:
        word, key = _BOUNDS[kind]
        bound = context[key]
        return Sentence("it must be {word} {bound}", word, bound if isinstance(bound, int) else format(bound, "g"))
    if kind in ("too_short", "too_long"):
        few = kind == "too_short"
        count = context["min_length" if few else "max_length"]
        return Sentence("it must have {bound} {items}", "at least" if few else "at most", _counted(count, _ITEMS))
    if kind in ("string_too_short", "string_too_long"):
        few = kind == "string_too_short"
        count = context["min_length" if few else "max_length"]
        return Sentence("it must have {bound} {items}", "at least" if few else "at most", _counted(count, _CHARACTERS))
    if kind == "string_pattern_mismatch":
        return Sentence("it must be {right}", _PATTERNS[context["pattern"]])
    if kind == "literal_error":
        suggestion = (
            did_you_mean(value, re.findall(r"'([^']*)'", context["expected"])) if isinstance(value, str) else ""
        )
        meant = suggestion if suggestion.startswith("; did") else ""
        return Sentence("it must be {expected}{meant}", context["expected"], meant)
    return otherwise[0].lower() + otherwise[1:]


def shown(value: Any, *, unit: str = "") -> str:
    """Return a value in the form used in messages, at most 60 characters long."""
    if value is None:
        return "empty"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (int, float)):
        return f"{value!r} {unit}".rstrip() if math.isfinite(value) else str(value)
    if isinstance(value, Mapping):
        return (
            f"{{{', '.join(map(str, value))}}}" if len(value) < 4 else Sentence("a mapping of {count} keys", len(value))
        )
    if isinstance(value, (list, tuple)):
        text = repr(list(value))
        return text if len(text) <= 60 else Sentence("a list of {counted}", _counted(len(value), _ITEMS))
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:50]}...{text[-1]}"


def meant_key(path: Path, model: type[BaseModel]) -> str | None:
    """Return the correct spelling of a misspelt key at the end of a path; None if no key is similar."""
    return next(iter(difflib.get_close_matches(str(path[-1]), keys_at(model, path[:-1]), n=1)), None)


def misspelt_kind(given: Iterable[str], path: Path, model: type[BaseModel]) -> tuple[str, str] | None:
    """Return which of the given keys is the misspelt key that names the kind of item, and a message."""
    for key in given:
        meant = meant_key((*path, key), model)
        if meant is not None and meant != key:
            return key, Sentence("unknown key '{key}'; did you mean '{meant}'?", key, meant)
    return None


def keys_at(model: type[BaseModel], path: Path) -> list[str]:
    """Return the valid keys at a path below a model."""
    return sorted({key for found in models_at(model, path) for key in found.model_fields})


def models_at(model: type[BaseModel], path: Path) -> list[type[BaseModel]]:
    """Return the possible models at a path; a step in angle brackets is the tag of a kind."""
    found, mapping = [model], False
    for step in path:
        if mapping:
            mapping = False
        elif isinstance(step, str) and step.startswith("<"):
            found = [kind for kind in found if step[1:-1] in kind.model_fields] or found
        elif isinstance(step, str):
            annotations = [kind.model_fields[step].annotation for kind in found if step in kind.model_fields]
            found = [kind for annotation in annotations for kind in _models_in(annotation)]
            mapping = any(get_origin(annotation) in (dict, Mapping) for annotation in annotations)
    return found


def _models_in(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [kind for part in get_args(annotation) for kind in _models_in(part)]


def _field_texts(model: type[BaseModel], path: Path) -> list[str]:
    """Return the descriptions of the key at the end of a path, ignoring indices."""
    while path and isinstance(path[-1], int):
        path = path[:-1]
    if not path:
        return []
    kinds = [kind for kind in models_at(model, path[:-1]) if path[-1] in kind.model_fields]
    return [description_of(kind, str(path[-1])) for kind in kinds]


def _unit(model: type[BaseModel], path: Path) -> str:
    name = next((step for step in reversed(path) if isinstance(step, str)), "")
    return next((unit for text in ["", *_field_texts(model, path)] if (unit := unit_of(name, text))), "")


def unit_of(name: str, description: str) -> str:
    """Return the unit of a field from its name or the end of its description; '' if neither gives one."""
    for ending, unit in _UNITS_OF_KEYS.items():
        if name.endswith(ending):
            return unit
    found = _UNIT.search(description)
    return found.group(1) if found else ""


def _described(model: type[BaseModel], path: Path) -> str:
    text = next(iter(_field_texts(model, path)), "")
    return Sentence(": {meaning}", f"{text[0].lower()}{text[1:].rstrip('.')}") if text else ""


def _shape(model: type[BaseModel], path: Path) -> str:
    """Return the form of a fixed-length list, such as '[x, y]'; '' for other lists."""
    texts = _field_texts(model, path)
    found = _SHAPE.search(texts[0]) if texts else None
    if not found or isinstance(path[-1], str) == bool(found.group(2)):
        return ""
    return found.group(1)


def _name(path: Path) -> str:
    """Return the last key of a path with the indices after it."""
    steps = [step for step in path if isinstance(step, int) or not step.startswith("<")]
    start = max((index for index, step in enumerate(steps) if isinstance(step, str)), default=0)
    return "".join(f"[{step}]" if isinstance(step, int) else step for step in steps[start:]) or "the world"


def _counted(count: int, forms: tuple[str, str]) -> str:
    return Sentence(forms[count != 1], count)
