"""Formats values for world files: single ones for insertion into a text, and whole worlds."""

import math
import re
from decimal import Decimal
from typing import Any

from mjsim.world.items import SENSOR_KINDS
from mjsim.world.yaml import plain_value, quoted

FIRST = (
    *("mjsim", "name", "use", "preset", *SENSOR_KINDS, "box", "cylinder", "sphere", "ramp", "steps", "model", "image"),
    *("marker", "time", "move", "to", "type", "segment", "on", "at", "heading_deg"),
)
"""Keys in their preferred order; all others follow, in the order of the models."""
WIDTH = 120
"""Maximum line length [characters]."""
_PLAIN = re.compile(r"[A-Za-z_./][\w./+-]*(:[\w./+-]+)*", re.ASCII)
"""Text that never needs quotes, unless it reads as another kind of value."""
_TYPED, _SHOWN = 6, 4
"""Numbers with up to the first number of decimals were typed; those with more were computed, and are rounded to the
second."""
_STEP = 2


def rounded(value: Any) -> Any:
    """Return a value with computed numbers rounded."""
    if isinstance(value, dict):
        return {key: rounded(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [rounded(item) for item in value]
    return _rounded(value) if isinstance(value, float) else value


def literal(value: Any) -> Any:
    """Return a value with expressions escaped, so that each text stands for itself, and preferred keys first."""
    if isinstance(value, dict):
        order = sorted(value, key=lambda key: FIRST.index(key) if key in FIRST else len(FIRST))
        return {key: literal(value[key]) for key in order}
    if isinstance(value, (list, tuple)):
        return [literal(item) for item in value]
    return escaped(value) if isinstance(value, str) else value


def escaped(text: str) -> str:
    """Return a text with expressions escaped, so that it stands for itself."""
    return text.replace("${", "$${")


def scalar(value: Any, *, style: str = "") -> str:
    """Return a scalar as text; `style` is the previous quote character."""
    if value is None:
        return "null"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return _number(value)
    text = str(value)
    if style == "'" and text.isprintable():
        return "'" + text.replace("'", "''") + "'"
    if not style and _PLAIN.fullmatch(text) and plain_value(text) == text:
        return text
    return quoted(text)


def inline(value: Any) -> str:
    """Return a value on one line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{scalar(str(key))}: {inline(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(inline, value)) + "]"
    return scalar(value)


def folded(line: str, *, column: int, indent: int) -> str:
    """Return what `inline` gives with line breaks where it would be too long, between whole items where possible.

    Args:
        line: The text.
        column: Column at which it begins.
        indent: Indentation of further lines.
    """
    lines, begin = list[str](), 0
    breaks = _breaks(line)
    while column + len(line) - begin > WIDTH:
        whole = [at for at, between in breaks if begin < at <= begin + WIDTH - column and between]
        within = [at for at, _ in breaks if begin < at <= begin + WIDTH - column]
        later = [at for at, _ in breaks if at > begin]
        if not later:
            break
        at = (whole or within or later[:1])[-1]
        lines.append(line[begin:at])
        begin, column = at + 1, indent
    return f"\n{' ' * indent}".join([*lines, line[begin:]])


def _breaks(line: str) -> list[tuple[int, bool]]:
    """Return where a line may be broken: behind commas; and whether a list, a mapping or a key begins there."""
    found, around, quoted, at = list[tuple[int, bool]](), "", False, 0
    while at < len(line):
        mark = line[at]
        if quoted:
            at += mark == "\\"
            quoted = mark != '"'
        elif mark == '"':
            quoted = True
        elif mark in "[{":
            around += mark
        elif mark in "]}":
            around = around[:-1]
        elif line.startswith(", ", at):
            found.append((at + 1, around[-1:] != "[" or line[at + 2] in "[{"))
        at += 1
    return found


def below(value: Any, indent: int) -> list[str]:
    """Return the lines of a non-empty mapping or list below a key or after a dash, with an indentation."""
    if isinstance(value, list):
        return [line for item in value for line in dashed(item, indent)]
    return [line for key, item in value.items() for line in keyed(str(key), item, indent)]


def dashed(value: Any, indent: int, *, whole: bool = False) -> list[str]:
    """Return the lines of a list item; `whole` puts each of its keys on its own line."""
    space = " " * indent
    line = f"{space}- {inline(value)}"
    if not value or not isinstance(value, dict):
        return [line]
    if len(line) <= WIDTH and not whole and not any(map(_is_listed, value.values())):
        return [line]
    first, *rest = below(value, indent + _STEP)
    return [f"{space}- {first.lstrip()}", *rest]


def keyed(name: str, value: Any, indent: int) -> list[str]:
    """Return the lines of a key and its value."""
    space = " " * indent
    line = f"{space}{scalar(name)}: {inline(value)}"
    if not _is_listed(value) and (len(line) <= WIDTH or not value or not isinstance(value, (dict, list))):
        return [line]
    if isinstance(value, list) and not _is_listed(value):
        return _filled(f"{space}{scalar(name)}: [", value)
    return [f"{space}{scalar(name)}:", *below(value, indent + _STEP)]


def _filled(head: str, value: list[Any]) -> list[str]:
    """Return a list in brackets with its items filling lines, aligned with the first."""
    lines, space = [head], " " * len(head)
    for number, item in enumerate(value):
        text = inline(item) + ("]" if number == len(value) - 1 else ",")
        if number and len(lines[-1]) + 1 + len(text) > WIDTH:
            lines.append(space + text)
        else:
            lines[-1] += f" {text}" if number else text
    return lines


def _is_listed(value: Any) -> bool:
    """Return whether a value is a list of mappings, each of which gets a line."""
    return isinstance(value, list) and any(isinstance(item, dict) for item in value)


def _rounded(value: float) -> float:
    digits = -int(Decimal(repr(value)).as_tuple().exponent)
    if digits <= _TYPED:
        return value
    return round(value, _SHOWN) if abs(value) >= 10.0**-2 else float(f"{value:.{_SHOWN}g}")


def _number(value: float) -> str:
    if not math.isfinite(value):
        return ".nan" if math.isnan(value) else f"{'-' if value < 0 else ''}.inf"
    if value.is_integer() and abs(value) < 1e15:
        return str(int(value))
    return format(Decimal(repr(value)), "f") if 1e-12 < abs(value) < 1e15 else repr(value)
