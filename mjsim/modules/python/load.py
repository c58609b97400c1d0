"""Creates live Python modules; the only place where user code is imported."""

import importlib
import inspect
import os
from pathlib import Path
from types import ModuleType
from typing import Any

from mjsim.errors import ModuleFault, UsageError, did_you_mean
from mjsim.modules.boundary import end_copy, error_text, fault_of
from mjsim.modules.hosts import beside
from mjsim.modules.python.find import parts_of
from mjsim.modules.python.user_files import Beside, importer_of
from mjsim.modules.roles import misfit
from mjsim.sentences import Sentence
from mjsim.world import Source, Use


def make_class(use: Use, source: Source, *, role: str, robot: str) -> Any:
    """Return an instance of the class that `use` names, created with the keys beside it.

    Args:
        use: 'dotted.module:Class' or 'file.py:Class', and keyword arguments.
        source: Origin of the world.
        role: Role of the module.
        robot: Name of the robot.

    Raises:
        UsageError: There is no such module or class, or it does not accept these arguments.
        ModuleFault: The file cannot be imported, or the class does not fit its role, or its constructor raises.
    """
    place, _, name = use.use.rpartition(":")
    load = _Loader(role, name, robot)
    path = _file(place, source)
    if path is None:
        return load.made(use, load.installed(place))
    folder = importer_of(source, path.parent)
    with folder.keeping() as keep:
        made = load.made(use, load.file(folder, path))
        keep(made)
    return made


def _file(place: str, source: Source) -> Path | None:
    """Return the file of a module beside the world; None for a dotted name."""
    try:
        if place.endswith(".py"):
            return beside(place, source)
        parts_of(place)
    except ValueError as error:
        raise UsageError(str(error)) from None
    return None


class _Loader:
    """Runs the user's code; its exceptions become faults of the module."""

    def __init__(self, role: str, name: str, robot: str) -> None:
        self._who = role, name, robot

    def fault(self, problem: str) -> ModuleFault:
        return fault_of(*self._who, 0.0, problem)

    def guarded(self, function: Any, named: dict[str, Any] | None = None) -> Any:
        process = os.getpid()
        try:
            made = function(**named or {})
        except (KeyboardInterrupt, UsageError, ModuleFault):
            raise
        # This is the boundary to user code: all its exceptions are reported on one line.
        except BaseException as error:
            end_copy(process, error)
            raise self.fault(error_text(error)) from error
        end_copy(process)
        return made

    def installed(self, name: str) -> ModuleType:
        module: ModuleType = self.guarded(lambda: _import(name))
        return module

    def file(self, folder: Beside, path: Path) -> ModuleType:
        module: ModuleType = self.guarded(lambda: folder.run(path))
        return module

    def made(self, use: Use, module: ModuleType) -> Any:
        """Return an instance of the class in a module."""
        place, _, name = use.use.rpartition(":")
        made = getattr(module, name, None)
        if made is None:
            known = [n for n, value in vars(module).items() if isinstance(value, type) and not n.startswith("_")]
            raise UsageError(
                Sentence("no class '{name}' in {place}{did_you_mean}", name, place, did_you_mean(name, known))
            )
        if problem := misfit(self._who[0], made):
            raise self.fault(problem)
        _require_keys(use, made)
        return self.guarded(made, use.arguments())


def _import(name: str) -> ModuleType:
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{name}.".startswith(f"{error.name}."):
            raise  # One of its imports is missing.
        of = "" if error.name == name else f", which 'use: {name}' needs"
        raise UsageError(Sentence("no module '{name}'{of}; install it or correct the name", error.name, of)) from error


def _require_keys(use: Use, made: type) -> None:
    """Raise UsageError if a class does not accept the keys beside `use`."""
    try:
        signature = inspect.signature(made)
    except (TypeError, ValueError):
        return  # It is implemented in C, or its signature cannot be determined.
    keys = signature.parameters
    if all(key.kind is not key.VAR_KEYWORD for key in keys.values()):
        for key in use.arguments():
            if key not in keys:
                raise UsageError(
                    Sentence("{name} takes no '{key}'{did_you_mean}", made.__name__, key, did_you_mean(key, keys))
                )
    try:
        signature.bind(**use.arguments())
    except TypeError as error:
        raise UsageError(Sentence("{use} cannot be created: {error}", use.use, error)) from error
