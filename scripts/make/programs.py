"""Write the part of docs/programs.schema.json about observations; the rest is written by hand.

python scripts/make/programs.py

The readings that programs get as they are declared (`mjsim.interface.forms`) are made from their declarations.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mjsim.interface import Observation
from mjsim.interface.forms import Form, FormField, ReadingType, form_fields, width_of
from mjsim.interface.trees import OWN_FORM

FILE = Path(__file__).resolve().parents[2] / "docs" / "programs.schema.json"
WIDTH = 160
"""Longest line of the file [characters]."""
Schema = dict[str, Any]


def with_readings(text: str) -> str:
    """Return the schema with the readings that follow from their declarations."""
    schema = json.loads(text)
    kinds, seen = schema["$defs"], schema["$defs"]["obs"]
    for part, form in form_fields(Observation):
        if part.name in kinds and part.name not in OWN_FORM:
            kinds[part.name] = _field(part, form)
            seen["properties"][part.name] = {"$ref": f"#/$defs/{part.name}"}
        elif part.name not in OWN_FORM:
            seen["properties"][part.name] = _field(part, form)
    seen["required"] = [*seen["properties"]]
    return _written(schema, 0) + "\n"


def _field(part: FormField, form: Form) -> Schema:
    """Return the schema of the readings in a field of an observation."""
    about = {"description": form.about}
    if part.is_batch:
        columns = "; ".join(f"{each.name}: {its.about}" for each, its in form_fields(part.item))
        width = sum(width_of(each, its) for each, its in form_fields(part.item))
        return {"description": f"{form.about}: rows of {columns}", **_listed(_listed({"type": "number"}, width))}
    if not part.has_readings:
        return about | _value(part, form)
    if part.is_mapping:
        return about | {"type": "object", "additionalProperties": _reading(part.item)}
    return about | (_listed(_reading(part.item)) if part.is_tuple else _reading(part.item))


def _reading(kind: ReadingType) -> Schema:
    fields = form_fields(kind)
    return {
        "type": "object",
        "properties": {part.name: {"description": form.about} | _value(part, form) for part, form in fields},
        "required": [part.name for part, _ in fields if not part.is_optional],
        "additionalProperties": False,
    }


def _value(part: FormField, form: Form) -> Schema:
    """Return the schema of a number, a text or an array."""
    if part.kind in (str, float, int):
        return {"type": "string" if part.kind is str else "number"}
    schema: Schema = {"type": ["number", "null"] if form.is_distance else "number"}
    for size in reversed(form.shape):
        schema = _listed(schema, size)
    return schema


def _listed(item: Schema, count: int = -1) -> Schema:
    return {"type": "array", "items": item} | ({} if count < 0 else {"minItems": count, "maxItems": count})


def _written(value: Any, depth: int) -> str:
    """Return a value as JSON: on one line if it fits or is a list of texts, else a line for each of its parts."""
    line = json.dumps(value, ensure_ascii=False)
    parts = list(value.values() if isinstance(value, Mapping) else value) if isinstance(value, Mapping | list) else []
    if len(line) + depth <= WIDTH or all(isinstance(each, str) for each in parts):
        return line
    space = "\n" + " " * (depth + 1)
    if isinstance(value, Mapping):
        parts = [f"{json.dumps(key)}: {_written(each, depth + 1)}" for key, each in value.items()]
        return f"{{{space}{f',{space}'.join(parts)}\n{' ' * depth}}}"
    return f"[{space}{f',{space}'.join(_written(each, depth + 1) for each in value)}\n{' ' * depth}]"


if __name__ == "__main__":
    FILE.write_text(with_readings(FILE.read_text(encoding="utf-8")), encoding="utf-8")
