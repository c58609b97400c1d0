"""Modules offered by the page: shipped ones, and those beside a world."""

import importlib.util
from collections.abc import Iterator
from pathlib import Path

from mjsim.modules import Key, Offer, offers_in
from mjsim.web.files import files_below
from mjsim.web.folder import Folder
from mjsim.web.items import Json

KINDS = {"observer": "observers", "estimator": "estimators", "navigator": "navigators", "avoidance": "avoidances"}
"""Keys of the page's list, by role."""


def modules_in(folder: Folder, world: str | None = None) -> Json:
    """Return shipped observers, estimators, navigators and avoidances, and those beside a world.

    Each has `use`, title, about, and keys: name, default (absent if required) and about.

    Args:
        folder: Folder of the studio.
        world: World whose folder is searched; by default that of the studio.
    """
    place = folder.root if world is None else folder.path(world).parent
    files = sorted(_algorithms())
    if place.is_dir():
        files += [(path, path.relative_to(place).as_posix()) for path in files_below(place)]
    found: dict[str, list[Json]] = {kind: [] for kind in KINDS.values()}
    for offer in offers_in(files):
        if offer.role in KINDS:
            found[KINDS[offer.role]].append(_offer_json(offer))
    return dict(found)


def _algorithms() -> Iterator[tuple[Path, str]]:
    """Yield the files of shipped modules, each with its text before the colon; files of a package share its name."""
    spec = importlib.util.find_spec("mjsim.algorithms")
    for folder in (spec.submodule_search_locations or ()) if spec is not None else ():
        yield from ((path, f"mjsim.algorithms.{path.stem}") for path in Path(folder).glob("*.py"))
        yield from ((path, f"mjsim.algorithms.{path.parent.name}") for path in Path(folder).glob("*/*.py"))


def _offer_json(offer: Offer) -> Json:
    keys = [_key_json(key) for key in offer.keys]
    return {"use": offer.use, "title": offer.title, "about": offer.about, "keys": keys}


def _key_json(key: Key) -> Json:
    content: Json = {"name": key.name, "about": key.about}
    return content if key.required else {**content, "default": key.default}
