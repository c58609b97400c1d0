"""Noise of drives, odometry and sensors: the values of a world that may change during a run."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel

from mjsim.errors import UsageError
from mjsim.sentences import Sentence
from mjsim.world.ground import Slider, description_of
from mjsim.world.items.changed_values import called, with_values
from mjsim.world.items.sensing import SENSOR_KINDS, Depth, name_of
from mjsim.world.items.world import World

NOISE: Mapping[str, tuple[str, ...]] = {
    "drive": ("noise",),
    "odometry": ("noise", "scale", "track_error", "wheel_errors"),
}
"""Noise keys of a drive and of its odometry; those of a sensor are in its model."""
_UNIT = re.compile(r"\[([^]]+)\]")


@dataclass(frozen=True, slots=True)
class NoiseFigure:
    """One noise parameter."""

    key: str
    """Key as in `--set`: 'robots.scout.odometry.noise.turn'."""
    value: float
    unit: str | None
    """Unit; None for a dimensionless number."""
    about: str
    """Meaning, in a sentence."""
    slider: Slider | None = None
    """Useful range for a slider; None if it follows from the unit."""


def noise_figures(world: World) -> Iterator[NoiseFigure]:
    """Yield all parameters that may change during a run."""
    for number, robot in enumerate(world.robots):
        place = f"robots.{_step(robot.name, number)}"
        for part in ("drive", "odometry"):
            yield from _figures(f"{place}.{part}", getattr(robot, part), NOISE[part])
        for index, sensor in enumerate(robot.sensors):
            key = f"{place}.sensors.{_step(name_of(sensor), index)}"
            yield from _figures(key, sensor, sensor.noise_keys)


def require_same_but_noise(before: World, after: World) -> None:
    """Check that worlds differ only in noise.

    Raises:
        UsageError: They differ otherwise; the message names the first key.
    """
    different = _difference(_quiet(before), _quiet(after))
    if different is not None:
        raise UsageError(
            Sentence("{different} cannot change during a run, only noise can; restart the run with it", different)
        )


def with_noise(world: World, key: str, value: object) -> World:
    """Return the world with one noise parameter changed.

    Args:
        world: Not modified.
        key: Key as for `--set`: 'robots.scout.odometry.noise.turn'.
        value: New value.

    Raises:
        UsageError: The key does not exist or is not a noise parameter, or the value is not allowed.
    """
    changed = with_values(world, {key: value})
    require_same_but_noise(world, changed)
    return changed


def _step(name: str, number: int) -> str:
    """Return the part of a key that names an item: its name, or its index if the name contains dots."""
    return str(number) if "." in name else name


def _figures(key: str, model: BaseModel, fields: tuple[str, ...], about: str = "") -> Iterator[NoiseFigure]:
    for name in fields:
        value, text = getattr(model, name), description_of(type(model), name)
        unit = _UNIT.search(text)
        description = _UNIT.sub("", text).strip(" ,.;")
        description = f"{description}." if description else about
        if isinstance(value, Depth):
            yield from _figures(f"{key}.{name}", value, ("noise",), description)
        elif isinstance(value, BaseModel):
            yield from _figures(f"{key}.{name}", value, tuple(type(value).model_fields), description)
        elif isinstance(value, float | int) and not isinstance(value, bool):
            slider = next((each for each in type(model).model_fields[name].metadata if isinstance(each, Slider)), None)
            yield NoiseFigure(f"{key}.{name}", float(value), unit[1] if unit else None, description, slider)


def _quiet(world: World) -> dict[str, Any]:
    """Return the content of a world without its noise."""
    tree = world.model_dump()
    for robot in tree["robots"]:
        for part in ("drive", "odometry"):
            robot[part] |= dict.fromkeys(NOISE[part])
        for sensor in robot["sensors"]:
            depth = sensor.get("depth")
            kind = next(kind for kind in SENSOR_KINDS if isinstance(sensor.get(kind), str))
            sensor |= dict.fromkeys(SENSOR_KINDS[kind].noise_keys)
            # Of the depth of a depth camera, only the noise may change.
            if depth:
                sensor["depth"] = {"range": Depth().range if depth is True else depth["range"]}
    return tree


def _difference(one: Any, other: Any, path: str = "") -> str | None:
    """Return the key of the first value that differs, None if there is none."""
    if isinstance(one, dict) and isinstance(other, dict):
        pairs = [(str(key), one.get(key), other.get(key)) for key in {**one, **other}]
    elif isinstance(one, list | tuple) and isinstance(other, list | tuple) and len(one) == len(other):
        pairs = [(called(a, str(k)), a, b) for k, (a, b) in enumerate(zip(one, other, strict=True))]
    else:
        return None if one == other else path
    found = (_difference(a, b, f"{path}.{key}" if path else key) for key, a, b in pairs if a != b)
    return next((each for each in found if each is not None), None)
