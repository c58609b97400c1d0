"""Small random faults in the statements of a source: each changes one span of the text."""

import ast
import functools
import itertools
import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

FLIPPED: dict[type[ast.cmpop], Sequence[str]] = {
    ast.Lt: ("<=", ">"),
    ast.LtE: ("<", ">"),
    ast.Gt: (">=", "<"),
    ast.GtE: (">", "<"),
    ast.Eq: ("!=",),
    ast.NotEq: ("==",),
    ast.In: ("not in",),
    ast.NotIn: ("in",),
    ast.Is: ("is not",),
    ast.IsNot: ("is",),
}
SWAPPED: dict[type[ast.operator], str] = {ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*", ast.FloorDiv: "/"}
NAMES = {"sin": "cos", "cos": "sin", "min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum"}
NAMES |= {"any": "all", "all": "any", "append": "extend", "floor": "ceil", "ceil": "floor"}
DROPPED = {"radians", "degrees", "deg2rad", "rad2deg", "abs", "sqrt", "hypot", "wrap", "wrap_angle", "inv", "cumsum"}
DROPPED |= {"sorted", "reversed", "transpose", "square", "exp", "log", "deepcopy", "copy", "normalized", "round"}
METHODS = {"inverse", "T", "copy", "transpose", "casefold", "lower", "strip"}
"""Operations after a value that may be dropped."""
Place = tuple[int, int, int, int]
"""Line and byte where a span begins, and where it ends."""


@dataclass(frozen=True, slots=True)
class Fault:
    """One changed span of a source; the number of lines stays."""

    path: Path
    line: int
    kind: str
    source: str
    """The whole file with the fault."""
    before: str
    after: str
    """The lines that differ."""
    function: str | None
    """Qualified name of the outermost function around it; None outside of functions."""


def draw(paths: Sequence[Path], *, number: int, seed: int) -> list[Fault]:
    """Return random faults, each in a different statement, among all that can have one."""
    rng = random.Random(seed)
    sites = [(_Text(path), *found) for path in sorted(paths) for found in _sites(path)]
    rng.shuffle(sites)
    drawn = (_one(rng, *site) for site in sites)
    return list(itertools.islice(filter(None, drawn), number))


def _one(rng: random.Random, text: "_Text", statement: ast.stmt, function: str | None) -> Fault | None:
    """Return one fault of a statement, of a random kind; None where it can have none."""
    edits = list(_edits(statement, text, inside=function is not None))
    if not edits:
        return None
    kind = rng.choice(sorted({edit.kind for edit in edits}))
    fault = rng.choice([edit for edit in edits if edit.kind == kind]).fault(text, function)
    try:
        ast.parse(fault.source)
    except SyntaxError:  # such as a starred argument without its call
        return None
    return fault


def _sites(path: Path) -> Iterator[tuple[ast.stmt, str | None]]:
    """Yield each statement with the name of the outermost function around it."""
    yield from _statements(ast.parse(path.read_text(encoding="utf-8")).body, "", None)


def _statements(body: list[ast.stmt], within: str, function: str | None) -> Iterator[tuple[ast.stmt, str | None]]:
    for node in body:
        if isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING":
            continue
        yield node, function
        name, inner = within, function
        if isinstance(node, ast.ClassDef):
            name = f"{within}{node.name}."
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            inner = function or within + node.name
        for field in ("body", "orelse", "finalbody"):
            yield from _statements(getattr(node, field, []), name, inner)
        for part in (*getattr(node, "handlers", []), *getattr(node, "cases", [])):
            yield from _statements(part.body, name, inner)


@dataclass(frozen=True, slots=True)
class _Edit:
    kind: str
    place: Place
    new: str

    def fault(self, text: "_Text", function: str | None) -> Fault:
        first, start, last, end = self.place
        head, tail = text.lines[first - 1][:start], text.lines[last - 1][end:]
        changed = head + self.new.encode() + tail
        old = b"".join(text.lines[first - 1 : last])
        source = b"".join([*text.lines[: first - 1], changed, *text.lines[last:]]).decode()
        return Fault(text.path, first, self.kind, source, old.decode().strip(), changed.decode().strip(), function)


class _Text:
    """A source and its lines, as bytes, in which syntax trees count columns."""

    def __init__(self, path: Path) -> None:
        self.path = path

    @functools.cached_property
    def lines(self) -> list[bytes]:
        return self.path.read_bytes().splitlines(keepends=True)

    def of(self, node: ast.expr | ast.stmt) -> str:
        """Return the text of a node."""
        return self.span(_place(node))

    def span(self, place: Place) -> str:
        """Return the text between two places."""
        first, start, last, end = place
        if first == last:
            return self.lines[first - 1][start:end].decode()
        inner = self.lines[first : last - 1]
        return b"".join([self.lines[first - 1][start:], *inner, self.lines[last - 1][:end]]).decode()


def _edits(statement: ast.stmt, text: _Text, *, inside: bool) -> Iterator[_Edit]:
    """Yield the faults of a statement itself, not of those in its body; texts of messages and types are left alone."""
    if isinstance(statement, ast.Import | ast.ImportFrom | ast.Raise | ast.Assert | ast.FunctionDef | ast.ClassDef):
        return
    yield from _whole(statement, text, inside=inside)
    for node in _expressions(statement):
        for kind, where, new in _expression(node, text):
            old = text.of(where)
            if new.count("\n") == old.count("\n") and new != old:
                yield _Edit(kind, _place(where), new)


def _whole(statement: ast.stmt, text: _Text, *, inside: bool) -> Iterator[_Edit]:
    match statement:
        case ast.If(test=test, body=[ast.Raise()], orelse=[]):
            yield _Edit("guard removed", _place(test), f"(False{_rest(test)})")
        case ast.If(test=test) | ast.While(test=test) if not _is_true(test):
            yield _Edit("condition negated", _place(test), f"not ({text.of(test)})")
        case ast.Continue() | ast.Break():
            yield _Edit("jump dropped", _place(statement), "pass")
        case ast.Expr(value=ast.Call() | ast.Await()) if inside:
            yield _Edit("call dropped", _place(statement), "pass" + _rest(statement))
        case ast.Assign(targets=[ast.Attribute() | ast.Subscript()]) if inside:
            yield _Edit("state not kept", _place(statement), "pass" + _rest(statement))
        case ast.With(items=[ast.withitem(context_expr=held, optional_vars=None)]) if "lock" in ast.unparse(held):
            yield _Edit("lock dropped", _place(held), "__import__('contextlib').nullcontext()")
        case ast.AugAssign(target=target, op=ast.Add() | ast.Sub() as op, value=value):
            name, rest = text.of(target), text.of(value)
            yield _Edit("sign", _place(statement), f"{name} {SWAPPED[type(op)]}= {rest}")


def _rest(node: ast.stmt | ast.expr) -> str:
    """Return the line breaks that keep the numbers of the lines that follow."""
    return "\n" * ((node.end_lineno or node.lineno) - node.lineno)


def _is_true(test: ast.expr) -> bool:
    return isinstance(test, ast.Constant)


def _expressions(statement: ast.stmt) -> Iterator[ast.expr]:
    """Yield the expressions of a statement."""
    for name, value in ast.iter_fields(statement):
        if name in {"body", "orelse", "finalbody", "handlers", "cases", "annotation", "targets", "target"}:
            continue
        for node in value if isinstance(value, list) else [value]:
            if isinstance(node, ast.withitem):
                yield from _within(node.context_expr)
            elif isinstance(node, ast.expr):
                yield from _within(node)


def _within(node: ast.expr) -> Iterator[ast.expr]:
    if isinstance(node, ast.JoinedStr):
        return
    yield node
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.expr):
            yield from _within(child)
        elif isinstance(child, ast.keyword | ast.comprehension):
            yield from (
                inner for each in ast.iter_child_nodes(child) if isinstance(each, ast.expr) for inner in _within(each)
            )


def _expression(node: ast.expr, text: _Text) -> Iterator[tuple[str, ast.expr, str]]:
    of = text.of
    match node:
        case ast.Compare(left=left, ops=[op], comparators=[right]):
            for sign in FLIPPED[type(op)]:
                yield "comparison", node, _between(node, left, right, text, sign)
        case ast.BinOp(left=left, op=ast.MatMult(), right=right):
            yield "frames swapped", node, f"{of(right)} @ {of(left)}"
        case ast.BinOp(left=left, op=op, right=right) if type(op) in SWAPPED and not (
            _is_text(left) or _is_text(right)
        ):
            sign = SWAPPED[type(op)]
            kind = "sign" if sign in "+-" else "unit"
            yield kind, node, _between(node, left, right, text, sign)
        case ast.BoolOp(op=op, values=[left, right]):
            yield "and, or", node, _between(node, left, right, text, "or" if isinstance(op, ast.And) else "and")
        case ast.UnaryOp(op=ast.Not() | ast.USub(), operand=operand):
            yield "not or minus dropped", node, of(operand)
        case ast.IfExp(test=test):
            yield "condition negated", test, f"(not ({of(test)}))"
        case ast.Constant(value=bool() as value):
            yield "constant", node, str(not value)
        case ast.Constant(value=int() as value):
            yield "off by one", node, str(value + 1)
        case ast.Constant(value=float() as value) if value:
            yield "constant", node, repr(value * 2)
        case ast.Call(func=function, args=[first, *more], keywords=keywords):
            name = _last_name(function)
            if name in NAMES:
                yield "other function", function, of(function)[: -len(name)] + NAMES[name]
            if name in DROPPED and not more and not keywords:
                yield "conversion dropped", node, f"({of(first)})"
            if more and _is_place(first) and _is_place(more[0]) and of(first) != of(more[0]):
                yield "arguments swapped", node, _exchanged(node, first, more[0], text)
        case ast.Call(func=ast.Attribute(value=value, attr=name), args=[]) if name in METHODS:
            yield "conversion dropped", node, of(value)
        case ast.Attribute(value=value, attr="T"):
            yield "conversion dropped", node, of(value)


def _between(node: ast.expr, left: ast.expr, right: ast.expr, text: _Text, sign: str) -> str:
    """Return an expression of two parts with another operator; brackets and breaks around it stay."""
    gap = text.span((left.end_lineno, left.end_col_offset, right.lineno, right.col_offset))
    for old in sorted(["not in", "is not", "<=", ">=", "==", "!=", "//", "and", "or", "in", "is", *"<>+-*/"], key=len)[
        ::-1
    ]:
        if old in gap:
            gap = gap.replace(old, sign, 1)
            break
    start = text.span((node.lineno, node.col_offset, left.end_lineno, left.end_col_offset))
    end = text.span((right.lineno, right.col_offset, node.end_lineno, node.end_col_offset))
    return start + gap + end


def _exchanged(node: ast.expr, first: ast.expr, second: ast.expr, text: _Text) -> str:
    parts = [
        text.span((node.lineno, node.col_offset, first.lineno, first.col_offset)),
        text.span(_place(second)),
        text.span((first.end_lineno, first.end_col_offset, second.lineno, second.col_offset)),
        text.span(_place(first)),
        text.span((second.end_lineno, second.end_col_offset, node.end_lineno, node.end_col_offset)),
    ]
    return "".join(parts)


def _place(node: ast.expr | ast.stmt) -> Place:
    return node.lineno, node.col_offset, node.end_lineno or node.lineno, node.end_col_offset or node.col_offset


def _last_name(function: ast.expr) -> str:
    return getattr(function, "attr", getattr(function, "id", ""))


def _is_place(node: ast.expr) -> bool:
    return isinstance(node, ast.Name | ast.Attribute | ast.Subscript)


def _is_text(node: ast.expr) -> bool:
    return isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str))
