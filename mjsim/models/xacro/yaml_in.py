"""Plain values of YAML files that a robot's description reads; tags make no objects, and aliases are counted."""

import math
from collections.abc import Callable, Iterable
from typing import Any

import yaml

from mjsim.models.xacro.budget import Value, XacroBudget, XacroError
from mjsim.sentences import Sentence

MAX_BYTES = 256_000
STEPS_PER_NODE = 10
"""Steps that a value costs."""
UNITS = {
    "!radians": 1.0,
    "!degrees": math.pi / 180,
    "!meters": 1.0,
    "!millimeters": 0.001,
    "!foot": 0.3048,
    "!inches": 0.0254,
}
"""Tags of numbers with a unit, by the factor to rad or m."""
_PREFIX = "tag:yaml.org,2002:"
MERGE = f"{_PREFIX}merge"


def plain_yaml(data: bytes, file: str, budget: XacroBudget, evaluate: Callable[[str], Value]) -> Value:
    """Return the contents of a YAML file.

    Args:
        data: Contents of the file, YAML 1.1 as xacro reads it.
        file: Its name in messages.
        budget: Counts values, those behind aliases as often as they are used.
        evaluate: Returns the value of an expression, for numbers with a unit.

    Raises:
        XacroError: It is invalid or too large, or uses other tags.
    """
    if len(data) > MAX_BYTES:
        raise XacroError(
            Sentence("{file} has more than {max_bytes} kB of YAML; make it smaller", file, MAX_BYTES // 1000)
        )
    try:
        root = yaml.compose(data.decode("utf-8-sig"), Loader=yaml.SafeLoader)
        return budget.keep(None if root is None else _Reader(budget, evaluate).value(root))
    except (yaml.YAMLError, UnicodeDecodeError, RecursionError, TypeError) as error:
        mark = getattr(error, "problem_mark", None)
        at = f":{mark.line + 1}:{mark.column + 1}" if mark else ""
        raise XacroError(Sentence("{file}{at} is not YAML of plain values; correct it", file, at)) from None


class _Reader:
    """Converts the nodes of a file to values."""

    def __init__(self, budget: XacroBudget, evaluate: Callable[[str], Value]) -> None:
        self._budget, self._evaluate = budget, evaluate
        self._scalars = yaml.constructor.SafeConstructor()

    def value(self, node: Any) -> Any:
        """Return the value of a node."""
        self._budget.spend(STEPS_PER_NODE)
        with self._budget.deeper(4):
            if isinstance(node, yaml.MappingNode) and node.tag == f"{_PREFIX}map":
                return dict(self._entries(node))
            if isinstance(node, yaml.SequenceNode) and node.tag == f"{_PREFIX}seq":
                return [self.value(item) for item in node.value]
            if isinstance(node, yaml.ScalarNode):
                return self._scalar(node)
        raise XacroError(Sentence("the YAML tag {tag:.60} is not allowed in robot files; leave it out", node.tag))

    def _entries(self, node: Any) -> Iterable[tuple[Any, Any]]:
        """Yield the entries of a mapping, first those that it merges from others by `<<`."""
        for key, value in node.value:
            if key.tag == MERGE:
                for other in [value] if isinstance(value, yaml.MappingNode) else reversed(value.value):
                    if not isinstance(other, yaml.MappingNode):
                        raise XacroError("the value of << in a YAML file must be a mapping or a list of mappings")
                    yield from self.value(other).items()
        for key, value in node.value:
            if key.tag != MERGE:
                yield self.value(key), self.value(value)

    def _scalar(self, node: Any) -> Value:
        if node.tag in UNITS:
            number = self._evaluate(node.value)
            if not isinstance(number, int | float):
                raise XacroError(Sentence("{tag} {value:.40} is not a number; write one", node.tag, node.value))
            return float(number) * UNITS[node.tag]
        match node.tag.removeprefix(_PREFIX):
            case "str" | "timestamp" | "value":
                return str(node.value)
            case "int":
                return int(_number(self._scalars.construct_yaml_int, node))
            case "float":
                return float(_number(self._scalars.construct_yaml_float, node))
            case "bool":
                return bool(self._scalars.construct_yaml_bool(node))
            case "null":
                return None
        raise XacroError(Sentence("the YAML tag {tag:.60} is not allowed in robot files; leave it out", node.tag))


def _number(construct: Callable[[Any], Any], node: Any) -> Any:
    try:
        return construct(node)
    except (ValueError, OverflowError):
        raise XacroError(Sentence("'{value:.40}' in a YAML file is not a number; correct it", node.value)) from None
