"""The files of a studio's folder: listing them, and reading and writing worlds."""

import hashlib
import os
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from mjsim.exchange import template_text
from mjsim.output import write_new, write_whole
from mjsim.sentences import Sentence
from mjsim.web.server import RefusedError
from mjsim.web.worlds.folder import Folder
from mjsim.web.worlds.items import Json
from mjsim.web.worlds.shipped_parts import MODELS, PICTURES, SHIPPED, is_shipped, shipped, shipped_abouts
from mjsim.world import (
    MAX_BYTES,
    Source,
    holds_file,
    read_file,
    too_large,
    world_summary,
    worlds_folder,
)

EMPTY_WORLD = "mjsim: 1\nname: room\n"
SWEEP = "sweep.json"
"""File that marks the folder of a sweep."""
MAX_FILES, DEEPEST = 5000, 6
"""Maximum number of files and of folder levels searched."""
_WORLD = re.compile(rb"^mjsim[ \t]*:", re.MULTILINE)
_MODEL = re.compile(rb"<(mujoco|robot)[\s>]")
_PRESET = re.compile(rb"\A#.*--robot-from")
"""What `mjsim new --robot-from` begins with."""
ROBOTS = (".urdf", ".xacro")
_HEAD_BYTES = 16_384
"""A world can be recognised by its first bytes; this many are read."""
_PASSED_OVER = ("node_modules", "__pycache__", "site-packages")


def recordings_below(root: Path) -> Iterator[Path]:
    """Yield the recordings in and below a folder."""
    return (path for path in files_below(root) if path.suffix.lower() == ".mcap")


def listed(folder: Folder) -> Json:
    """Return the worlds, recordings, sweeps, pictures, models and robots below a folder, and all that mjsim ships."""
    worlds, recordings, sweeps, pictures, models = [], [], [], [], []
    abouts = shipped_abouts()
    files = list(files_below(folder.root))
    for path in files:
        name, kind = folder.name(path), path.suffix.lower()
        if kind in (".yaml", ".yml") and contains(path, _WORLD):
            worlds.append(name)
            abouts[name] = _summary(path)
        elif kind == ".mcap":
            recordings.append(name)
        elif path.name == SWEEP and path.parent != folder.root:
            sweeps.append(folder.name(path.parent))
        elif kind in PICTURES and not name.startswith("out/"):
            pictures.append(name)
        elif kind in MODELS and not name.startswith("out/") and contains(path, _MODEL):
            models.append(name)
    robots = [folder.name(path) for path in _robots(files)]
    found = {
        "robots": robots,
        "worlds": worlds,
        "recordings": recordings,
        "sweeps": sweeps,
        "pictures": pictures,
        "models": models,
    }
    lists = {kind: sorted(names) for kind, names in found.items()}
    return {"folder": str(folder.root), **lists, "shipped": shipped(), "abouts": abouts}


def _robots(files: Sequence[Path]) -> list[Path]:
    """Return presets and files of robots, without the files that presets were made from or name."""
    presets = [path for path in files if path.suffix == ".yaml" and contains(path, _PRESET)]
    made = {path.with_suffix("") for path in presets}
    others = (path for path in files if path.suffix.lower() in ROBOTS and contains(path, _MODEL))
    return [*presets, *(path for path in others if made.isdisjoint([path.with_suffix(""), path.parent]))]


def source_of(folder: Folder, path: str) -> Source:
    """Return the source of a world: in its own folder, or in that of the studio if it is not saved yet.

    Raises:
        RefusedError: The path is outside the folder.
    """
    if path.startswith(SHIPPED) or not path:
        return Source(file=path or "new world", folder=folder.root)
    place = folder.path(path)
    return Source(file=path, folder=place.parent)


def read_world(folder: Folder, path: str) -> tuple[str, str | None]:
    """Return the text of a world and the stamp of its content; None for a shipped one."""
    if path.startswith(SHIPPED):
        name = path.removeprefix(SHIPPED)
        if not is_shipped(path):
            raise RefusedError(404, Sentence("no world '{name:.60}' comes with mjsim; see the list", name))
        return (worlds_folder() / f"{name}.yaml").read_text(encoding="utf-8"), None
    place = _world_path(folder, path)
    if not place.is_file():
        raise RefusedError(404, Sentence("no file '{name:.80}'; it may have been moved or removed", path))
    return read_file(place), stamp_of(place)


def new_world(folder: Folder, path: str | None, *, template: str | None) -> tuple[str, str]:
    """Return path and text of a new world, which is not written yet."""
    if path is not None:
        _world_path(folder, path)
    # A template that is not there is refused before it is part of a name.
    text = EMPTY_WORLD if template is None else template_text(template)
    return path or free_name(folder.root, f"{template or 'room'}.yaml"), text


def save_world(folder: Folder, path: str, *, text: str, stamp: str | None, overwrite: bool) -> str:
    """Write a world atomically; return the stamp of its content.

    Args:
        folder: Folder that contains it.
        path: Path of the world on the page.
        text: Text of the world.
        stamp: Stamp of the content that the text is based on; None for a new file.
        overwrite: Whether existing content may be lost.

    Raises:
        RefusedError: The file has another content, or cannot be written.
    """
    place = _world_path(folder, path)
    data = text.encode("utf-8", "replace")
    if len(data) > MAX_BYTES:
        raise RefusedError(413, too_large(len(data)))
    try:
        # One at a time: of two pages that save at once, the second is told about the first.
        with folder.writing:
            return _written(place, path, data=data, stamp=stamp, overwrite=overwrite)
    except OSError as error:
        if isinstance(error, FileExistsError) and place.is_file():
            raise _taken(path, place, stamp) from None
        raise RefusedError(
            409, Sentence("'{path}' cannot be written: {strerror}; choose another place", path, error.strerror)
        ) from None


def _written(place: Path, path: str, *, data: bytes, stamp: str | None, overwrite: bool) -> str:
    """Write a world as by `save_world`, and return the stamp of its content."""
    place.parent.mkdir(parents=True, exist_ok=True)
    if not place.is_file():
        write_new(place, data)
        return _stamp(data)
    if stamp_of(place) != stamp and not overwrite:
        raise _taken(path, place, stamp)
    data = _as_before(place.read_bytes(), data)
    write_whole(place, data)
    return _stamp(data)


def _taken(path: str, place: Path, stamp: str | None) -> RefusedError:
    """Return the error that the file's content differs from the version known to a page."""
    reason = "exists already" if stamp is None else "changed on disk since it was opened"
    message = Sentence("'{path}' {reason}; overwrite it, or save under another name", path, reason)
    return RefusedError(409, message, stamp=stamp_of(place))


def stamp_of(place: Path) -> str:
    """Return a hash that identifies the content of a file."""
    return _stamp(place.read_bytes())


def _stamp(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:32]


def _as_before(old: bytes, data: bytes) -> bytes:
    """Return data with the line breaks and the byte order mark that the file had; editors lose them."""
    if old.count(b"\r\n") == old.count(b"\n") > 0 and b"\r\n" not in data:
        data = data.replace(b"\n", b"\r\n")
    return b"\xef\xbb\xbf" + data if old.startswith(b"\xef\xbb\xbf") else data


def _world_path(folder: Folder, path: str) -> Path:
    place = folder.path(path)
    if place.suffix.lower() not in (".yaml", ".yml"):
        raise RefusedError(400, Sentence("'{path:.80}' is not the name of a world; write one that ends in .yaml", path))
    if any(part.startswith(".") for part in place.relative_to(folder.root).parts):
        raise RefusedError(403, Sentence("'{path:.80}' is hidden; choose a name without a leading dot", path))
    return place


def free_name(folder: Path, name: str) -> str:
    """Return an unused file name: 'room.yaml', 'room-2.yaml' and so on."""
    stem, kind = Path(name).stem, Path(name).suffix
    number = 1
    while (folder / name).exists():
        number += 1
        name = f"{stem}-{number}{kind}"
    return name


def files_below(root: Path) -> Iterator[Path]:
    """Yield the files in and below a folder, nearest first.

    Hidden files are left out, and links that lead outside, and names that no world can hold.
    """
    waiting, seen = [(root, 0)], 0
    while waiting and seen < MAX_FILES:
        folder, depth = waiting.pop(0)
        try:
            entries = sorted(os.scandir(folder), key=lambda entry: entry.name)
        except OSError:
            continue
        for entry in entries:
            seen += 1
            if entry.name.startswith(".") or entry.name in _PASSED_OVER:
                continue
            if entry.is_dir(follow_symlinks=False) and depth < DEEPEST:
                waiting.append((Path(entry.path), depth + 1))
            elif holds_file(root, Path(entry.path)):
                yield Path(entry.path)


def _summary(path: Path) -> str:
    """Return the description of a world; '' if it has none, or is gone."""
    try:
        return world_summary(path)
    except OSError:
        return ""


def contains(path: Path, word: re.Pattern[bytes]) -> bool:
    """Return whether the start of a file matches a pattern."""
    try:
        with path.open("rb") as file:
            return word.search(file.read(_HEAD_BYTES)) is not None
    except OSError:
        return False
