"""Worlds, presets and other parts shipped with mjsim, as named on the page."""

from collections.abc import Iterator
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from mjsim.exchange import TEMPLATES
from mjsim.world import preset_names, shipped_worlds, world_summary, worlds_folder

SHIPPED = "shipped:"
"""Prefix of the path of a shipped world on the page."""
MODELS = (".xml", ".urdf")
"""Suffixes of models."""
PICTURES = (".jpg", ".jpeg", ".png")
"""Suffixes of pictures."""


@cache
def shipped() -> dict[str, Any]:
    """Return what is shipped with mjsim: worlds, pictures, models, presets of arms, sensors and robots, templates."""
    return {
        "worlds": sorted(_shipped_files("mjsim.worlds", (".yaml",), cut=5)),
        "pictures": sorted(_shipped_files("mjsim.assets", PICTURES)),
        "models": sorted(name for name in _shipped_files("mjsim.assets", MODELS) if name.startswith("furniture/")),
        "arms": _presets("arms"),
        "sensors": {kind: _presets(f"sensors/{kind}") for kind in ("camera", "lidar", "lidar3d")},
        "presets": [{"name": name, "about": _about(name)} for name in preset_names()],
        "templates": list(TEMPLATES),
        "about": {name: world_summary(shipped_worlds()[name]) for name in TEMPLATES},
    }


def shipped_abouts() -> dict[str, str]:
    """Return the description of each shipped world by its path on the page."""
    return dict(_abouts())


@cache
def _abouts() -> tuple[tuple[str, str], ...]:
    return tuple((f"{SHIPPED}{name}", world_summary(worlds_folder() / f"{name}.yaml")) for name in shipped()["worlds"])


def _presets(place: str) -> list[str]:
    """Return the names of the presets in a folder of the assets."""
    names = _shipped_files("mjsim.assets", (".yaml",), cut=5)
    return sorted(name.removeprefix(f"{place}/") for name in names if name.startswith(f"{place}/"))


def shipped_name(word: str) -> str | None:
    """Return the path on the page of the shipped world named by a bare word; None if there is none."""
    file = shipped_worlds().get(word)
    if file is None:
        return None
    return f"{SHIPPED}{file.relative_to(worlds_folder()).with_suffix('').as_posix()}"


def is_shipped(path: str) -> bool:
    """Return whether a path on the page names a shipped world."""
    return path.startswith(SHIPPED) and path.removeprefix(SHIPPED) in shipped()["worlds"]


def _shipped_files(package: str, kinds: tuple[str, ...], *, cut: int = 0) -> Iterator[str]:
    """Yield shipped files by their paths in the package, without the last `cut` characters."""
    waiting = [("", resources.files(package))]
    while waiting:
        folder, place = waiting.pop()
        for item in place.iterdir():
            name = f"{folder}{item.name}"
            if item.is_dir():
                waiting.append((f"{name}/", item))
            elif name.lower().endswith(kinds):
                yield name[: len(name) - cut]


def _about(preset: str) -> str:
    """Return the first sentence of a preset's file."""
    path = Path(str(resources.files("mjsim.assets")), "robots", f"{preset}.yaml")
    return world_summary(path).partition(" Sources:")[0].rstrip(".")
