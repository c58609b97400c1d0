"""The type of an argument's value by its annotation, as JSON Schema; nothing is evaluated."""

import ast
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

Schema = dict[str, Any]

_PLAIN = {"float": "number", "int": "integer", "bool": "boolean", "str": "string"}
_KINDS: Mapping[str, tuple[str, tuple[type, ...]]] = {
    "number": ("a number", (int, float)),
    "integer": ("a whole number", (int,)),
    "boolean": ("true or false", (bool,)),
    "string": ("text", (str,)),
    "null": ("null", (type(None),)),
    "array": ("a list", (list, tuple)),
}
"""Types of JSON Schema -> their name for people, and those of Python."""
_ROWS = ("Sequence", "list", "Iterable", "Collection")
_NAMED = re.compile(r"[\[(](x, y, z|x, y|minimum, maximum)[\])]")
"""The numbers of a point or a range, as a docstring names them."""
_MAX_DEPTH = 4


def schema_of(annotation: ast.expr | None, about: str, names: Mapping[str, ast.expr]) -> Schema:
    """Return the JSON Schema of an argument: its type, choices, and the count of numbers; {} if anything may be given.

    Args:
        annotation: Annotation of the argument.
        about: Its description, which may name the numbers of a point: `(x, y)`.
        names: Values of names that annotations refer to, such as `Law = Literal["linear", "cubic"]`.
    """
    found = _NAMED.search(about)
    count = None if found is None else found[1].count(",") + 1
    forms = list(_merged(_forms(annotation, names, count, _MAX_DEPTH)))
    if not forms or {} in forms:
        return {}
    return forms[0] if len(forms) == 1 else {"anyOf": forms}


def misfit_of(value: Any, schema: Mapping[str, Any]) -> str | None:
    """Return what a value of another kind must be, such as 'a number'; None if its type fits."""
    if _has_nan(value):
        return "without NaN"
    forms = schema.get("anyOf", [schema])
    if any(_fits(value, form) for form in forms):
        return None
    return " or ".join(_named(form) for form in forms)


def _has_nan(value: Any) -> bool:
    """Return whether a value, or anything in a list or mapping, is not a number."""
    if isinstance(value, Mapping):
        value = list(value.values())
    return any(map(_has_nan, value)) if isinstance(value, (list, tuple)) else value != value


def _fits(value: Any, form: Mapping[str, Any]) -> bool:
    if "enum" in form:
        return value in form["enum"]
    kinds = _KINDS.get(form.get("type", ""))
    return kinds is None or (isinstance(value, kinds[1]) and (bool in kinds[1] or not isinstance(value, bool)))


def _named(form: Mapping[str, Any]) -> str:
    return " or ".join(map(str, form["enum"])) if "enum" in form else _KINDS[form["type"]][0]


def _forms(node: ast.expr | None, names: Mapping[str, ast.expr], count: int | None, depth: int) -> Iterator[Schema]:
    """Yield the forms of a value; {} for one that is not known."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitOr):
        yield from _forms(node.left, names, count, depth)
        yield from _forms(node.right, names, count, depth)
    elif isinstance(node, ast.Constant) and node.value is None:
        yield {"type": "null"}
    elif isinstance(node, ast.Name) and node.id in _PLAIN:
        yield {"type": _PLAIN[node.id]}
    elif isinstance(node, ast.Name) and node.id in names and depth:
        yield from _forms(names[node.id], names, count, depth - 1)
    elif isinstance(node, ast.Subscript) and isinstance(node.value, ast.Name):
        yield _generic(node.value.id, node.slice, names, count, depth)
    else:
        yield {}


def _generic(name: str, inner: ast.expr, names: Mapping[str, ast.expr], count: int | None, depth: int) -> Schema:
    parts = inner.elts if isinstance(inner, ast.Tuple) else [inner]
    if name == "Literal":
        return {"enum": [part.value for part in parts if isinstance(part, ast.Constant)]}
    if name == "tuple" and not any(isinstance(part, ast.Constant) for part in parts):
        return _row(parts[0], names, len(parts), depth) if len({ast.dump(part) for part in parts}) == 1 else {}
    if name in _ROWS or name == "tuple":
        return _row(parts[0], names, count, depth)
    return {}


def _row(entry: ast.expr, names: Mapping[str, ast.expr], count: int | None, depth: int) -> Schema:
    """Return the schema of a list of a fixed count of numbers, or of such rows; {} for any count."""
    forms = list(_forms(entry, names, count, depth - 1)) if depth else []
    if len(forms) != 1 or not forms[0]:
        return {}
    if forms[0].get("type") == "array":
        return {"type": "array", "items": forms[0]}
    return {"type": "array", "items": forms[0], "minItems": count, "maxItems": count} if count else {}


def _merged(forms: Iterable[Schema]) -> Iterator[Schema]:
    """Yield forms without repetition; all choices are one form."""
    kept: list[Schema] = []
    choices: Sequence[Any] = ()
    for form in forms:
        if "enum" in form:
            choices = list(dict.fromkeys([*choices, *form["enum"]]))
        elif form not in kept:
            kept.append(form)
    yield from ([{"enum": choices}, *kept] if choices else kept)
