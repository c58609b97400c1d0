"""The host of modules in Python: they run in the simulator's own process."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from mjsim.modules.hosts import Doubt, Host, Offer, Provenance
from mjsim.modules.python.files import python_files
from mjsim.modules.python.find import class_doubts
from mjsim.modules.python.offers import offers_in
from mjsim.world import Source, Use


class PythonHost(Host):
    """Imports 'file.py:Class' beside a world file, and 'package.module:Class'."""

    def speaks(self, use: str) -> bool:
        """Return whether it names a class of a Python module."""
        place, colon, name = use.rpartition(":")
        return bool(place and colon) and name.isidentifier()

    def origin(self, use: str) -> Provenance:
        """Return where the class comes from."""
        if self.place(use).endswith(".py"):
            return "beside"
        return "shipped" if use.startswith("mjsim.algorithms.") else "installed"

    def place(self, use: str) -> str:
        """Return the file or the dotted module that the class is in."""
        return use.rpartition(":")[0]

    def runs(self, file: str) -> bool:
        """Return whether a file is Python."""
        return file.endswith(".py")

    def doubts(self, use: Use, role: str, source: Source) -> Iterator[Doubt]:
        """Yield what is not there or not Python, which keys the class does not take, and which methods it lacks."""
        return class_doubts(use, role, source)

    def files(self, uses: Sequence[Use], source: Source) -> Mapping[str, bytes]:
        """Return the files of the classes, of what they import, and of what stands beside them and is named in them."""
        return python_files(uses, source)

    def offers(self, files: Sequence[tuple[Path, str]]) -> Iterator[Offer]:
        """Yield the classes of files that end in .py."""
        return offers_in([(path, place) for path, place in files if path.suffix == ".py"])

    def at_hand(self, named: str) -> tuple[Path | None, str]:
        """Return the folder of a file, and its name with the class; a dotted module is found anywhere."""
        place, _, name = named.rpartition(":")
        file = Path(place)
        return (file.parent, f"{file.name}:{name}") if place.endswith(".py") else (None, named)

    def make(self, use: Use, source: Source, *, role: str, robot: str) -> Any:
        """Return an instance of the class."""
        from mjsim.modules.python.load import make_class  # Slow to load for those who only look at files.

        return make_class(use, source, role=role, robot=robot)
