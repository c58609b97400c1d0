"""Layout of values as YAML."""

import io
import re
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq
from ruamel.yaml.scalarstring import DoubleQuotedScalarString

from mjsim.world.items import SENSOR_KINDS
from mjsim.world.yaml import plain_value

FIRST = (
    *("mjsim", "name", "use", "preset", *SENSOR_KINDS, "box", "cylinder", "sphere", "ramp", "steps", "model", "image"),
    *("marker", "time", "move", "to", "type", "segment", "on", "at", "heading_deg"),
)
"""Keys in their preferred order; all others follow, in the order of the models."""
WIDTH = 120
"""Maximum line length [characters]."""
_LINE = 110
"""An item of at most this length is written on one line [characters]."""
_PLAIN = re.compile(r"[A-Za-z_./][\w./+-]*(:[\w./+-]+)*")
"""Text that never needs quotes, unless it reads as another kind of value."""


def plain(value: Any) -> Any:
    """Return a value as lists and dicts, with integers instead of floats like 1.0, and preferred keys first."""
    if isinstance(value, dict):
        order = sorted(value, key=lambda key: FIRST.index(key) if key in FIRST else len(FIRST))
        return {key: plain(value[key]) for key in order}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        return int(value)
    return value


def styled(value: Any, *, depth: int = 0) -> Any:
    """Return a value with layout: what is short or contains only numbers is on one line."""
    if isinstance(value, str):
        return _text(escaped(value))
    if not isinstance(value, (dict, list)):
        return value
    inner = value.values() if isinstance(value, dict) else value
    flat = isinstance(value, list) and not any(isinstance(item, dict) for item in inner)
    short = depth > 1 and len(str(value)) <= _LINE and not any(isinstance(item, dict) and item for item in inner)
    styled_value: CommentedMap | CommentedSeq
    if isinstance(value, dict):
        styled_value = CommentedMap({_text(key): styled(item, depth=depth + 1) for key, item in value.items()})
    else:
        styled_value = CommentedSeq([styled(item, depth=depth + 1) for item in value])
    if flat or short or not value:
        styled_value.fa.set_flow_style()
    return styled_value


def escaped(text: str) -> str:
    """Return a text with expressions escaped, so that it stands for itself."""
    return text.replace("${", "$${")


def _text(value: str) -> str:
    """Return a text with quotes if needed; ruamel.yaml omits some that its own parser requires."""
    return value if _PLAIN.fullmatch(value) and plain_value(value) == value else DoubleQuotedScalarString(value)


def round_trip() -> YAML:
    """Return a YAML reader and writer that preserves comments."""
    yaml = YAML(typ="rt", pure=True)
    yaml.width = WIDTH
    yaml.indent(mapping=2, sequence=4, offset=2)
    yaml.preserve_quotes = True
    return yaml


def dumped(tree: Any) -> str:
    """Return a tree as YAML text."""
    stream = io.StringIO()
    round_trip().dump(tree, stream)
    return stream.getvalue()
