"""The host of Python modules: they run in the simulator's process."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from mjsim.modules.hosts import Defect, Host, Offer, Provenance
from mjsim.modules.python.find import class_defects
from mjsim.modules.python.needed_files import python_files
from mjsim.modules.python.offers import offers_in
from mjsim.modules.python.reads import key_of, readings_of
from mjsim.world import Source, Use


class PythonHost(Host):
    """Imports 'file.py:Class' beside a world file, and 'package.module:Class'."""

    def speaks(self, use: str) -> bool:
        """Return whether it names a class of a Python module."""
        place, colon, name = use.rpartition(":")
        return bool(place and colon) and name.isidentifier()

    def origin(self, use: str) -> Provenance:
        """Return the origin of the class."""
        if self.place(use).endswith(".py"):
            return "beside"
        return "shipped" if use.startswith("mjsim.algorithms.") else "installed"

    def place(self, use: str) -> str:
        """Return the file or the dotted module that contains the class."""
        return use.rpartition(":")[0]

    def runs(self, file: str) -> bool:
        """Return whether a file is Python."""
        return file.endswith(".py")

    def defects(self, use: Use, role: str, source: Source) -> Iterator[Defect]:
        """Yield what does not exist or is not Python, keys that the class does not accept, and missing methods."""
        return class_defects(use, role, source)

    def files(self, uses: Sequence[Use], source: Source, *, data: bool = True) -> Mapping[str, bytes]:
        """Return the files of the classes, of their imports, and of files beside them that they name."""
        return python_files(uses, source, data=data)

    def offers(self, files: Sequence[tuple[Path, str]]) -> Iterator[Offer]:
        """Yield the classes in files with the suffix .py."""
        return offers_in([(path, place) for path, place in files if path.suffix == ".py"])

    def readings(self, use: Use, role: str, source: Source) -> Iterator[str]:
        """Yield the fields of `Observation` that the class and all that it calls read."""
        return readings_of(use, source)

    def key(self, use: Use, name: str, source: Source) -> object:
        """Return the argument of the class."""
        return key_of(use, name, source)

    def at_hand(self, named: str) -> tuple[Path | None, str]:
        """Return the folder of a file, and its name with the class; a dotted module is found anywhere."""
        place, _, name = named.rpartition(":")
        file = Path(place)
        return (file.parent, f"{file.name}:{name}") if place.endswith(".py") else (None, named)

    def make(self, use: Use, source: Source, *, role: str, robot: str) -> Any:
        """Return an instance of the class."""
        from mjsim.modules.python.load import make_class  # Slow to load, and not needed to inspect files.

        return make_class(use, source, role=role, robot=robot)
