"""The imports of a package of ours, told from its sources: those in functions, in stubs and in strings count too."""

import ast
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import Self

from mjsim.syntax import parse_python

_QUOTED = re.compile(r"""(["'])(\w+(?:\.\w+)+(?::\w+)?)\1""")
"""A string that may name a module: 'mjsim.env.gym:GymEnvironment'."""


@dataclass(frozen=True, slots=True)
class Import:
    """One name, or one module, that a file imports."""

    file: Path
    line: int
    importer: str
    """Module that imports, dotted."""
    module: str
    """What is imported from: a module as it is written, or a module that the import reaches by its name."""
    name: str | None = None
    """What a package's face or a module is asked for; None for a module as a whole."""

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {self.importer} imports {self.module}"


@dataclass(frozen=True, slots=True)
class _Source:
    """What counts of a file; its syntax tree is not kept, as it is large."""

    imports: Sequence[ast.Import | ast.ImportFrom]
    strings: Sequence[tuple[int, str]]
    """Line and text of those that may name a module."""
    classes: Sequence[str]
    """Public ones at the top."""

    @classmethod
    def of(cls, path: Path) -> Self:
        """Read a file."""
        text = path.read_text(encoding="utf-8")
        tree = parse_python(text)
        return cls(
            [node for node in _statements(tree.body) if isinstance(node, ast.Import | ast.ImportFrom)],
            [(text.count("\n", 0, found.start()) + 1, found[2]) for found in _QUOTED.finditer(text)],
            [node.name for node in tree.body if isinstance(node, ast.ClassDef) and not node.name.startswith("_")],
        )


def _statements(body: Iterable[ast.AST]) -> Iterator[ast.AST]:
    """Yield the statements of a body and those within them, not their expressions."""
    for node in body:
        yield node
        for name in ("body", "handlers", "orelse", "finalbody", "cases"):
            if isinstance(inner := getattr(node, name, None), list):
                yield from _statements(inner)


class Package:
    """The modules of a package and their imports."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.name = folder.name
        self.files = {self._dotted(path): path for path in sorted(folder.rglob("*.py"))}
        self.packages = {module for module, path in self.files.items() if path.name == "__init__.py"}

    def _dotted(self, path: Path) -> str:
        parts = path.relative_to(self.folder).with_suffix("").parts
        return ".".join((self.name, *parts)).removesuffix(".__init__")

    @cached_property
    def _sources(self) -> dict[Path, "_Source"]:
        """What each file and each stub holds."""
        stubs = [self.files[module].with_suffix(".pyi") for module in sorted(self.packages)]
        return {path: _Source.of(path) for path in (*self.files.values(), *stubs) if path.exists()}

    @cached_property
    def imports(self) -> list[Import]:
        """All imports, in the order of files; a face's are those of its stub as well."""
        found = [found for module, path in self.files.items() for found in self._imports_of(module, path)]
        stubs = [(module, self.files[module].with_suffix(".pyi")) for module in sorted(self.packages)]
        return found + [found for module, path in stubs if path.exists() for found in self._imports_of(module, path)]

    @cached_property
    def public_classes(self) -> dict[str, list[str]]:
        """Class without a leading underscore -> modules that define it at their top, or parts that offer it."""
        found: dict[str, set[str]] = {}
        for module, path in self.files.items():
            for name in self._sources[path].classes:
                found.setdefault(name, set()).add(module)
        for package, offered in self.faces.items():
            for name in filter(_is_type, offered if package.count(".") < 2 else ()):  # inner faces are no public ones
                found.setdefault(name, set()).add(self._defining(package, name))
        return {name: sorted(modules) for name, modules in found.items()}

    def _imports_of(self, module: str, path: Path) -> Iterator[Import]:
        source = self._sources[path]
        home = module if module in self.packages else module.rpartition(".")[0]
        for node in source.imports:
            if isinstance(node, ast.Import):
                yield from (Import(path, node.lineno, module, alias.name) for alias in node.names)
            else:
                above = home.split(".")[: len(home.split(".")) - node.level + 1] if node.level else []
                dotted = ".".join((*above, *filter(None, [node.module])))
                yield from (self._import_from(path, node, module, dotted, alias.name) for alias in node.names)
        for line, text in source.strings:
            if target := self._named(text):
                yield Import(path, line, module, target)

    def _import_from(self, path: Path, node: ast.ImportFrom, importer: str, source: str, name: str) -> Import:
        """`from package import module` reaches the module, unless the package offers that name to all."""
        module = f"{source}.{name}"
        own = importer == source or importer.rpartition(".")[0] == source
        if module in self.files and (own or name not in self.faces.get(source, {})):
            return Import(path, node.lineno, importer, module)
        return Import(path, node.lineno, importer, source, name)

    def _named(self, text: str) -> str | None:
        """Return the module that a text such as 'mjsim.env.gym:GymEnvironment' names."""
        module = text.partition(":")[0]
        return module if re.fullmatch(rf"{self.name}(\.\w+)+", module) and module in self.files else None

    @cached_property
    def faces(self) -> dict[str, dict[str, str]]:
        """Package -> name that its stub offers -> module that it comes from."""
        found: dict[str, dict[str, str]] = {}
        for package in self.packages:
            stub = self.files[package].with_suffix(".pyi")
            for node in self._sources[stub].imports if stub in self._sources else ():
                assert isinstance(node, ast.ImportFrom), f"{stub}:{node.lineno}: a face holds nothing but imports"
                source = ".".join(filter(None, [package, node.module]))
                found.setdefault(package, {}).update({alias.asname or alias.name: source for alias in node.names})
        return found

    def _defining(self, module: str, name: str | None) -> str:
        """Follow a name through faces to the module that it comes from."""
        while name in self.faces.get(module, {}):
            source = self.faces[module][name]
            module = f"{module}.{name}" if source == module else source
        return module

    @cached_property
    def module_graph(self) -> dict[str, set[str]]:
        """Module -> modules whose names it uses; faces stand for the modules behind them."""
        graph: dict[str, set[str]] = {module: set() for module in self.files}
        for each in self.imports:
            target = self._defining(each.module, each.name)
            stub = each.file.suffix == ".pyi"
            if not stub and target in self.files and target != each.importer and target != self.name:
                graph[each.importer].add(target)
        return graph

    def package_graph(self, package: str) -> dict[str, set[str]]:
        """Child of a package (module or package) -> its other children that it uses."""
        graph: dict[str, set[str]] = {}
        for importer, targets in self.module_graph.items():
            for target in targets:
                one, other = self._child(package, importer), self._child(package, target)
                if one and other and one != other:
                    graph.setdefault(one, set()).add(other)
        return graph

    def _child(self, package: str, module: str) -> str | None:
        rest = module.removeprefix(f"{package}.")
        return f"{package}.{rest.partition('.')[0]}" if rest != module else None

    def part(self, module: str) -> str | None:
        """First part below the package: 'world' of 'mjsim.world.items'; None for another package's."""
        top, _, rest = module.partition(".")
        return rest.partition(".")[0] if top == self.name else None


def wrong_directions(package: Package, may_import: Mapping[str, set[str]]) -> list[str]:
    """Return the imports of a part from one that it may not import; parts that the table lacks may import all."""
    wrong = []
    for each in package.imports:
        part, other = package.part(each.importer), package.part(each.module)
        if part in may_import and other is not None and other not in may_import[part] | {part}:
            wrong.append(str(each))
    return wrong


def past_faces(package: Package) -> list[str]:
    """Return the imports of what lies inside a package to which the importer does not belong."""
    wrong = []
    for each in package.imports:
        around = each.module.rpartition(".")[0]
        if each.module in package.files and around and not f"{each.importer}.".startswith(f"{around}."):
            wrong.append(str(each))
    return wrong


def own_faces(package: Package) -> list[str]:
    """Return the imports of a module from the face of a package that it lies in."""
    return [
        str(each)
        for each in package.imports
        if each.module in package.packages and each.importer.startswith(f"{each.module}.")
    ]


def module_cycle(package: Package) -> list[str]:
    """Return the modules of one cycle, in order; empty when there is none."""
    return _cycle(package.module_graph)


def package_cycle(package: Package) -> list[str]:
    """Return the parts of one package that import each other in a circle; empty when there are none."""
    return next((cycle for each in sorted(package.packages) if (cycle := _cycle(package.package_graph(each)))), [])


def _is_type(name: str) -> bool:
    """Return whether a name is written as types are, not as functions, modules or constants."""
    return name[0].isupper() and not name.isupper()


def shared_names(packages: Iterable[Package]) -> dict[str, set[str]]:
    """Return the public classes whose name stands in several parts -> those parts; a package without parts is one."""
    parts: dict[str, set[str]] = {}
    for package in packages:
        whole = package.packages == {package.name}
        for name, modules in package.public_classes.items():
            parts.setdefault(name, set()).update(package.name if whole else str(package.part(each)) for each in modules)
    return {name: found for name, found in parts.items() if len(found) > 1}


def _cycle(graph: Mapping[str, set[str]]) -> list[str]:
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []
