"""Faces: the public names of a package, each loaded with its module when it is first used.

A package's `__init__.pyi` lists them, one `from .module import name as name` per line. Type checkers and editors read
it directly, and `face` reads it at run time, so `import mjsim` loads only the modules that are used.
"""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import lazy_loader

_OFFER = re.compile(r"^from \.([\w.]*) import (\w+) as \2$", re.MULTILINE)
Attached = tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]
"""The `__getattr__`, `__dir__` and `__all__` of a package."""


def face(package: str, file: str) -> Attached:
    """Return the face of a package.

    Args:
        package: Its `__name__`.
        file: Its `__file__`; the list is beside it.
    """
    modules: set[str] = set()
    names: dict[str, list[str]] = {}
    # Not parsed as Python, as lazy_loader.attach_stub does: that is slower, and can fail in two threads at once.
    for module, name in _OFFER.findall(Path(file).with_suffix(".pyi").read_text(encoding="utf-8")):
        if module:
            names.setdefault(module, []).append(name)
        else:
            modules.add(name)
    attached: Attached = lazy_loader.attach(package, modules, names)
    return attached
