"""Parses JSON messages and checks them against the schema of their topic; errors have one line."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TypeVar

from pydantic import ValidationError
from pydantic_core import CoreSchema, SchemaValidator, core_schema

from mjsim.errors import RecordingError
from mjsim.record.file import RawMessage
from mjsim.record.json_schema import Schema
from mjsim.record.numbers import Message
from mjsim.record.schemas import ARM_TOPICS, MECHANISM_TOPICS, ROBOT_TOPICS, SENSOR_TOPICS, WORLD_TOPICS

T = TypeVar("T")

MIN_COUNTED_BYTES = 1 << 20
"""Length of messages above which the values are counted before parsing [bytes]."""
MAX_MESSAGE_BYTES = 1 << 25
"""Maximum length of a message [bytes]; its strings take up to four times as much while it is parsed."""
MAX_VALUES = 1_000_000
"""Maximum number of values in a message; each takes up to 300 bytes while it is parsed."""
FAULTS = (ArithmeticError, LookupError, TypeError, ValueError)
"""Exceptions raised by messages whose numbers have the right type, but are too few, too many or too large."""


def content_of(raw: RawMessage, *, path: Path) -> Message:
    """Return the content of a JSON message of a topic of ours.

    Args:
        raw: The message.
        path: Its file, for the error.

    Raises:
        RecordingError: It does not fit the schema of its topic; unknown keys are left out.
    """
    data = raw.data
    if len(data) > MAX_MESSAGE_BYTES:
        raise misfit(raw, f"more than {MAX_MESSAGE_BYTES / 1e6:.0f} MB", path=path)
    if len(data) > MIN_COUNTED_BYTES and sum(map(data.count, (b",", b"[", b"{"))) > MAX_VALUES:
        raise misfit(raw, f"more than {MAX_VALUES} values", path=path)
    try:
        content: Message = _validators()[raw.topic if raw.topic in WORLD_TOPICS else _kind(raw)].validate_json(data)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False, include_context=False)[0]
        place = ".".join(map(str, first["loc"]))
        raise misfit(raw, f"{place}: {first['msg']}" if place else first["msg"], path=path) from None
    return content


def value_of(raw: RawMessage, decode: Callable[[Message], T], *, path: Path) -> T:
    """Return the value of a JSON message.

    Args:
        raw: The message.
        decode: Content -> value.
        path: Its file, for the error.

    Raises:
        RecordingError: The message does not fit.
    """
    content = content_of(raw, path=path)
    with reading(raw, path=path):
        return decode(content)


@contextmanager
def reading(raw: RawMessage, *, path: Path) -> Iterator[None]:
    """Convert exceptions of the block about an invalid message into a RecordingError."""
    try:
        yield
    except FAULTS as error:
        raise misfit(raw, error, path=path) from error


def misfit(raw: RawMessage, why: object, *, path: Path) -> RecordingError:
    """Return the error for a message that mjsim did not write."""
    return unfit(f"'{path}': the message on '{raw.topic:.60}' at {raw.time * 1e-9:.3f} s", why)


def unfit(label: str, why: object) -> RecordingError:
    """Return the error for a recording, or a part of one, that mjsim did not write."""
    line = f"{label} is not as mjsim writes it: {why!s:.160}"
    return RecordingError("".join(character if character.isprintable() else " " for character in line))


def _kind(raw: RawMessage) -> str:
    return raw.topic.rpartition("/")[2]


@cache
def _validators() -> dict[str, SchemaValidator]:
    """Return the validators for each topic of the world and each kind of topic of a robot."""
    schemas = WORLD_TOPICS | ROBOT_TOPICS | ARM_TOPICS | MECHANISM_TOPICS | dict(SENSOR_TOPICS.values())
    return {name: SchemaValidator(_core(schema, schema["definitions"])) for name, schema in schemas.items()}


def _core(schema: Schema, definitions: Schema) -> CoreSchema:
    """Return the validator for a schema made by `json_schema`."""
    if "$ref" in schema:
        schema = definitions[schema["$ref"].rpartition("/")[2]]
    kind = schema["type"]
    if isinstance(kind, list):
        inner = [_core({**schema, "type": each}, definitions) for each in kind if each != "null"]
        return core_schema.nullable_schema(*inner)
    return _CORES[kind](schema, definitions)


def _object(schema: Schema, definitions: Schema) -> CoreSchema:
    required = schema["required"]
    fields = {
        name: core_schema.typed_dict_field(_core(field, definitions), required=name in required)
        for name, field in schema["properties"].items()
    }
    return core_schema.typed_dict_schema(fields)


def _array(schema: Schema, definitions: Schema) -> CoreSchema:
    return core_schema.list_schema(
        _core(schema["items"], definitions), min_length=schema.get("minItems"), max_length=schema.get("maxItems")
    )


def _string(schema: Schema, definitions: Schema) -> CoreSchema:
    if "enum" in schema:
        return core_schema.literal_schema(schema["enum"])
    return core_schema.str_schema(strict=True)


_CORES: dict[str, Callable[[Schema, Schema], CoreSchema]] = {
    "object": _object,
    "array": _array,
    "string": _string,
    "number": lambda schema, definitions: core_schema.float_schema(strict=True, allow_inf_nan=False),
    "integer": lambda schema, definitions: core_schema.int_schema(strict=True),
    "boolean": lambda schema, definitions: core_schema.bool_schema(strict=True),
}
