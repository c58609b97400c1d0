"""Robots that come with mjsim, and a user's own keys over theirs."""

from collections.abc import Mapping
from functools import cache
from importlib import resources
from typing import Any

from mjsim.errors import did_you_mean
from mjsim.world.text import read_text


def over_preset(name: str, keys: Mapping[str, Any]) -> dict[str, Any]:
    """Return the keys of a robot with those of its preset below them.

    Raises:
        ValueError: There is no such preset.
    """
    if name not in preset_names():
        raise ValueError(f"no preset '{name}'{did_you_mean(name, preset_names())}")
    merged: dict[str, Any] = _merged(_preset(name), keys)
    return merged


@cache
def preset_names() -> tuple[str, ...]:
    """Return the names of all presets, sorted."""
    files = (resources.files("mjsim.assets") / "robots").iterdir()
    return tuple(sorted(file.name.removesuffix(".yaml") for file in files if file.name.endswith(".yaml")))


@cache
def _preset(name: str) -> dict[str, Any]:
    file = resources.files("mjsim.assets") / "robots" / f"{name}.yaml"
    node, problems = read_text(file.read_text(encoding="utf-8"), file=str(file))
    assert node is not None, problems
    assert not problems, problems
    return dict(node.value)


def _merged(below: Any, above: Any) -> Any:
    """Return mappings merged key by key; any other value above hides the one below."""
    if not (isinstance(below, Mapping) and isinstance(above, Mapping)):
        return above
    return {**below, **{key: _merged(below.get(key), value) for key, value in above.items()}}
