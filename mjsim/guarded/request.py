"""Requests of the parent to the child that decodes files."""

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mjsim.errors import MjsimError, PhysicsFault, RecordingError, UsageError
from mjsim.guarded.limits import Allowance

OWN_ERRORS: Mapping[str, type[MjsimError]] = {
    each.__name__: each for each in (UsageError, RecordingError, PhysicsFault)
}
"""Errors of mjsim that reach the caller unchanged, with their message only."""
LENGTH = struct.Struct("<Q")
"""Length of a request [bytes], before its pickle."""


@dataclass(frozen=True, slots=True)
class Permission:
    """The first request: what this child may do."""

    function: str
    """A function 'module:name'; its module is imported before the limits hold."""
    allowance: Allowance
    """Limits until the first call, which has its own."""
    folders: tuple[Path, ...]
    """Folders and files that may be read."""
    scratch: Path | None
    """Folder in which files may be created."""
    parent: int
    """Number of the process that started the child."""


@dataclass(frozen=True, slots=True)
class Call:
    """A further request: a function 'module:name' and its arguments."""

    function: str
    arguments: tuple[Any, ...]
    keywords: Mapping[str, Any]
    folder: str | None
    """Working folder of the caller."""
