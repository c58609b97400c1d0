"""Parts of the JSON Schemas of topics.

Foxglove reads JSON Schema without unions and without arrays in arrays, so a matrix is a flat list, row by row, and
missing values are left out.

A number that may be null needs a union. In draft 7, keys beside `$ref` are ignored, so a validator follows the
reference to the union, while Foxglove, which does not support references, reads the plain type beside it.
"""

from collections.abc import Collection, Sequence
from typing import Any

Schema = dict[str, Any]

DRAFT = "http://json-schema.org/draft-07/schema#"
DEFINITIONS: Schema = {"distance": {"type": ["number", "null"], "description": "[m]; null stands for +infinity"}}
EXACT = "Numbers are IEEE doubles, written so that they read back exactly."


def number(description: str) -> Schema:
    """Return the schema of a number."""
    return {"type": "number", "description": description}


def integer(description: str) -> Schema:
    """Return the schema of a whole number."""
    return {"type": "integer", "description": description}


def boolean(description: str) -> Schema:
    """Return the schema of a boolean."""
    return {"type": "boolean", "description": description}


def text(description: str) -> Schema:
    """Return the schema of a text."""
    return {"type": "string", "description": description}


def one_of(words: Sequence[str], description: str) -> Schema:
    """Return the schema of a string from a list of words."""
    return text(description) | {"enum": list(words)}


def numbers(description: str, *, count: int | None = None) -> Schema:
    """Return the schema of a list of numbers, of a fixed length if given."""
    length = {} if count is None else {"minItems": count, "maxItems": count}
    return listed({"type": "number"}, description) | length


def distances(description: str) -> Schema:
    """Return the schema of a list of distances, null for no return."""
    item = {"type": "number", "$ref": "#/definitions/distance"}
    return listed(item, f"{description}; null where there is nothing")


def packed(rows: str, kind: str = "doubles") -> Schema:
    """Return the schema of packed numbers, of a kind such as 'doubles'."""
    description = f"Little-endian {kind}, row by row: {rows}"
    return {"type": "string", "contentEncoding": "base64", "description": description}


def xyz(description: str) -> Schema:
    """Return the schema of a 3-D vector."""
    return keyed({axis: {"type": "number"} for axis in "xyz"}, description)


def keyed(properties: Schema, description: str = "", *, optional: Collection[str] = ()) -> Schema:
    """Return the schema of an object; all properties are required except the optional ones."""
    required = [name for name in properties if name not in optional]
    return {"type": "object", "description": description, "properties": properties, "required": required}


def listed(item: Schema, description: str) -> Schema:
    """Return the schema of a list."""
    return {"type": "array", "items": item, "description": description}


def topic(title: str, description: str, properties: Schema, *, optional: Collection[str] = ()) -> Schema:
    """Return the schema of a topic's messages, all of which have a time."""
    message = keyed({"time": TIME} | properties, f"{description} {EXACT}", optional=optional)
    return {"$schema": DRAFT, "title": title, "definitions": DEFINITIONS} | message


TIME = number("Simulated time [s]")
STAMP = keyed({"sec": {"type": "integer"}, "nsec": {"type": "integer"}}, "Simulated time, rounded to 1 ns")
