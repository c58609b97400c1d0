"""Python files beside a world: imported from checked source, separately for each run."""

import builtins
import importlib.util
import os
import re
import sys
import weakref
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType
from typing import Any

from mjsim.modules.boundary import BESIDE
from mjsim.modules.hosts import read_code
from mjsim.modules.python.import_places import place_of
from mjsim.sentences import Sentence
from mjsim.world import Source

_ODD = re.compile(r"\W")


class Beside(MetaPathFinder, Loader):
    """Imports the files of one folder.

    Its modules are visible only to files of that folder: their `import` statements use it first, and it gives each
    module a unique name. Only source is compiled; bytecode is neither read nor written.
    """

    def __init__(self, source: Source, folder: Path) -> None:
        """Start without imports.

        Args:
            source: Source of the world; it may forbid files.
            folder: Folder of the files.
        """
        self._source, self._folder = source, folder
        self._name = next(name for number in range(1, sys.maxsize) if (name := f"{BESIDE}{number}") not in sys.modules)
        self._in_use = 0
        self._known: dict[str, bool] = {}
        root = ModuleType(self._name)
        root.__path__ = [str(folder)]
        self._modules: dict[str, ModuleType] = {self._name: root}
        self._builtins = {**vars(builtins), "__import__": self._import}

    def run(self, path: Path) -> ModuleType:
        """Return a new module from a file of the folder, even if the same file was imported before.

        Raises:
            UsageError: The file may not run, or cannot be read.
        """
        self._stand()
        name = stem = f"{self._name}.{_ODD.sub('_', path.stem)}"
        number = 1
        while name in self._modules:
            number += 1
            name = f"{stem}_{number}"
        spec = self._spec(name, path)
        module = importlib.util.module_from_spec(spec)
        # Dataclasses and pickling look up the module of a class by name; so do files that import this one.
        sys.modules[name] = module
        self.exec_module(module)
        return module

    @contextmanager
    def keeping(self) -> Iterator[Callable[[object], None]]:
        """Keep the modules until the block ends, or until the object given to the yielded function no longer exists."""
        self._in_use += 1
        cleanups = [self._let_go]

        def keep(made: object) -> None:
            # An object that cannot be weakly referenced, because it has slots, keeps them forever.
            with suppress(TypeError):
                weakref.finalize(made, self._let_go)
            cleanups.clear()

        try:
            yield keep
        finally:
            for let_go in cleanups:
                let_go()

    def _stand(self) -> None:
        """Register with the import system."""
        for name, module in self._modules.items():
            sys.modules.setdefault(name, module)
        if self not in sys.meta_path:
            sys.meta_path.insert(0, self)

    def _let_go(self) -> None:
        self._in_use -= 1
        if self._in_use == 0:
            for name in self._modules:
                sys.modules.pop(name, None)
            if self in sys.meta_path:
                sys.meta_path.remove(self)

    def _is_beside(self, top: str) -> bool:
        """Return whether the first part of a name is that of one of the files."""
        if top not in self._known:
            self._known[top] = place_of(self._folder, top) is not None
        return self._known[top]

    def _import(
        self,
        name: str,
        given: Mapping[str, object] | None = None,
        local: Mapping[str, object] | None = None,
        fromlist: Sequence[str] | None = (),
        level: int = 0,
    ) -> ModuleType:
        """Execute an `import` statement of one of the files: `__import__` among the builtins that they see."""
        top = name.partition(".")[0]
        if level == 0 and not self._is_beside(top):
            return builtins.__import__(name, given, local, fromlist or (), level)
        self._stand()
        whole = f"{self._name}.{name}" if level == 0 else name
        module = builtins.__import__(whole, given, local, fromlist or (), level)
        return module if level or fromlist else sys.modules[f"{self._name}.{top}"]

    def find_spec(self, name: str, path: Sequence[str] | None, target: ModuleType | None = None) -> ModuleSpec | None:
        """Return the spec of one of the files; None for other modules.

        Raises:
            ModuleNotFoundError: The module would be in the folder, but does not exist.
        """
        parent, _, last = name.rpartition(".")
        if parent != self._name and not parent.startswith(f"{self._name}."):
            return None
        for folder in map(Path, path or ()):
            place = folder / last
            for file in (place / "__init__.py", folder / f"{last}.py"):
                if os.path.isfile(file):
                    return self._spec(name, file)
            if os.path.isdir(place):
                spec = ModuleSpec(name, self, is_package=True)
                spec.submodule_search_locations = [str(place)]
                return spec
        raise ModuleNotFoundError(Sentence("No module named '{name}'", name), name=name)

    def _spec(self, name: str, path: Path) -> ModuleSpec:
        spec = ModuleSpec(name, self, origin=str(path))
        spec.has_location = True
        if path.name == "__init__.py":
            spec.submodule_search_locations = [str(path.parent)]
        return spec

    def exec_module(self, module: ModuleType) -> None:
        """Run the source of a module."""
        spec = module.__spec__
        assert spec is not None
        self._modules[spec.name] = module
        if spec.origin is None:
            return  # A folder without __init__.py.
        vars(module)["__builtins__"] = self._builtins
        try:
            text = read_code(Path(spec.origin), self._source)
            exec(compile(text, spec.origin, "exec", dont_inherit=True), vars(module))
        except BaseException:
            del self._modules[spec.name]
            sys.modules.pop(spec.name, None)
            raise


def importer_of(source: Source, folder: Path) -> Beside:
    """Return the importer of a folder's files for the run of a source.

    Args:
        source: Source of the world.
        folder: The folder of the world, or one below it.
    """
    known: dict[Path, Any] = source.live.setdefault("python", {})
    if folder not in known:
        known[folder] = Beside(source, folder)
    made: Beside = known[folder]
    return made
