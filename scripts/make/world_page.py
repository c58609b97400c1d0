"""Write docs/world-file.md: every key of a world file with its default and meaning, from the schema itself.

The schema that editors use, worlds/mjsim.schema.json, is written too.

python scripts/make/world_page.py
"""

import json
import re
from pathlib import Path
from typing import Any

from mjsim.world import editor_schema, world_schema

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "world-file.md"
SCHEMA = ROOT / "worlds" / "mjsim.schema.json"
HEAD = """# The world file

YAML 1.2. Metres, seconds and kilograms; an angle is in degrees and its key ends in `_deg`. x points east, y north,
headings turn counter-clockwise from x. `mjsim check WORLD` reports every error with line and column,
`mjsim schema` prints the same as JSON Schema for completion in editors. Keys without a default are required.
Includes, variables and repeats are described in [the language of world files](world-language.md).
"""


def world_page() -> str:
    """Return the page."""
    schema = world_schema()
    kinds = schema["$defs"]
    order = ["World", *dict.fromkeys(_mentioned(schema, kinds))]
    sections = [_section(name, schema if name == "World" else kinds[name]) for name in order]
    return HEAD + "".join(sections)


def schema_text() -> str:
    """Return the schema for editors, as `mjsim schema` prints it."""
    return json.dumps(editor_schema(), indent=1) + "\n"


def _mentioned(part: Any, kinds: dict[str, Any]) -> list[str]:
    """Return the kinds that a part of the schema leads to, in the order in which a reader meets them."""
    found = []
    for name in _references(part.get("properties", {})):
        found += [name, *_mentioned(kinds[name], kinds)]
    return found


def _references(part: Any) -> list[str]:
    if isinstance(part, dict):
        own = [part["$ref"].rpartition("/")[2]] if "$ref" in part else []
        return own + [name for key, value in part.items() if key != "default" for name in _references(value)]
    return [name for value in part for name in _references(value)] if isinstance(part, list) else []


def _section(name: str, kind: dict[str, Any]) -> str:
    rows = [
        f"| `{key}` | {_kind(value)} | {_default(key, value, kind)} | {_cell(value.get('description', ''))} |\n"
        for key, value in kind["properties"].items()
    ]
    head = f"\n## {name}\n\n{kind.get('description', '')}\n\n| key | value | default | meaning |\n|---|---|---|---|\n"
    return head + "".join(rows)


def _kind(value: dict[str, Any]) -> str:
    """Return what a value may be, in a few words, with links to its own section."""
    if "$ref" in value:
        name = value["$ref"].rpartition("/")[2]
        return f"[{name}](#{name.lower()})"
    for word in ("anyOf", "oneOf"):
        if word in value:
            return " or ".join(_kind(choice) for choice in value[word] if choice.get("type") != "null")
    if "enum" in value:
        return ", ".join(f"`{choice}`" for choice in value["enum"])
    if "const" in value:
        return f"`{value['const']}`"
    if value.get("type") == "array":
        count = f"{value['maxItems']} " if value.get("maxItems") == value.get("minItems", -1) else ""
        items = re.sub(r"(^| or )(number|integer|string|boolean|list)\b", r"\1\2s", _kind(value["items"]))
        return f"list of {count}{items}"
    if "patternProperties" in value or isinstance(value.get("additionalProperties"), dict):
        held = value.get("additionalProperties") or next(iter(value["patternProperties"].values()))
        return f"by name: {_kind(held)}"
    return str(value.get("type", "value")) + _bounds(value)


def _bounds(value: dict[str, Any]) -> str:
    words = {"exclusiveMinimum": "above {}", "minimum": "from {}", "exclusiveMaximum": "below {}", "maximum": "to {}"}
    bounds = [text.format(f"{value[key]:g}") for key, text in words.items() if key in value]
    return f" {' '.join(bounds)}" if bounds else ""


def _default(key: str, value: dict[str, Any], kind: dict[str, Any]) -> str:
    if key in kind.get("required", ()):
        return ""
    default = value.get("default")
    if isinstance(default, dict) and default:
        return "its defaults"
    return "none" if default is None else f"`{json.dumps(default)}`"


def _cell(text: str) -> str:
    return text.replace("\n", " ").replace("|", "\\|")


if __name__ == "__main__":
    PAGE.parent.mkdir(exist_ok=True)
    PAGE.write_text(world_page(), encoding="utf-8")
    SCHEMA.write_text(schema_text(), encoding="utf-8")
