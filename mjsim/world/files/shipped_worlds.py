"""The shipped worlds; a bare word such as `gallery` names one."""

import re
from importlib import resources
from itertools import takewhile
from pathlib import Path

from mjsim.errors import UsageError, did_you_mean
from mjsim.sentences import Sentence

SCHEMA_LINE = re.compile(r"\A# yaml-language-server:.*\n")
"""Line for completion in editors; the schema is only beside the shipped worlds."""
HEAD = 16_384
"""Number of bytes in which a description is looked for."""


def worlds_folder() -> Path:
    """Return the folder of the shipped worlds."""
    return Path(str(resources.files("mjsim.worlds")))


def shipped_worlds() -> dict[str, Path]:
    """Return the path of each shipped world by name; those in sub-folders come last."""
    found: dict[str, Path] = {}
    for path in sorted(worlds_folder().rglob("*.yaml"), key=lambda path: (len(path.parts), path)):
        found.setdefault(path.stem, path)
    return found


def world_path(place: str | Path) -> Path:
    """Return the path of a world; a bare word, without folder or suffix, names a shipped world.

    Raises:
        UsageError: There is no shipped world of this name.
    """
    word = str(place)
    if not re.fullmatch(r"[\w-]+", word):
        return Path(place)
    shipped = shipped_worlds()
    if word in shipped:
        return shipped[word]
    if Path(f"{word}.yaml").is_file():
        raise UsageError(Sentence("no shipped world '{word}'; to name the file here, type '{word}.yaml'", word))
    if Path(word).is_dir():
        raise UsageError(
            Sentence("no shipped world '{word:.60}'; for a world in the folder, type '{word:.60}/WORLD.yaml'", word)
        )
    raise UsageError(Sentence("no shipped world '{word:.60}'{meant}", word, did_you_mean(word, shipped)))


def world_summary(path: Path) -> str:
    """Return the first sentence of the comment at the top of a world file; '' if there is none."""
    with path.open("rb") as file:
        text = SCHEMA_LINE.sub("", file.read(HEAD).decode("utf-8", "replace"))
    comment = " ".join(line.lstrip("# ") for line in takewhile(lambda line: line.startswith("#"), text.splitlines()))
    return re.split(r"(?<=\.)\s", comment, maxsplit=1)[0]


def own_copy(path: Path) -> str:
    """Return the text of a shipped world for a copy: without the line that refers to the schema beside it."""
    return SCHEMA_LINE.sub("", path.read_text(encoding="utf-8"))
