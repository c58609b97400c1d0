"""Write what the page shares with Python: the types of the messages between page and server, and the look of a plan.

python scripts/make/protocol.py

The types, mjsim/web/page/src/run/protocol.ts, are made from the models in Python, and plan/roles.ts from `ROLES`. The
script handles only the parts of JSON Schema that these models use, so a test can run it without node.
"""

from collections.abc import Iterator, Mapping
from itertools import takewhile
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter
from pydantic.json_schema import models_json_schema

from mjsim.plan import ROLES, Mix
from mjsim.web.run.news import FrameHead, News
from mjsim.web.run.requests import REQUESTS
from mjsim.world.items import SENSOR_KINDS

PAGE = Path(__file__).resolve().parents[2] / "mjsim" / "web" / "page" / "src"
FILE, ROLES_FILE = PAGE / "run" / "protocol.ts", PAGE / "plan" / "roles.ts"
ROLES_HEAD = """\
/** How each role of a plan is drawn, as in all pictures. Made by scripts/make/protocol.py; do not edit. */

import type { Tokens } from "../ui/ink";

type Ink = keyof Tokens | "tint";

/** A colour and a fraction of another; 'tint' is a thing's own colour. */
export type Mix = readonly [Ink, Ink, number];

export interface Style {
  fill?: Mix;
  line?: Mix;
  /** [mm on paper] */
  width: number;
  /** Length of dashes, whose gaps are half as long [mm on paper]. */
  dash?: number;
}

export const ROLES: Record<string, Style> = {
"""
HEAD = "/** What page and server say to each other about a run. Made by scripts/make/protocol.py; do not edit. */\n"
PLAIN = {"string": "string", "number": "number", "integer": "number", "boolean": "boolean", "null": "null"}
Schema = Mapping[str, Any]


def protocol() -> str:
    """Return the text of protocol.ts."""
    told = TypeAdapter(tuple[News, FrameHead]).json_schema(mode="serialization")["$defs"]
    asked = models_json_schema([(request, "validation") for request in REQUESTS])[1]["$defs"]
    requests = " | ".join(request.__name__ for request in REQUESTS)
    parts = [*map(_definition, *zip(*(told | asked).items(), strict=True)), f"export type RunRequest = {requests};\n"]
    kinds = ", ".join(f'"{kind}"' for kind in SENSOR_KINDS)
    parts.append(f"/** Kinds of sensors: keys that name them. */\nexport const SENSOR_KINDS = [{kinds}];\n")
    return "\n".join([HEAD, *parts])


def roles() -> str:
    """Return the text of roles.ts: the roles of a world, without those of a run."""
    lines = []
    for role, style in takewhile(lambda each: each[0] != "odometry path", ROLES.items()):
        if style.group == "floor":
            continue
        keys = {
            "fill": style.fill and _mix(style.fill),
            "line": style.line and _mix(style.line),
            "width": f"{style.width:g}",
            "dash": style.dash and f"{style.dash:g}",
        }
        text = ", ".join(f"{key}: {value}" for key, value in keys.items() if value)
        name = f'"{role}"' if " " in role else role
        lines.append(f"  {name}: {{ {text} }},\n")
    return f"{ROLES_HEAD}{''.join(lines)}}};\n"


def _mix(mix: Mix) -> str:
    return f'["{mix.ink}", "{mix.other}", {mix.share:g}]'


def _definition(name: str, schema: Schema) -> str:
    comment = _comment(schema)
    if schema.get("type") == "object" and "properties" in schema:
        return f"{comment}export interface {name} {{\n{''.join(_fields(schema))}}}\n"
    return f"{comment}export type {name} = {_type(schema)};\n"


def _fields(schema: Schema) -> Iterator[str]:
    needed = schema.get("required", ())
    for key, field in schema["properties"].items():
        yield f"{_comment(field, '  ')}  {key}{'' if key in needed else '?'}: {_type(field)};\n"


def _comment(schema: Schema, space: str = "") -> str:
    text = " ".join(schema.get("description", "").split())
    return f"{space}/** {text} */\n" if text else ""


def _type(schema: Schema) -> str:
    """Return a type of TypeScript."""
    if "$ref" in schema:
        return str(schema["$ref"].rpartition("/")[2])
    if "const" in schema or "enum" in schema:
        return " | ".join(f'"{value}"' for value in schema.get("enum", [schema.get("const")]))
    choices = schema.get("anyOf") or schema.get("oneOf")
    if choices:
        return " | ".join(map(_type, choices))
    if schema.get("type") == "array":
        if "prefixItems" in schema:
            return f"[{', '.join(map(_type, schema['prefixItems']))}]"
        inner = _type(schema.get("items", {}))
        return f"({inner})[]" if " | " in inner and not inner.startswith("[") else f"{inner}[]"
    if schema.get("type") == "object":
        values = schema.get("additionalProperties", {})
        return f"Record<string, {_type(values) if isinstance(values, Mapping) else 'unknown'}>"
    return PLAIN.get(schema.get("type", ""), "unknown")


def main() -> None:
    """Write both files."""
    FILE.write_text(protocol(), encoding="utf-8")
    ROLES_FILE.write_text(roles(), encoding="utf-8")


if __name__ == "__main__":
    main()
