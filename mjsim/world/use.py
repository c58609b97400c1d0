"""Make the modules that a world file names with `use:`; the only place where code of the user's is brought in."""

import importlib
import importlib.util
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

from mjsim.errors import UsageError, did_you_mean
from mjsim.world.running import Use
from mjsim.world.source import Source


def make_module(use: Use, source: Source) -> Any:
    """Return an instance of the class that `use` names, made with the keys beside it.

    Args:
        use: 'dotted.module:Class' or 'file.py:Class', and keyword arguments.
        source: Where the world was written; a file is looked for beside it, or in the working folder when the
            world has no folder.

    Raises:
        UsageError: There is no such module or class, or it does not take these arguments.
    """
    place, _, name = use.use.rpartition(":")
    module = _load_file(place, source.folder or Path.cwd()) if place.endswith(".py") else _load_dotted(place)
    made = getattr(module, name, None)
    if made is None:
        known = [n for n, value in vars(module).items() if isinstance(value, type) and not n.startswith("_")]
        raise UsageError(f"no class '{name}' in {place}{did_you_mean(name, known)}")
    try:
        return made(**use.arguments())
    # Whatever the user's code raises is told in one line; this is the boundary to that code.
    except Exception as error:
        raise UsageError(f"{use.use} cannot be made: {type(error).__name__}: {error}") from error


def _load_dotted(name: str) -> ModuleType:
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        raise UsageError(f"no module '{error.name}', which 'use: {name}' needs; install it or mend the name") from error


def _load_file(name: str, folder: Path) -> ModuleType:
    path = (folder / name).resolve()
    if not path.is_relative_to(folder.resolve()):
        raise UsageError(f"'{name}' leaves the folder of the world; keep it beside the world file")
    if not path.is_file():
        raise UsageError(f"no file '{name}' in {folder}")
    spec = importlib.util.spec_from_file_location(path.stem, path)
    if spec is None or spec.loader is None:
        raise UsageError(f"'{name}' is not a Python file")
    module = importlib.util.module_from_spec(spec)
    # Dataclasses and pickling look a class's module up by name.
    sys.modules.setdefault(path.stem, module)
    # Files beside it can be imported, as they could if it were run itself; last, so that they hide nothing installed.
    if str(path.parent) not in sys.path:
        sys.path.append(str(path.parent))
    try:
        spec.loader.exec_module(module)
    except SyntaxError as error:
        raise UsageError(f"{path.name}:{error.lineno}: {error.msg}") from error
    # As above: what the file raises while it is read is the user's to mend, in one line.
    except Exception as error:
        raise UsageError(f"{path.name} cannot be read: {type(error).__name__}: {error}") from error
    return module
