"""Sensor presets, overridden by the user's keys."""

from collections.abc import Mapping
from typing import Any

from mjsim.errors import did_you_mean
from mjsim.sentences import Sentence
from mjsim.world.items.shipped_presets import shipped_keys, shipped_names


def over_sensor(kind: str, name: str, keys: Mapping[str, Any]) -> dict[str, Any]:
    """Return the keys of a sensor merged with those of its preset; a key replaces that of the preset as a whole.

    Args:
        kind: 'lidar' or 'camera'.
        name: Name of the preset.
        keys: The user's own.

    Raises:
        ValueError: The preset does not exist.
    """
    known = sensor_names(kind)
    if name not in known:
        raise ValueError(Sentence("no {kind} preset '{name}'{meant}", kind, name, did_you_mean(name, known)))
    return {**shipped_keys(f"sensors/{kind}", name), **keys}


def sensor_names(kind: str) -> tuple[str, ...]:
    """Return the names of all presets of a kind of sensor, sorted."""
    return shipped_names(f"sensors/{kind}")
