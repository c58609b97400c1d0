"""Reads the docstring below each field of a model from its source, on demand.

Pydantic can read them too, but does so for every model on import, which takes half of the start-up time of `mjsim
check`.
"""

import ast
import inspect
import sys
from collections.abc import Iterator, Mapping
from functools import cache
from itertools import pairwise

from pydantic import BaseModel

from mjsim.syntax import parse_python


def description_of(model: type[BaseModel], field: str) -> str:
    """Return the description of a model's field; '' if there is none."""
    return model.model_fields[field].description or descriptions(model).get(field, "")


@cache
def descriptions(model: type[BaseModel]) -> Mapping[str, str]:
    """Return the docstring below each field of a model, including inherited fields."""
    classes = [kind for kind in reversed(model.__mro__) if issubclass(kind, BaseModel) and kind is not BaseModel]
    found = {name: text for kind in classes for name, text in _docstrings(_classes(kind.__module__)[kind.__name__])}
    return {name: found[name] for name in model.model_fields if name in found}


@cache
def _classes(module: str) -> Mapping[str, ast.ClassDef]:
    tree = parse_python(inspect.getsource(sys.modules[module]))
    return {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}


def _docstrings(kind: ast.ClassDef) -> Iterator[tuple[str, str]]:
    for field, below in pairwise(kind.body):
        match field, below:
            case ast.AnnAssign(target=ast.Name(id=name)), ast.Expr(value=ast.Constant(value=str(text))):
                yield name, inspect.cleandoc(text)
