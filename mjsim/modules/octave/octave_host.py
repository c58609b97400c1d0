"""The host of functions in .m files: they run in Octave, one process per module."""

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from mjsim.modules.foreign import (
    key_defects,
    options_of,
    paths_of,
    patience_of,
    read_files,
    require_sound,
)
from mjsim.modules.hosts import Defect, Host, Key, Offer, Provenance, beside, folder_of
from mjsim.modules.octave.installed import find_octave
from mjsim.modules.octave.m_files import MAX_BYTES, FunctionFile, fields_read, is_name, read_function
from mjsim.modules.roles import a_role
from mjsim.sentences import Sentence, number_of
from mjsim.world import Source, Use, holds_file

HEADS: Mapping[str, tuple[str, Sequence[str]]] = {
    "observer": ("z", ("obs", "robot", "state")),
    "estimator": ("est", ("obs", "robot", "state")),
    "navigator": ("cmd", ("obs", "est", "robot", "state")),
    "avoidance": ("cmd", ("cmd", "obs", "robot", "state")),
    "controller": ("tau", ("fast", "wanted", "robot", "state")),
}
"""Role -> what its function returns in addition to the state, and its arguments."""
_READINGS = dict.fromkeys(("z", "id", "R"), "sightings")
"""Fields of `obs` that have other names in `Observation`."""
_CODE_SUFFIXES = (".m", ".oct", ".mex", ".mexa64", ".mexmaci64", ".mexmaca64", ".mexw64", ".p")
_TEXT = re.compile(rb"['\"]([\w./ -]+\.\w+)['\"]")
_MAX_OFFERED = 1_000_000


class OctaveHost(Host):
    """Runs 'file.m' beside a world file."""

    def speaks(self, use: str) -> bool:
        """Return whether it names a .m file."""
        return use.endswith(".m") and ":" not in use

    def origin(self, use: str) -> Provenance:
        """Return 'beside': the file is beside the world."""
        return "beside"

    def place(self, use: str) -> str:
        """Return the file."""
        return use

    def runs(self, file: str) -> bool:
        """Return whether a file is a function, or compiled."""
        return file.endswith(_CODE_SUFFIXES)

    def defects(self, use: Use, role: str, source: Source) -> Iterator[Defect]:
        """Yield what does not exist, and why the function does not fit its role."""
        yield from key_defects(use, role, source)
        try:
            path = beside(use.use, source)
        except ValueError as error:
            yield Defect(str(error))
            return
        if not is_name(path.stem):
            yield Defect(
                Sentence("'{stem}' cannot be the name of a function; a name has letters, digits and '_'", path.stem)
            )
            return
        try:
            found = read_function(path)
        except ValueError as error:
            yield Defect(str(error), missing=False)
            return
        if role in HEADS and (problem := _misfit(found, role)):
            yield Defect(problem, missing=False)

    def files(self, uses: Sequence[Use], source: Source, *, data: bool = True) -> Mapping[str, bytes]:
        """Return the functions beside those named and in their `paths`, and the data files named in their text."""
        home = folder_of(source)
        found: dict[Path, None] = {}
        for use in uses:
            try:
                folders = [beside(use.use, source).parent, *paths_of(use, source)]
            except ValueError:
                continue  # An error will be reported when it is run.
            for path in (path for folder in folders for path in _functions(folder, home)):
                found |= dict.fromkeys([path, *(_data(path, home) if data else ())])
        return read_files(list(found), source)

    def offers(self, files: Sequence[tuple[Path, str]]) -> Iterator[Offer]:
        """Yield the functions whose signatures are exactly those of a role."""
        for path, place in files:
            if path.suffix == ".m" and (role := _role_of(path)) is not None:
                found = read_function(path)
                title = found.name.replace("_", " ").capitalize()
                yield Offer(role=role, use=place, title=title, about=found.about, keys=_KEYS)

    def readings(self, use: Use, role: str, source: Source) -> Iterator[str]:
        """Yield the fields of `Observation` that the file reads from its argument."""
        try:
            path = beside(use.use, source)
            argument = read_function(path).inputs[HEADS[role][1].index("obs")]
        except (ValueError, IndexError):
            return  # reported by `defects`
        yield from (_READINGS.get(name, name) for name in sorted(fields_read(path, argument)))

    def at_hand(self, named: str) -> tuple[Path | None, str]:
        """Return the folder of the file, and its name."""
        return Path(named).parent, Path(named).name

    def make(self, use: Use, source: Source, *, role: str, robot: str) -> Any:
        """Return the module; Octave starts with the run."""
        # Loaded when a module is created: checking a world asks every host, and starts none.
        from mjsim.modules.foreign import ForeignModule, Workplace
        from mjsim.modules.octave.octave_engine import OctaveEngine

        require_sound(self.defects(use, role, source))
        octave = find_octave()
        home, path = folder_of(source), beside(use.use, source)
        file, paths = path.relative_to(home), [folder.relative_to(home) for folder in paths_of(use, source)]
        place = Workplace(self, use, source)
        engine = OctaveEngine(octave, file, place, who=f"{robot}/{role}", patience=patience_of(use), paths=paths)
        return ForeignModule(engine, role=role, name=path.name, place=_place(path), options=options_of(use))


_TEXTS = {"type": "array", "items": {"type": "string"}}
_KEYS = (
    Key(name="patience", about="How long a call may take [s].", default=10.0, schema={"type": "number"}),
    Key(name="paths", about="Folders with other functions.", default=[], schema=_TEXTS),
)


def _place(path: Path) -> str:
    try:
        return read_function(path).place
    except ValueError:
        return f"{path.name}:1"  # Octave will report the error.


def _misfit(found: FunctionFile, role: str) -> str | None:
    """Return why a function cannot fill a role; more arguments than needed are allowed."""
    first, inputs = HEADS[role]
    head = Sentence(
        "{role} is: function [{first}, state] = {name}({inputs})", a_role(role), first, found.name, ", ".join(inputs)
    )
    if len(found.inputs) < len(inputs) and "varargin" not in found.inputs:
        return Sentence(
            "{place}: {name} takes {counted}; {head}", found.place, found.name, _counted(found.inputs, "argument"), head
        )
    if len(found.outputs) < 2 and "varargout" not in found.outputs:
        return Sentence(
            "{place}: {name} returns {counted}; {head}", found.place, found.name, _counted(found.outputs, "value"), head
        )
    return None


def _counted(names: Sequence[str], noun: str) -> str:
    listed = f" ({', '.join(names)})" if names else ""
    return f"{number_of(len(names), noun)}{listed}"


def _role_of(path: Path) -> str | None:
    try:
        if path.stat().st_size > _MAX_OFFERED or not is_name(path.stem):
            return None
        found = read_function(path)
    except (OSError, ValueError):
        return None
    heads = {role: [first, "state"] for role, (first, _) in HEADS.items()}
    return next(
        (role for role, head in heads.items() if [*found.outputs] == head and (*found.inputs,) == HEADS[role][1]), None
    )


def _functions(folder: Path, home: Path) -> Iterator[Path]:
    """Yield the code files in a folder, and in the subfolders that Octave searches by itself; links may form loops."""
    waiting, seen = [folder], set[Path]()
    while waiting:
        place = waiting.pop()
        if (resolved := place.resolve()) in seen or not resolved.is_relative_to(home):
            continue
        seen.add(resolved)
        for path in sorted(place.iterdir()):
            if path.is_dir() and (path.name == "private" or path.name[:1] in "+@"):
                waiting.append(path)
            elif path.suffix in _CODE_SUFFIXES and holds_file(home, path):
                yield path


def _data(path: Path, home: Path) -> Iterator[Path]:
    """Yield the files that a function names in its text, relative to the folder of the world or its own."""
    small = path.suffix == ".m" and path.stat().st_size <= MAX_BYTES
    for name in _TEXT.findall(path.read_bytes()) if small else ():
        for folder in (home, path.parent):
            named = folder / name.decode()
            if ".." not in named.parts and holds_file(home, named):
                yield named
