"""Modules offered by the page: shipped ones, and those beside a world."""

import json
import os
import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import cache, lru_cache
from importlib import resources
from itertools import islice
from pathlib import Path
from threading import Lock

from mjsim.models import note, noted
from mjsim.modules import Key, Offer, faults_in, offers_in, readings_needed
from mjsim.web.worlds.folder import Folder
from mjsim.web.worlds.items import Json
from mjsim.web.worlds.world_files import contains, files_below, source_of
from mjsim.world import MAX_BYTES, SENSOR_KINDS, Source, read_regular

KINDS = {
    "observer": "observers",
    "estimator": "estimators",
    "navigator": "navigators",
    "avoidance": "avoidances",
    "controller": "controllers",
}
"""Keys of the page's list, by role."""
PREFERRED = (
    "mjsim.algorithms.beacon_vision:BeaconVision",
    "mjsim.algorithms.ekf_slam:EkfSlam",
    "mjsim.algorithms.lidar_slam:LidarSlam",
    "mjsim.algorithms.explore:Explore",
    "mjsim.algorithms.wander:Wander",
)
"""Modules that suit most robots as they are; of the ones that fit a robot, the first of each role is suggested."""
MAX_PROGRAMS = 50
_SHIPPED = "mjsim.algorithms."
_READING = Lock()
"""Held while the shipped modules are read: several requests, and the start, may ask for them at once."""
_PROGRAM = re.compile(rb"\A(#!|\x7fELF|\xcf\xfa\xed\xfe)")
"""How scripts and programs of Linux and macOS begin; on some file systems, all files are executable."""


def modules_in(folder: Folder, world: str | None = None) -> Json:
    """Return shipped observers, estimators, navigators, avoidances and controllers, and those beside a world.

    Each has `use`, title, about, `needs` (readings of which it needs one), `parts` (what else its robot must have) and
    `options` (a JSON Schema of the keys beside `use`). `sensors` has the reading of each kind of sensor; `faults` why a
    file in the folder cannot be imported; `programs` the `use:` of programs there.

    Args:
        folder: Folder of the studio.
        world: World whose folder is searched; by default that of the studio.
    """
    place = folder.root if world is None else folder.path(world).parent
    files = [(path, path.relative_to(place).as_posix()) for path in files_below(place)] if place.is_dir() else []
    offers = [*shipped_modules(), *_own(files, source_of(folder, world or ""))]
    faults = dict(faults_in([(path, name) for path, name in files if path.suffix == ".py"]))
    found: dict[str, Json] = {kind: {} for kind in KINDS.values()}
    for role, offer in offers:
        found[KINDS[role]].setdefault(offer["use"], offer)
    programs = (f"exec:./{name}" for path, name in files if _is_program(path))
    lists = {kind: sorted(each.values(), key=_order) for kind, each in found.items()}
    sensors = {kind: model.reading for kind, model in SENSOR_KINDS.items()}
    return {**lists, "sensors": sensors, "faults": faults, "programs": list(islice(programs, MAX_PROGRAMS))}


def shipped_modules() -> Sequence[tuple[str, Json]]:
    """Return the shipped modules by role; their sources are read once, since this takes a second."""
    with _READING:
        return _shipped()


@cache
def _shipped() -> Sequence[tuple[str, Json]]:
    files = _shipped_files()
    readers = (*Path(str(resources.files("mjsim.modules"))).rglob("*.py"), Path(__file__))
    about = [path.read_bytes() for path in (*sorted(readers), *(path for path, _ in files))]
    with suppress(ValueError, TypeError):
        return tuple((role, offer) for role, offer in json.loads(noted("offers", *about) or b""))
    found = tuple(_offered(files, Source()))
    note(json.dumps(found).encode(), "offers", *about)
    return found


def _own(files: Sequence[tuple[Path, str]], source: Source) -> Sequence[tuple[str, Json]]:
    """Return the modules in files of a folder; their classes may inherit from shipped ones."""
    code = tuple((path, place, _stamp(path)) for path, place in files if path.suffix in (".py", ".m"))
    return _own_offers(code, source.file, source.folder) if code else ()


@lru_cache(maxsize=4)
def _own_offers(code: Sequence[tuple[Path, str, object]], file: str, folder: Path | None) -> Sequence[tuple[str, Json]]:
    files = [(path, place) for path, place, _ in code]
    inherits = any(_names(path, _SHIPPED) for path, _ in files)
    shipped = _shipped_files() if inherits else ()
    return tuple(_offered([*shipped, *files], Source(file=file, folder=folder), but=_SHIPPED))


def _stamp(path: Path) -> tuple[int, int] | None:
    """Return a value that changes with the content of a file; None if there is no such file."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size


def _names(path: Path, word: str) -> bool:
    """Return whether a Python file has a word."""
    with suppress(OSError):
        return path.suffix == ".py" and word.encode() in read_regular(path, limit=MAX_BYTES)
    return False


def _shipped_files() -> Sequence[tuple[Path, str]]:
    """Return the files of shipped modules, each with its text before the colon; files of a package share its name."""
    folder = Path(str(resources.files("mjsim.algorithms")))
    single = [(path, f"{_SHIPPED}{path.stem}") for path in sorted(folder.glob("*.py"))]
    return [*single, *((path, f"{_SHIPPED}{path.parent.name}") for path in sorted(folder.glob("*/*.py")))]


def _offered(files: Sequence[tuple[Path, str]], source: Source, *, but: str = "\n") -> Iterator[tuple[str, Json]]:
    for offer in offers_in(files):
        if offer.role in KINDS and not offer.use.startswith(but):
            yield offer.role, _offer_json(offer, source)


def _offer_json(offer: Offer, source: Source) -> Json:
    required = [key.name for key in offer.keys if key.required]
    options = {"type": "object", "properties": {key.name: _key_json(key) for key in offer.keys}, "required": required}
    # A key named after a kind of sensor names a sensor that the module needs.
    named = {SENSOR_KINDS[key.name].reading for key in offer.keys if key.name in SENSOR_KINDS}
    needs = sorted(named or readings_needed(offer.use, offer.role, source))
    named_by = {"use": offer.use, "title": offer.title, "about": offer.about}
    return {**named_by, "needs": needs, "parts": sorted(offer.parts), "options": options}


def _key_json(key: Key) -> Json:
    content: Json = {**key.schema, "description": key.about}
    return content if key.required else {**content, "default": key.default}


def _order(offer: Json) -> tuple[int, str]:
    return PREFERRED.index(offer["use"]) if offer["use"] in PREFERRED else len(PREFERRED), offer["title"]


def _is_program(path: Path) -> bool:
    return os.access(path, os.X_OK) and contains(path, _PROGRAM)
