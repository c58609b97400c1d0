"""Robots that come with mjsim, and a user's own keys over theirs."""

from collections.abc import Mapping
from functools import cache
from importlib import resources
from typing import Any

from mjsim.errors import did_you_mean
from mjsim.world.bodies import SHAPES
from mjsim.world.text import read_text

_OTHER_SHAPES = ("box", "polygon", "model")
"""Keys that tell that a body is no cylinder."""


def over_preset(name: str, keys: Mapping[str, Any]) -> dict[str, Any]:
    """Return the keys of a robot with those of its preset below them.

    Raises:
        ValueError: There is no such preset.
    """
    if name not in preset_names():
        raise ValueError(f"no preset '{name}'{did_you_mean(name, preset_names())}")
    below = dict(_preset(name))
    _check_drive(name, below.get("drive", {}), keys.get("drive"))
    body = keys.get("body")
    if isinstance(body, Mapping) and any(key in body for key in _OTHER_SHAPES):
        # Another shape takes the place of the preset's with all its keys, the look of the old one among them.
        of_shape = {key for shape in SHAPES.values() for key in shape}
        below["body"] = {key: value for key, value in below["body"].items() if key not in {*of_shape, "look"}}
    merged: dict[str, Any] = _merged(below, keys)
    return merged


def _check_drive(name: str, below: Mapping[str, Any], above: Any) -> None:
    """Raise ValueError when a user's keys describe another kind of drive than the preset has."""
    if not isinstance(above, Mapping):
        return
    kind, wanted = below.get("type", "differential"), above.get("type")
    if "use" in above:
        raise ValueError(f"preset '{name}' has a drive of its own, {kind}; leave out the preset to use yours")
    if wanted is not None and wanted != kind:
        raise ValueError(f"preset '{name}' has the drive {kind}, not {wanted}; leave out 'type' or the preset")


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
