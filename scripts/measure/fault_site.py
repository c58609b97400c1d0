"""Loaded first, as sitecustomize, by each Python that tests start: puts faults into files, or notes what is called."""

import ast
import builtins
import json
import mmap
import os
from importlib.machinery import SourceFileLoader
from types import CodeType

FOLDER = os.path.dirname(os.path.abspath(__file__))
"""The copy of this file lies beside `fault`, a path and its source, or `probes`: path -> function -> faults."""
_original = SourceFileLoader.get_code
_sources: dict[str, str] = {}
_probes: dict[str, dict[str, list[int]]] = {}


def load() -> None:
    """Take what lies in the folder now: a guarded reader cannot look later."""
    _sources.clear(), _probes.clear()
    if os.path.exists(FOLDER + "/fault"):
        with open(FOLDER + "/fault", encoding="utf-8") as file:
            path, _, source = file.read().partition("\n")
        _sources[path] = source
    if os.path.exists(FOLDER + "/probes"):
        with open(FOLDER + "/probes", encoding="utf-8") as file:
            _probes.update(json.load(file))
        with open(FOLDER + "/reached", "r+b") as file:
            table = mmap.mmap(file.fileno(), 0)
        builtins.__reached__ = lambda numbers: [table.__setitem__(number, 1) for number in numbers]


def changed(path: str) -> CodeType | None:
    """Return the code of a file with its fault, or with its probes; None where it has neither."""
    if path in _sources:
        return compile(_sources[path], path, "exec", dont_inherit=True)
    if path not in _probes:
        return None
    with open(path, encoding="utf-8") as file:
        tree = ast.parse(file.read())
    _probe(tree, "", _probes[path])
    return compile(ast.fix_missing_locations(tree), path, "exec", dont_inherit=True)


def _probe(node: ast.AST, within: str, probes: dict[str, list[int]]) -> None:
    """Let each function begin with a note of the faults in it, and of those in its file outside of functions."""
    for inner in ast.iter_child_nodes(node):
        if not isinstance(inner, ast.FunctionDef | ast.AsyncFunctionDef):
            _probe(inner, f"{within}{inner.name}." if isinstance(inner, ast.ClassDef) else within, probes)
        elif numbers := [*probes.get(within + inner.name, ()), *probes.get("", ())]:
            after = 1 if ast.get_docstring(inner, clean=False) is not None else 0
            inner.body.insert(after, ast.parse(f"__reached__({numbers})").body[0])


def _get_code(self: SourceFileLoader, name: str) -> CodeType | None:
    return changed(self.path) or _original(self, name)


SourceFileLoader.get_code = _get_code
load()
