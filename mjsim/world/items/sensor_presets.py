"""Sensors that come with mjsim, and a user's own keys over theirs."""

from collections.abc import Mapping
from functools import cache
from importlib import resources
from typing import Any

from mjsim.errors import did_you_mean
from mjsim.world.yaml import read_text


def over_sensor(kind: str, name: str, keys: Mapping[str, Any]) -> dict[str, Any]:
    """Return the keys of a sensor with those of its preset below them; a key hides the preset's whole.

    Args:
        kind: 'lidar' or 'camera'.
        name: Of the preset.
        keys: The user's own.

    Raises:
        ValueError: There is no such preset.
    """
    known = sensor_names(kind)
    if name not in known:
        raise ValueError(f"no {kind} preset '{name}'{did_you_mean(name, known)}")
    return {**_sensor(kind, name), **keys}


@cache
def sensor_names(kind: str) -> tuple[str, ...]:
    """Return the names of all presets of a kind of sensor, sorted."""
    files = (resources.files("mjsim.assets") / "sensors" / kind).iterdir()
    return tuple(sorted(file.name.removesuffix(".yaml") for file in files if file.name.endswith(".yaml")))


@cache
def _sensor(kind: str, name: str) -> dict[str, Any]:
    file = resources.files("mjsim.assets") / "sensors" / kind / f"{name}.yaml"
    node, problems = read_text(file.read_text(encoding="utf-8"), file=str(file))
    assert node is not None, problems
    assert not problems, problems
    return dict(node.value)
