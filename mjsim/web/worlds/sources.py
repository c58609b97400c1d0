"""The source text of modules that a world names, for display; none of it is run."""

import importlib.util
import os
import re
from pathlib import Path

from mjsim.modules import foreign_code
from mjsim.sentences import Sentence
from mjsim.web.server import RefusedError
from mjsim.web.worlds.items import Json
from mjsim.world import World

SHIPPED = "mjsim.algorithms."


def source_of_use(world: World, use: str) -> Json:
    """Return the text of a module.

    Args:
        world: World that names it.
        use: `FILE.py:CLASS` beside the world, or `mjsim.algorithms.MODULE:CLASS`.

    Returns:
        Name of the file, its text, and the line of the class, counted from 1.

    Raises:
        RefusedError: The world does not name such a file, or it belongs to an installed package.
    """
    place, _, name = use.rpartition(":")
    begins = re.compile(rf"^(class|def|fn|struct|impl)\s+{re.escape(name)}\b", re.MULTILINE)
    text = _shipped(place, begins) if place.startswith(SHIPPED) else _beside(world, place)
    first = begins.search(text)
    line = text.count("\n", 0, first.start()) + 1 if first else 1
    return {"name": place, "text": text, "line": line}


def _shipped(module: str, begins: re.Pattern[str]) -> str:
    """Return the text of a module; for a package, of the file in which the class begins."""
    # A name with more dots would import what precedes the last one.
    spec = importlib.util.find_spec(module) if re.fullmatch(re.escape(SHIPPED) + r"\w+", module) else None
    if spec is None or spec.origin is None:
        raise RefusedError(404, Sentence("mjsim has no module '{module}'", module))
    origin = Path(spec.origin)
    files = sorted(origin.parent.glob("*.py")) if spec.submodule_search_locations else [origin]
    texts = [file.read_text(encoding="utf-8") for file in files]
    return next(filter(begins.search, texts), texts[0])


def _beside(world: World, place: str) -> str:
    files, name = foreign_code(world).files, os.path.normpath(place)
    if name not in files or os.path.isabs(name):
        raise RefusedError(
            404, Sentence("'{place}' is not a source file beside this world; only such files are shown", place)
        )
    return files[name].decode("utf-8", errors="replace")
