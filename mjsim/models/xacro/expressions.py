"""Computes expressions of xacro files: an allow-list of Python's syntax, applied to plain values.

Nothing here evaluates text as Python or looks up an attribute of a Python value: `a.b` is the entry `b` of a
dictionary or of a namespace of the file, `a.b(...)` an entry of a table of functions.
"""

import ast
from collections.abc import Callable, Iterator, Mapping
from typing import Any, TypeAlias

from mjsim.models.xacro.budget import TooLargeError, Value, XacroBudget, XacroError, likely, weight_of
from mjsim.models.xacro.scope import Scope
from mjsim.models.xacro.xacro_functions import BINARY, COMPARISONS, METHODS, UNARY, Function, Module
from mjsim.sentences import Sentence
from mjsim.syntax import parse_python

MAX_CHARACTERS = 4000
"""Maximum length of an expression [characters]."""
Known: TypeAlias = Value | Function | Module | Scope
"""Values that a name may have."""
_FAULTS = (TypeError, ValueError, ArithmeticError, LookupError)
"""Exceptions of operations and functions for unsuitable values."""


def evaluated(text: str, lookup: Callable[[str], Known], budget: XacroBudget) -> Value:
    """Return the value of an expression.

    Args:
        text: Text of the expression.
        lookup: Returns what a name stands for; raises XacroError.
        budget: Counts steps and sizes.

    Raises:
        XacroError: It is invalid, does not fit its values, or is too large.
    """
    try:
        value: Value = _Evaluation(lookup, budget).value(_tree(text))
        return value
    except TooLargeError:
        raise XacroError(
            Sentence("'{text:.60}' gives a number or a text that is too large; make it smaller", text.strip())
        ) from None
    except XacroError:
        raise
    except _FAULTS as error:
        problem = " ".join(str(error).split())
        raise XacroError(
            Sentence("'{text:.60}' cannot be computed ({problem:.100}); correct it", text.strip(), problem)
        ) from None


def _tree(text: str) -> ast.expr:
    """Return the syntax tree of one expression."""
    if len(text) > MAX_CHARACTERS:
        raise XacroError(
            Sentence("an expression has more than {max_characters} characters; make it shorter", MAX_CHARACTERS)
        )
    try:
        match parse_python(text.strip()).body:
            case [ast.Expr(value=tree)]:
                return tree
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        pass
    raise XacroError(Sentence("'{text:.60}' is not an expression; correct it", text.strip()))


class _Evaluation:
    """Walks the syntax tree of one expression."""

    def __init__(self, lookup: Callable[[str], Known], budget: XacroBudget) -> None:
        self._lookup, self._budget = lookup, budget

    def value(self, node: ast.AST) -> Any:
        """Return the plain value of a part."""
        self._budget.spend(1)
        form = _FORMS.get(type(node))
        if form is None:
            raise XacroError(
                Sentence("{name} is not allowed in expressions; compute it in another way", type(node).__name__)
            )
        with self._budget.deeper(3):
            return form(self, node)

    def constant(self, node: ast.Constant) -> Any:
        """Return a number or a text."""
        return self._budget.keep(node.value)

    def name(self, node: ast.Name | ast.Attribute) -> Any:
        """Return the value of a name, or of an entry with a dot."""
        found = self._known(node)
        if isinstance(found, Function | Module | Scope):
            raise XacroError(
                Sentence("'{unparse:.40}' is a function or a namespace; write what is in it", ast.unparse(node))
            )
        return found

    def _known(self, node: ast.AST) -> Any:
        """Return what a name, or an entry with a dot, refers to; the value of any other node."""
        match node:
            case ast.Name(id=name):
                return self._lookup(name)
            case ast.Attribute(value=base, attr=name):
                with self._budget.deeper(2):
                    return self._entry(self._known(base), name)
            case _:
                return self.value(node)

    def _entry(self, holder: Known, name: str) -> Any:
        if isinstance(holder, Scope):
            return holder.lookup(name)
        entries: Mapping[Any, Any] = holder.members if isinstance(holder, Module) else {}
        if isinstance(holder, dict):
            entries = holder
        if name not in entries:
            suggestion = likely(name, (key for key in entries if isinstance(key, str)))
            raise XacroError(
                Sentence(
                    "there is no '{name:.40}' in this {text}{suggestion}",
                    name,
                    type(holder).__name__.lower(),
                    suggestion,
                )
            )
        return entries[name]

    def call(self, node: ast.Call) -> Any:
        """Call a function of the table, or a method of a value."""
        function, first = self._function(node.func)
        if any(word.arg is None for word in node.keywords):
            raise XacroError("** is not allowed in expressions; give the values one by one")
        given = [*first, *(self._known(each) if function.higher else self.value(each) for each in node.args)]
        return self._apply(function, given, {word.arg or "": self.value(word.value) for word in node.keywords})

    def _function(self, node: ast.expr) -> tuple[Function, list[Value]]:
        """Return a function, and for a method the value on which it is called."""
        if isinstance(node, ast.Attribute):
            holder = self._known(node.value)
            method = METHODS.get(type(holder), {}).get(node.attr)
            if method is not None:
                return method, [holder]
        found = self._known(node) if isinstance(node, ast.Name | ast.Attribute) else None
        if not isinstance(found, Function):
            raise XacroError(
                Sentence("'{unparse:.40}' is not a function of xacro; compute it in another way", ast.unparse(node))
            )
        return found, []

    def _apply(self, function: Function, given: list[Any], named: Mapping[str, Value]) -> Any:
        plain = [each for each in given if not isinstance(each, Function)]
        self._budget.spend(sum(map(weight_of, [*plain, *named.values()])))
        ahead = [self._call_one] if function.higher else []
        return self._budget.keep(function.run(*ahead, *given, **named))

    def _call_one(self, function: object, values: tuple[Value, ...]) -> Any:
        if not isinstance(function, Function) or function.higher:
            raise XacroError("map and filter take a function of xacro first; name one")
        return self._apply(function, list(values), {})

    def binary(self, node: ast.BinOp) -> Any:
        """Return the result of an operator."""
        operation = BINARY.get(type(node.op).__name__)
        if operation is None:
            raise XacroError(
                Sentence("{name} is not allowed in expressions; compute it in another way", type(node.op).__name__)
            )
        return self._budget.keep(operation(self.value(node.left), self.value(node.right)))

    def unary(self, node: ast.UnaryOp) -> Any:
        """Return the result of an operator."""
        operation = UNARY.get(type(node.op).__name__)
        if operation is None:
            raise XacroError(
                Sentence("{name} is not allowed in expressions; compute it in another way", type(node.op).__name__)
            )
        return self._budget.keep(operation(self.value(node.operand)))

    def boolean(self, node: ast.BoolOp) -> Any:
        """Return the value of `and` or `or`, evaluated as Python does."""
        decides = isinstance(node.op, ast.Or)
        value: Value = None
        for part in node.values:
            value = self.value(part)
            if bool(value) == decides:
                return value
        return value

    def comparison(self, node: ast.Compare) -> bool:
        """Return whether all comparisons of a chain hold."""
        left = self.value(node.left)
        for op, part in zip(node.ops, node.comparators, strict=True):
            right = self.value(part)
            self._budget.spend(weight_of(left) + weight_of(right))
            if not COMPARISONS[type(op).__name__](left, right):
                return False
            left = right
        return True

    def choice(self, node: ast.IfExp) -> Any:
        """Return one of two values."""
        return self.value(node.body if self.value(node.test) else node.orelse)

    def sequence(self, node: ast.List | ast.Tuple) -> Any:
        """Return a list or a tuple."""
        values = [self.value(part) for part in node.elts]
        return self._budget.keep(values if isinstance(node, ast.List) else tuple(values))

    def mapping(self, node: ast.Dict) -> Any:
        """Return a dictionary."""
        if None in node.keys:
            raise XacroError("** is not allowed in expressions; give the values one by one")
        keys = [self.value(key) for key in node.keys if key is not None]
        return self._budget.keep(dict(zip(keys, map(self.value, node.values), strict=True)))

    def subscript(self, node: ast.Subscript) -> Any:
        """Return an entry or a part of a sequence, or an entry of a dictionary."""
        holder = self.value(node.value)
        if isinstance(node.slice, ast.Slice):
            ends = (node.slice.lower, node.slice.upper, node.slice.step)
            return self._budget.keep(holder[slice(*(None if end is None else self.value(end) for end in ends))])
        key = self.value(node.slice)
        return self._entry(holder, key) if isinstance(holder, dict) and isinstance(key, str) else holder[key]

    def comprehension(self, node: ast.ListComp | ast.GeneratorExp) -> Any:
        """Return the list of a comprehension."""
        return self._budget.keep([inner.value(node.elt) for inner in self._turns(node.generators)])

    def _turns(self, loops: list[ast.comprehension]) -> Iterator["_Evaluation"]:
        """Yield an evaluation with the variables of each turn of nested loops."""
        if not loops:
            yield self
            return
        for value in list(self.value(loops[0].iter)):
            self._budget.spend(1)
            inner = _Evaluation(self._with(dict(_assigned(loops[0].target, value))), self._budget)
            if all(inner.value(condition) for condition in loops[0].ifs):
                yield from inner._turns(loops[1:])

    def _with(self, names: Mapping[str, Value]) -> Callable[[str], Known]:
        return lambda name: names[name] if name in names else self._lookup(name)


def _assigned(target: ast.expr, value: Any) -> Iterator[tuple[str, Value]]:
    """Yield the names to which a loop assigns, with their values."""
    match target:
        case ast.Name(id=name):
            yield name, value
        case ast.Tuple(elts=parts):
            for part, each in zip(parts, value, strict=True):
                yield from _assigned(part, each)
        case _:
            raise XacroError("a loop assigns to names only; name its variable")


_FORMS: Mapping[type, Callable[[_Evaluation, Any], Any]] = {
    ast.Constant: _Evaluation.constant,
    ast.Name: _Evaluation.name,
    ast.Attribute: _Evaluation.name,
    ast.Call: _Evaluation.call,
    ast.BinOp: _Evaluation.binary,
    ast.UnaryOp: _Evaluation.unary,
    ast.BoolOp: _Evaluation.boolean,
    ast.Compare: _Evaluation.comparison,
    ast.IfExp: _Evaluation.choice,
    ast.List: _Evaluation.sequence,
    ast.Tuple: _Evaluation.sequence,
    ast.Dict: _Evaluation.mapping,
    ast.Subscript: _Evaluation.subscript,
    ast.ListComp: _Evaluation.comprehension,
    ast.GeneratorExp: _Evaluation.comprehension,
}
"""The syntax of expressions; everything else is refused."""
