"""JSON Schema of the world file, with which editors complete keys and mark mistakes."""

from collections.abc import Iterator
from typing import Any

from mjsim.world.ground import unit_of
from mjsim.world.items import World
from mjsim.world.language.arithmetic import NAME
from mjsim.world.language.repeats import MAX_REPEATS, Repeat

Schema = dict[str, Any]

_HEAD = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
_EXPRESSION = {"$ref": "#/$defs/Expression"}
_SCALARS = ("number", "integer", "boolean")


def world_schema() -> Schema:
    """Return the JSON Schema (draft 2020-12) of a world, with descriptions and defaults."""
    return {**_HEAD, **World.model_json_schema(), "title": "mjsim world"}


def editor_schema() -> Schema:
    """Return the JSON Schema of the text of a world file: with expressions, `include`, `variables`, `repeat`."""
    whole = world_schema()
    repeat = Repeat.model_json_schema()
    kinds = {name: _with_expressions(kind) for name, kind in whole.pop("$defs").items()}
    for name in _items_of_lists(World.model_json_schema()):
        kinds[name]["properties"]["repeat"] = {
            "anyOf": [
                {"$ref": "#/$defs/Repeat"},
                {"type": "array", "minItems": 1, "maxItems": MAX_REPEATS, "items": {"$ref": "#/$defs/Repeat"}},
            ],
            "description": "Repeats the item; a list of nested repeats makes a grid.",
        }
    kinds["Repeat"] = _with_expressions(repeat)
    kinds["Expression"] = {
        "type": "string",
        "pattern": r"\$\{[^{}]*\}",
        "description": "Arithmetic with variables, such as ${width / 2}.",
    }
    properties = {**_reuse(), **_with_expressions(whole)["properties"]}
    return {**whole, "properties": properties, "$defs": kinds}


def with_units(schema: Schema) -> Schema:
    """Return a schema with a key `unit` in each field whose unit is known: 'm', 'deg', 's', 'Hz' and so on."""
    found: Schema = _with_units(schema)
    return found


def _with_units(part: Any, name: str = "") -> Any:
    """Return a part of a schema with units; `name` is the name of the field."""
    if isinstance(part, list):
        return [_with_units(item) for item in part]
    if not isinstance(part, dict):
        return part
    found = {
        key: {field: _with_units(item, field) for field, item in value.items()}
        if key == "properties"
        else _with_units(value)
        for key, value in part.items()
    }
    unit = unit_of(name, str(part.get("description", ""))) if name else ""
    return {**found, "unit": unit} if unit else found


def _reuse() -> Schema:
    """Return the keys that exist only in the text of a world file, and not after expansion."""
    name = f"^{NAME.pattern}$"
    return {
        "include": {
            "type": "array",
            "items": {"type": "string"},
            "description": "World files that are merged into this one; paths from this file.",
        },
        "variables": {
            "type": "object",
            "propertyNames": {"pattern": name},
            "additionalProperties": {"type": ["number", "string", "boolean"]},
            "description": "Values by name, for expressions such as ${width / 2}; a later one may use those before it.",
        },
    }


def _with_expressions(part: Any) -> Any:
    """Return a part of a schema in which an expression may replace any scalar."""
    if isinstance(part, list):
        return [_with_expressions(item) for item in part]
    if not isinstance(part, dict):
        return part
    if _is_scalar(part):
        annotations = {key: part[key] for key in ("title", "description", "default", "examples") if key in part}
        return {
            **annotations,
            "anyOf": [{key: value for key, value in part.items() if key not in annotations}, _EXPRESSION],
        }
    for word in ("anyOf", "oneOf"):
        if any(_is_scalar(choice) for choice in part.get(word, ())):
            choices = [choice if _is_scalar(choice) else _with_expressions(choice) for choice in part[word]]
            rest = {key: value for key, value in part.items() if key != word}
            return {**rest, "anyOf": [*choices, _EXPRESSION]}
    return {key: value if key == "default" else _with_expressions(value) for key, value in part.items()}


def _is_scalar(part: Schema) -> bool:
    """Return whether a schema is that of a scalar that does not already match expressions."""
    if "const" in part:
        return False  # it distinguishes kinds
    return part.get("type") in _SCALARS or (part.get("type") == "string" and ("pattern" in part or "enum" in part))


def _items_of_lists(part: Any) -> Iterator[str]:
    """Yield the names of the kinds that occur in lists."""
    if isinstance(part, dict):
        items = part.get("items")
        if isinstance(items, dict):
            choices = [items, *items.get("oneOf", ()), *items.get("anyOf", ())]
            yield from (choice["$ref"].rpartition("/")[2] for choice in choices if "$ref" in choice)
        for value in part.values():
            yield from _items_of_lists(value)
    elif isinstance(part, list):
        for value in part:
            yield from _items_of_lists(value)
