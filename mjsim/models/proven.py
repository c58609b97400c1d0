"""Models and pictures that worlds name are first read in the guarded reader, once per content.

What a child has read within its limits is noted by its SHA-256 in the user's cache folder, as an empty file; files that
ship with mjsim need no child.
"""

import base64
import functools
import hashlib
import json
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from importlib import metadata, resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from mjsim.errors import UsageError
from mjsim.guarded import in_child, one_reader, reader_for
from mjsim.models.content_notes import note, noted
from mjsim.models.mesh_files import MeshPart

TRIALS = f"{__package__}.trials"
"""Module of the functions that the child runs; it is not imported here."""
LIBRARIES = ("mujoco", "opencv-python-headless", "pycollada", "trimesh")
"""Libraries that read them, besides the modules of this package; other versions may fail on the same files."""


def require_readable(
    trial: str, *arguments: Any, content: Iterable[bytes], about: str, files: Collection[str] = ()
) -> None:
    """Check that a file can be read in the guarded reader; inside of it this does nothing.

    Args:
        trial: Name of the function of `trials` that reads it; it returns what is wrong, or None.
        arguments: Its arguments.
        content: All bytes that it reads.
        about: Name of the file, for messages.
        files: SHA-256 of each file as it was found; by default that of the content.

    Raises:
        ValueError: It cannot be read.
    """
    if in_child():
        return
    parts = tuple(content)
    if shipped() >= (set(files) or {digest(part) for part in parts}):
        return
    known_by: tuple[str | bytes, ...] = trial, *_readers(), *parts
    if noted(*known_by) is not None:
        return
    try:
        with reader_for(f"{TRIALS}:{trial}") as reader:
            wrong = reader.call(f"{TRIALS}:{trial}", *arguments, about=about, size=sum(map(len, parts)))
    except UsageError as error:
        raise ValueError(str(error).removeprefix(f"'{about}' ")) from None
    if wrong is not None:
        raise ValueError(wrong)
    note(b"", *known_by)


def require_picture(data: bytes, name: str) -> None:
    """Raise ValueError if a picture cannot be read; see `require_readable`."""
    require_readable("picture", data, content=[data], about=name)


def guarded_parts(path: str, data: bytes, *, whole: bool) -> list[MeshPart]:
    """Return the parts of a mesh without textures, read in the guarded reader once per content.

    Args:
        path: Its file; the ending tells the format.
        data: Contents of the file.
        whole: Whether it becomes one part.

    Raises:
        ValueError: It cannot be read.
    """
    known_by: tuple[str | bytes, ...] = "mesh", *_readers(), path, str(whole), data
    known = noted(*known_by)
    if known is None:
        try:
            with reader_for(f"{TRIALS}:mesh") as reader:
                found = reader.call(f"{TRIALS}:mesh", path, data, whole, about=path, size=len(data))
        except UsageError as error:
            raise ValueError(str(error)) from None
        if isinstance(found, str):
            raise ValueError(found)
        known = json.dumps([(base64.b64encode(part).decode(), *more) for part, *more in found]).encode()
        note(known, *known_by)
    return [
        MeshPart(base64.b64decode(part), rgba and tuple(rgba), coarser=coarser, bare=bare)
        for part, rgba, coarser, bare in json.loads(known)
    ]


@contextmanager
def one_trial_child() -> Iterator[None]:
    """Let all files that are tried in a block share one child, which starts with the first of them."""
    with one_reader(f"{TRIALS}:picture"):
        yield


def digest(data: bytes) -> str:
    """Return the SHA-256 of a file."""
    return hashlib.sha256(data).hexdigest()


@functools.cache
def shipped() -> frozenset[str]:
    """Return the SHA-256 of each file in the assets of mjsim."""
    return frozenset(digest(file.read_bytes()) for file in _below(resources.files("mjsim.assets")))


def _below(folder: Traversable) -> Iterable[Traversable]:
    for each in folder.iterdir():
        yield from _below(each) if each.is_dir() else [each]


@functools.cache
def _readers() -> Sequence[str]:
    """Return the versions of the libraries, and the SHA-256 of each module that may take part."""
    modules = sorted(Path(__file__).parent.rglob("*.py"))
    return [*map(metadata.version, LIBRARIES), *(digest(module.read_bytes()) for module in modules)]
