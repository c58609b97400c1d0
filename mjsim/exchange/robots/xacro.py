"""Xacro: resolves properties, arguments and conditions; macros and the rest need the xacro library, if installed.

References:
    https://wiki.ros.org/xacro
"""

import ast
import math
import operator
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from mjsim.errors import UsageError
from mjsim.exchange.robots.xacro_eval import guarded
from mjsim.models import RefusedXmlError, checked_xml
from mjsim.syntax import parse_python

SPACE = "xacro"
"""Part of all namespaces that files give xacro's elements, such as http://ros.org/wiki/xacro."""
MAX_BYTES = 8_000_000
DEEPEST = 16
"""Maximum nesting of properties."""
LONGEST = 10_000
"""Maximum length of a value [characters]."""
ROBOT_PARTS = {"link", "joint", "material", "gazebo", "transmission", "sensor", "ros2_control", "group", "mujoco"}
"""Elements of a robot in URDF, including extensions of other programs."""
PLAIN = {"arg", "property", "if", "unless"}
"""Elements that are resolved here."""
PREFIXES = {"namespace", "prefix", "tf_prefix"}
"""Prefixes of part names that a launch file sets, often undeclared; empty here."""
_SUBSTITUTION = re.compile(r"\$\{([^{}]*)\}|\$\((arg|find|env|optenv|eval)\s+([^()]*)\)")
_OPERATORS: Mapping[type, Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}
_FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    name: getattr(math, name) for name in ("sin", "cos", "tan", "sqrt", "radians", "degrees", "atan2", "asin", "acos")
}


class NotPlainError(Exception):
    """Raised for what this module does not resolve; its text names the xacro feature."""


def resolved(data: bytes, path: Path, *, arguments: Mapping[str, str], find: Callable[[str], Path | None]) -> bytes:
    """Return a robot's description with all xacro elements resolved; other files are returned unchanged.

    Args:
        data: Contents of the file.
        path: Path of the file, for the library and for messages.
        arguments: Values of `xacro:arg`.
        find: Returns the folder of a ROS package, or None.

    Raises:
        UsageError: The file is invalid, or needs the library, which is not installed.
    """
    if b"xacro" not in data and b"$" not in data:
        return data
    root = parsed(data, path)
    if root.tag != "robot" or not (b"$" in data or any(_word(item.tag) is not None for item in root.iter())):
        return data
    _refuse_bare_macros(root, path)
    try:
        return _plain(root, path, arguments)
    except NotPlainError as error:
        return _by_library(path, str(error), arguments, find)


def _refuse_bare_macros(root: ElementTree.Element, path: Path) -> None:
    """Reject macros called without `xacro:`, as in very old files: they would be ignored silently.

    Raises:
        UsageError: The file contains one.
    """
    for item in root:
        if "}" not in item.tag and item.tag not in ROBOT_PARTS and not len(item) and not (item.text or "").strip():
            raise UsageError(
                f"{path}: <{item.tag}> is not a URDF element; if it calls a macro, write <xacro:{item.tag}>"
            )


def parsed(data: bytes, path: Path) -> ElementTree.Element:
    """Return the root element of an XML file of bounded size without entity definitions.

    Raises:
        UsageError: The file is not XML, is too large, or declares a document type.
    """
    if len(data) > MAX_BYTES:
        raise UsageError(f"{path} has {len(data) / 1e6:.0f} MB of XML; it must have at most {MAX_BYTES // 10**6} MB")
    try:
        return ElementTree.fromstring(checked_xml(data))
    except ElementTree.ParseError as error:
        line, column = error.position
        problem = str(error).partition(":")[0]
        raise UsageError(f"{path}:{line}:{column + 1}: this is not XML ({problem}); correct it") from None
    except RefusedXmlError as error:
        raise UsageError(f"{path} {error}") from None


def _word(tag: str) -> str | None:
    """Return the name of a xacro element; None for other elements."""
    space, _, word = tag[1:].partition("}") if tag.startswith("{") else ("", "", tag)
    return word if SPACE in space.lower() else None


def _plain(root: ElementTree.Element, path: Path, arguments: Mapping[str, str]) -> bytes:
    for item in root.iter():
        word = _word(item.tag)
        if word is not None and word not in PLAIN:
            raise NotPlainError(f"<xacro:{word}>")
    known = _Names(path, arguments)
    for item in root.iter():
        known.declare(item)
    _put_in(root, known)
    return ElementTree.tostring(root)


def _put_in(element: ElementTree.Element, known: "_Names") -> None:
    """Substitute values in an element, and remove its xacro elements."""
    for key, value in element.attrib.items():
        element.set(key, known.text(value))
    if element.text and "$" in element.text:
        element.text = known.text(element.text)
    children: list[ElementTree.Element] = []
    for child in element:
        word = _word(child.tag)
        if word in ("if", "unless"):
            if known.holds(child.get("value", "")) == (word == "if"):
                _put_in(child, known)
                children += list(child)
        elif word is None:
            _put_in(child, known)
            children.append(child)
    element[:] = children


class _Names:
    """Properties and arguments of a file."""

    def __init__(self, path: Path, arguments: Mapping[str, str]) -> None:
        self._path, self._given = path, arguments
        self._arguments: dict[str, str] = dict(arguments)
        self._properties: dict[str, str] = {}

    def declare(self, element: ElementTree.Element) -> None:
        """Store a property or an argument that an element declares."""
        word, name = _word(element.tag), element.get("name", "")
        if word == "arg":
            if "default" in element.attrib:
                self._arguments.setdefault(name, element.attrib["default"])
        elif word == "property":
            if "value" not in element.attrib:
                raise NotPlainError("<xacro:property> of a block")
            self._properties[name] = element.attrib["value"]

    def text(self, text: str, depth: int = 0) -> str:
        """Return a text with all values substituted."""
        if "$" not in text:
            return text
        if depth > DEEPEST or len(text) > LONGEST:
            raise UsageError(f"{self._path}: the value '{text[:60]}' refers to itself; correct its xacro:property")
        new = _SUBSTITUTION.sub(lambda match: self._value(match, depth), text)
        if new == text:
            # Such as calls within the parentheses of $(eval ...).
            raise NotPlainError(f"'{text[:60]}'")
        return self.text(new, depth + 1)

    def holds(self, text: str) -> bool:
        """Return whether a condition is true."""
        value = self.text(text).strip().lower()
        if value in ("true", "1", "1.0"):
            return True
        if value in ("false", "0", "0.0"):
            return False
        raise NotPlainError(f"the condition '{text[:60]}'")

    def _value(self, match: "re.Match[str]", depth: int) -> str:
        expression, command, rest = match.groups()
        if expression is not None:
            return self._of_expression(expression.strip(), depth)
        if command == "find":
            return f"package://{rest.strip()}"
        if command != "arg":
            raise NotPlainError(f"$({command} ...)")
        if rest.strip() not in self._arguments:
            raise UsageError(f"{self._path}: xacro:arg '{rest.strip()}' has no value; give --arg {rest.strip()}=VALUE")
        return self._arguments[rest.strip()]

    def _of_expression(self, text: str, depth: int) -> str:
        if text in self._properties:
            return self.text(self._properties[text], depth + 1)
        if text in self._given or text in PREFIXES:
            return self._given.get(text, "")
        if text.isidentifier() and text not in ("pi", "True", "False"):
            raise UsageError(f"{self._path}: no xacro:property '{text}'; declare it, or give --arg {text}=VALUE")
        try:
            value = self._number(_expression(text), depth)
        except (SyntaxError, ValueError, ZeroDivisionError, OverflowError, RecursionError, TypeError, MemoryError):
            raise NotPlainError(f"the expression '{text[:60]}'") from None
        return str(value) if isinstance(value, bool | str) else format(value, ".12g")

    def _number(self, node: ast.AST, depth: int) -> Any:
        match node:
            case ast.Constant(value=bool() | int() | float() | str() as value):
                return value
            case ast.Name(id="pi"):
                return math.pi
            case ast.Name(id=name) if name in self._properties:
                text = self.text(self._properties[name], depth + 1)
                try:
                    return float(text)
                except ValueError:
                    return text
            case ast.UnaryOp(op=op, operand=operand) if type(op) in _OPERATORS:
                return _OPERATORS[type(op)](self._number(operand, depth))
            case ast.BinOp(left=left, op=op, right=right) if type(op) in _OPERATORS:
                return _OPERATORS[type(op)](float(self._number(left, depth)), float(self._number(right, depth)))
            case ast.Compare(left=left, ops=[op], comparators=[right]) if type(op) in _OPERATORS:
                return _OPERATORS[type(op)](self._number(left, depth), self._number(right, depth))
            case ast.Call(func=ast.Name(id=name), args=values, keywords=[]) if name in _FUNCTIONS:
                return _FUNCTIONS[name](*(float(self._number(value, depth)) for value in values))
        raise ValueError(ast.dump(node)[:60])


def _by_library(path: Path, feature: str, arguments: Mapping[str, str], find: Callable[[str], Path | None]) -> bytes:
    """Return the library's result for a file."""
    try:
        # mypy: the library ships no types.
        import xacro
        from xacro import substitution_args
    except ImportError:
        raise UsageError(
            f"{path} uses {feature} of xacro; type: pip install xacro,"
            f" or expand the file: xacro {path.name} > robot.urdf"
        ) from None

    absent: list[str] = []

    def package_folder(name: str) -> str:
        folder = find(name)
        if folder is None:
            absent.append(name)
            raise UsageError(f"package '{name}' was not found")
        return str(folder)

    before = substitution_args._eval_find
    substitution_args._eval_find = package_folder
    try:
        with guarded(xacro, substitution_args):
            return bytes(xacro.process_file(str(path), mappings=dict(arguments)).toxml().encode())
    except Exception as error:
        if absent:  # The library may have put the error of this into one of its own.
            name = absent[-1]
            message = f"{path} names the package '{name}', which was not found; give --package {name}=DIR"
            raise UsageError(message) from None
        if isinstance(error, UsageError):
            raise
        # The library can raise any exception for an invalid file.
        reason = " ".join(str(error).split())[:200]
        raise UsageError(f"{path} is not valid xacro: {reason}; correct it") from None
    finally:
        substitution_args._eval_find = before


def _expression(text: str) -> ast.expr:
    """Return the syntax tree of one expression; raises SyntaxError for anything else."""
    match parse_python(text.strip()).body:
        case [ast.Expr(value=value)]:
            return value
    raise SyntaxError
