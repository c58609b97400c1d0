"""Text -> World."""

from pathlib import Path

from ruamel.yaml import YAML

from mjsim.world.model import World
from mjsim.world.source import Source


def parse_world(text: str, *, file: str = "world", source: Source | None = None) -> World:
    """Return the world that a text describes."""
    world = World.model_validate(YAML(typ="safe", pure=True).load(text))
    world._source = source or Source(file=file, text=text, folder=None)
    return world


def load_world(path: str | Path) -> World:
    """Return the world of a file."""
    path = Path(path)
    text = path.read_text()
    return parse_world(text, file=str(path), source=Source(file=str(path), text=text, folder=path.parent))
