"""A world and all files that it names, to be sent to other machines."""

import hashlib
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from mjsim.modules import user_files
from mjsim.record import named_files, text_of
from mjsim.world import World


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Bundle:
    """Files that runs need besides mjsim: the world, included files, pictures, models, and the user's modules."""

    main: str
    """Path of the world file among them."""
    files: Mapping[str, bytes]
    """Contents by path, relative to a common folder."""
    programs: frozenset[str] = frozenset()
    """Paths of executable files."""

    def digests(self) -> dict[str, str]:
        """Return the SHA-256 of each file by its path, sorted."""
        return {name: hashlib.sha256(data).hexdigest() for name, data in sorted(self.files.items())}

    def unpack(self, folder: Path) -> Path:
        """Write all files into a folder; return the path of the world file.

        Raises:
            OSError: The folder cannot be written.
        """
        for name, data in self.files.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            if not path.is_file() or path.read_bytes() != data:
                path.write_bytes(data)
            if name in self.programs:
                path.chmod(0o755)
        return folder / self.main


def bundle_of(world: World, cases: Sequence[World]) -> Bundle:
    """Return the files that all cases of a sweep need.

    Args:
        world: The original world.
        cases: The same with settings, which may name other pictures and modules.

    Raises:
        UsageError: A module cannot be read.
    """
    included = world.source.included
    files: dict[str, bytes] = {}
    for each in (world, *cases):
        files |= {name: included.get(name) or each.read_asset(name) for name in named_files(each)}
    text = text_of(world, files)
    own: dict[str, bytes] = {}
    for each in (world, *cases):
        own |= user_files(each)
    folder = world.source.folder or Path.cwd()
    main = Path(world.source.file).name if world.source.folder is not None else "world.yaml"
    programs = frozenset(name for name in own if os.access(folder / name, os.X_OK))
    return Bundle(main=main, files={**files, **own, main: text.encode()}, programs=programs)
