"""A world with all that it names, as files that go anywhere."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from mjsim.record.writer import named_files, text_of
from mjsim.sweep.modules import user_files
from mjsim.world import World


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Bundle:
    """All files that runs need besides mjsim: the world, what it includes and shows, and the user's modules."""

    main: str
    """Which of them is the world file."""
    files: Mapping[str, bytes]
    """By their paths from one folder."""

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
        return folder / self.main


def bundle_of(world: World, cases: Sequence[World]) -> Bundle:
    """Return what all cases of a sweep need.

    Args:
        world: As it was written.
        cases: The same with settings, which may name other pictures and modules.

    Raises:
        UsageError: A module cannot be read.
    """
    included = world.source.included
    files: dict[str, bytes] = {}
    for each in (world, *cases):
        files |= {name: included.get(name) or each.read_asset(name) for name in named_files(each)}
    text = text_of(world, files)
    for each in (world, *cases):
        files |= user_files(each)
    main = Path(world.source.file).name if world.source.folder is not None else "world.yaml"
    return Bundle(main=main, files={**files, main: text.encode()})
