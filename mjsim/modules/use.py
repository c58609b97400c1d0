"""`use:` of a world file: finds, checks and creates the module that it names."""

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from mjsim.errors import Problem, UsageError, WorldError
from mjsim.modules.hosts import MAX_BYTES, Defect, Host, Offer, folder_of
from mjsim.modules.octave import OctaveHost
from mjsim.modules.program import ProgramHost
from mjsim.modules.python import PythonHost
from mjsim.sentences import Sentence
from mjsim.world import Source, Use, UserDrive, World, check_world, load_world, problems_at, read_regular

HOSTS: Sequence[Host] = (ProgramHost(), OctaveHost(), PythonHost())
"""One host per language; the first one for a module's language runs it."""


@dataclass(frozen=True, slots=True)
class NamedModule:
    """A module that a world names."""

    use: Use
    role: str
    robot: str
    path: tuple[str | int, ...]
    """Path of the mapping with `use` in the world file."""


@dataclass(frozen=True, slots=True)
class ForeignCode:
    """Code that a world runs and that is not part of mjsim."""

    installed: Sequence[Use]
    """Classes of installed packages, with their keys."""
    files: Mapping[str, bytes]
    """Content of files beside the world, by path, including their imports; and of files elsewhere that a command line
    names, by absolute path."""


def host_of(use: str) -> Host:
    """Return the host for the text of a `use:`.

    Raises:
        UsageError: There is no such host.
    """
    for host in HOSTS:
        if host.speaks(use):
            return host
    raise UsageError(
        Sentence(
            "use: '{use}' names no module; write 'file.py:Class', 'package.module:Class', 'file.m' or 'exec:./program'",
            use,
        )
    )


def make_module(use: Use, source: Source, *, role: str, robot: str) -> Any:
    """Return an instance of the module that a world or a command line names.

    Args:
        use: Its name, and the keys beside it.
        source: Source of the world; a file is searched for in its folder, or in the working folder if it has none.
        role: One of `ROLES`.
        robot: Robot of the module.

    Raises:
        UsageError: It does not exist, or does not accept these keys.
        ModuleFault: It fails, or lacks a method that its role needs.
    """
    return host_of(use.use).make(use, source, role=role, robot=robot)


def modules_of(world: World) -> Iterator[NamedModule]:
    """Yield all modules that a world names for a role."""
    for index, robot in enumerate(world.robots):
        if isinstance(robot.drive, UserDrive):
            yield NamedModule(robot.drive, "drive", robot.name, ("robots", index, "drive"))
    for index, mechanism in enumerate(world.mechanisms):
        for number, actuator in enumerate(mechanism.actuators):
            if (control := getattr(actuator, "controller", None)) is not None:
                path = ("mechanisms", index, "actuators", number, "controller")
                yield NamedModule(control, "controller", mechanism.name, path)
    for name, modules in world.run.drivers.items():
        for role in type(modules).model_fields:
            use = getattr(modules, role)
            if isinstance(use, Use):
                yield NamedModule(use, role, name, ("run", "drivers", name, role))
        for part, control in modules.controllers.items():
            yield NamedModule(control, "controller", name, ("run", "drivers", name, "controllers", part))


def missing_modules(world: World) -> list[Problem]:
    """Return the faults of modules that do not exist, or do not accept the keys beside them; nothing is run."""
    return _problems(world, (found for found in _defects(world) if found[1].missing))


def check_modules(world: World) -> list[Problem]:
    """Return the faults of the modules of a world, as far as their text shows them; nothing is run."""
    return _problems(world, _defects(world))


def load_runnable(path: str | Path) -> World:
    """Return the world of a file, after checking that it is valid and its modules exist.

    Args:
        path: The file, or the name of a shipped world, as for `load_world`.

    Raises:
        UsageError: The file does not exist, or is not such a world.
        WorldError: The world has faults; all are listed.
    """
    world = load_world(path)
    if problems := sorted([*check_world(world), *missing_modules(world)]):
        raise WorldError(problems)
    return world


def require_modules(world: World) -> None:
    """Raise WorldError when a module that a world names does not exist; all faults are listed."""
    if problems := missing_modules(world):
        raise WorldError(problems)


def user_files(world: World) -> dict[str, bytes]:
    """Return the files of all modules that a world names with `use:`, by their paths from its folder.

    Raises:
        UsageError: A file cannot be read.
    """
    files: dict[str, bytes] = {}
    for host, uses in _by_host(world):
        files |= host.files(uses, world.source)
    return files


def foreign_code(world: World) -> ForeignCode:
    """Return the code that a world loads into the process besides that of mjsim; nothing is run."""
    installed: list[Use] = []
    files: dict[str, bytes] = {}
    folder = folder_of(world.source)
    for host, uses in _by_host(world):
        foreign = [use for use in uses if host.origin(use.use) != "shipped"]
        installed += [use for use in foreign if host.origin(use.use) == "installed"]
        try:
            contents = host.files(foreign, world.source, data=False).items()
            # Packages under development are trusted like installed ones.
            files |= {name: data for name, data in contents if host.runs(name) and (folder / name).is_file()}
            found = host.elsewhere(foreign, world.source)
            files |= {str(path): read_regular(path, limit=MAX_BYTES) for path in found}
        except (UsageError, OSError):
            # The error is reported when it is run; nobody can have allowed this content.
            files |= {host.place(use.use): os.urandom(16) for use in foreign if host.origin(use.use) == "beside"}
    return ForeignCode(tuple(installed), files)


def offers_in(files: Sequence[tuple[Path, str]]) -> Iterator[Offer]:
    """Yield the modules in files, in any language; nothing is run.

    Args:
        files: Each with its name in a world file, such as its path from the world's folder.
    """
    for host in HOSTS:
        yield from host.offers(files)


def _by_host(world: World) -> Iterator[tuple[Host, list[Use]]]:
    """Yield the hosts with their modules of a world, including those named within the keys of modules."""
    uses = [each for named in modules_of(world) for each in (named.use, *_within(named.use.arguments()))]
    for host in HOSTS:
        yield host, [use for use in uses if host_of(use.use) is host]


def _defects(world: World) -> Iterator[tuple[NamedModule, Defect]]:
    """Yield the faults of the modules of a world; each text is read once, even if many robots use it."""
    known: dict[tuple[str, str], list[Defect]] = {}
    for named in modules_of(world):
        key = named.role, named.use.model_dump_json()
        if key not in known:
            known[key] = list(host_of(named.use.use).defects(named.use, named.role, world.source))
        for defect in known[key]:
            yield named, defect


def _problems(world: World, defects: Iterable[tuple[NamedModule, Defect]]) -> list[Problem]:
    faults = (((*named.path, defect.key), partial(str, defect.message)) for named, defect in defects)
    return sorted(problems_at(world.source.written, world.source.file, faults))


def _within(value: Any) -> Iterator[Use]:
    """Yield the modules named with `use:` within the keys of a module."""
    if isinstance(value, Mapping):
        if isinstance(value.get("use"), str):
            with suppress(ValidationError):
                yield Use.model_validate(value)
        value = tuple(value.values())
    if isinstance(value, (list, tuple)):
        for item in value:
            yield from _within(item)
