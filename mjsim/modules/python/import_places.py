"""Resolution of imports in code beside a world."""

import importlib.util
import os
import sys
from pathlib import Path


def place_of(folder: Path, name: str) -> Path | None:
    """Return the file, or the folder of a package, to which `import name` refers in code of a folder.

    Modules of Python and mjsim take precedence; installed packages do not, except over a folder without `__init__.py`.

    Args:
        folder: Folder of the code.
        name: First part of the imported name.

    Returns:
        None if the name does not refer to anything beside the code.
    """
    if name in sys.stdlib_module_names or name == "mjsim":
        return None
    for path in (folder / name / "__init__.py", folder / f"{name}.py"):
        if os.path.isfile(path):
            return path
    package = folder / name
    return package if os.path.isdir(package) and any(package.glob("*.py")) and not is_installed(name) else None


def is_installed(name: str) -> bool:
    """Return whether the first part of an imported name is a module of Python or an installed one."""
    try:
        return importlib.util.find_spec(name) is not None
    except (ImportError, ValueError):
        return False
