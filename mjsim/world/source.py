"""Where a world came from, and the files that it names."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path, PurePosixPath


@dataclass(frozen=True, slots=True)
class Source:
    """Where a world was written; two worlds are equal wherever they come from."""

    file: str = field(default="world", compare=False)
    """As errors name it."""
    text: str | None = field(default=None, compare=False)
    """What was read; None for a world built in Python."""
    folder: Path | None = field(default=None, compare=False)
    """Where files that it names are looked for first."""
    attached: Mapping[str, bytes] = field(default_factory=dict, compare=False)
    """Files that came with it, as in a recording; they go before the folder."""


BUILT = Source()
"""A world that was built in Python."""


def read_asset(name: str, source: Source) -> bytes:
    """Return a file that a world names: attached, else beside the world file, else shipped with mjsim.

    Raises:
        ValueError: There is no such file, or its path leaves the folders where it may be.
    """
    if name in source.attached:
        return source.attached[name]
    path = PurePosixPath(name)
    if path.is_absolute() or ".." in path.parts or "\\" in name:
        raise ValueError(f"path '{name}' leaves its folder; name a file beside the world file or in assets")
    if source.folder is not None:
        base = source.folder.resolve()
        beside = (base / path).resolve()
        if beside.is_file():
            if not beside.is_relative_to(base):
                raise ValueError(f"path '{name}' leaves its folder; name a file beside the world file or in assets")
            return beside.read_bytes()
    shipped = resources.files("mjsim.assets").joinpath(name)
    if shipped.is_file():
        return shipped.read_bytes()
    raise ValueError(f"no file '{name}' beside the world file or in assets")
