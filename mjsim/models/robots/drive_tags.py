"""What plug-ins of simulators, ros2_control and controllers state about a robot's drive."""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field
from typing import Any

from mjsim.models.inertia_repair import finite_number
from mjsim.models.model_sources import Element

PLACEHOLDERS = (0.0, 1.0)
"""Limits of a wheel's speed that exporters and templates write if none is known [rad/s]."""
MAX_DEPTH = 8
"""Maximum nesting of the parameters of a controller."""
_MECANUM = re.compile(r"mecanum|robot_center_projection", re.IGNORECASE)
"""Types of controllers of mecanum wheels, and a parameter that only they have."""
_UNUSED = re.compile(r"torque|max_?\w*acceleration", re.IGNORECASE)
"""Names of limits that are reported, but not used."""
_WHEELS = re.compile(r"^(left|right)_wheel$|(wheel|traction).*(joints?|names?)$")
"""Parameters that name wheels' joints, in the controllers of ROS and ROS 2 for two, four, steered and omni wheels."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SaidDrive:
    """Properties of a drive, as far as a plug-in or controller states them."""

    source: str = ""
    """What states them."""
    wheel_radius: float | None = None
    """[m]"""
    separation: float | None = None
    """Distance between left and right wheels [m]."""
    max_speed: float | None = None
    """[m/s]"""
    max_turn: float | None = None
    """[rad/s]"""
    sideways: str = ""
    """What states that it moves sideways as well."""
    joints: frozenset[str] = frozenset()
    """Joints of its wheels; empty if it names none."""
    wheel_speeds: Mapping[str, float] = field(default_factory=dict)
    """Joint -> maximum speed [rad/s]."""
    unused: tuple[str, ...] = ()
    """Limits that the drives of mjsim do not have, as written."""


def drives_in_tags(root: Element) -> Iterator[SaidDrive]:
    """Yield what each plug-in and each system of ros2_control in a URDF states about a drive."""
    for plugin in root.iter("plugin"):
        tags: dict[str, list[str]] = {}
        for item in plugin.iter():
            tags.setdefault(_plain(item.tag), []).append(item.text or "")
        radius, diameter = _number(tags, "wheelradius"), _number(tags, "wheeldiameter")
        found = SaidDrive(
            source=f"plug-in '{plugin.get('filename') or plugin.get('name') or '?'}'",
            wheel_radius=radius or (diameter / 2 if diameter else None),
            separation=_number(tags, "wheelseparation"),
            max_speed=_number(tags, "maxlinearvelocity") or _number(tags, "maxvelocity"),
            max_turn=_number(tags, "maxangularvelocity"),
            joints=frozenset(text.strip() for tag, texts in tags.items() if "joint" in tag for text in texts),
            unused=_unused((item.tag.rpartition("}")[2], item.text) for item in plugin.iter()),
        )
        if found.wheel_radius or found.separation or found.max_speed:
            yield found
    speeds = dict(_commanded(root))
    if speeds:
        yield SaidDrive(source="ros2_control", wheel_speeds=speeds, joints=frozenset(speeds))


def _plain(tag: str) -> str:
    return tag.rpartition("}")[2].replace("_", "").replace("-", "").lower()


def _unused(stated: Iterable[tuple[str, Any]]) -> tuple[str, ...]:
    """Return the positive limits that are not used, each with its value."""
    numbers = {name: finite_number(str(value)) for name, value in stated if _UNUSED.search(name)}
    return tuple(f"{name} {value:g}" for name, value in numbers.items() if value is not None and value > 0.0)


def _number(tags: Mapping[str, Sequence[str]], tag: str) -> float | None:
    """Return the positive number that all elements of a tag have; None if there is none."""
    values = {finite_number(text) for text in tags.get(tag, ())}
    value = values.pop() if len(values) == 1 else None
    return value if value is not None and value > 0.0 else None


def _commanded(root: Element) -> Iterator[tuple[str, float]]:
    """Yield the maximum speeds of joints that ros2_control commands."""
    for control in root.iter("ros2_control"):
        for joint in control.findall("joint"):
            for command in joint.findall("command_interface"):
                values = {param.get("name", ""): finite_number(param.text) for param in command.findall("param")}
                top = values.get("max")
                if command.get("name") == "velocity" and top is not None and top > 0.0 and top not in PLACEHOLDERS:
                    yield joint.get("name", ""), top


def drives_in_parameters(value: Any, source: str, *, depth: int = 0, within: str = "") -> Iterator[SaidDrive]:
    """Yield what the parameters of controllers state about drives.

    Args:
        value: ROS parameters, as parsed from YAML.
        source: Their file.
        depth: How deep they are nested in others.
        within: Names of those.
    """
    if not isinstance(value, Mapping) or depth > MAX_DEPTH:
        return
    flat = dict(_flattened(value))
    joints = [name for key, named in value.items() if _WHEELS.search(str(key)) for name in _names(named)]
    if joints:
        yield SaidDrive(
            source=source,
            wheel_radius=_positive(flat, "wheel_radius") or _positive(flat, "kinematics.wheels_radius"),
            separation=_positive(flat, "wheel_separation"),
            max_speed=_limit(flat, "linear.x"),
            max_turn=_limit(flat, "angular.z"),
            sideways=source if any(map(_MECANUM.search, [*flat, str(flat.get("type", "")), within])) else "",
            joints=frozenset(joints),
            unused=_unused(flat.items()),
        )
        return
    for key, inner in value.items():
        yield from drives_in_parameters(inner, source, depth=depth + 1, within=f"{within}/{key}")


def _flattened(value: Mapping[Any, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield parameters by their names with dots."""
    for key, inner in value.items():
        name = f"{prefix}{key}"
        if isinstance(inner, Mapping) and name.count(".") < MAX_DEPTH:
            yield from _flattened(inner, f"{name}.")
        else:
            yield name, inner


def _names(value: Any) -> list[str]:
    """Return the joints that a parameter names."""
    return [value] if isinstance(value, str) else [str(name) for name in value] if isinstance(value, list) else []


def _positive(flat: Mapping[str, Any], key: str) -> float | None:
    value = flat.get(key)
    number = finite_number(str(value)) if isinstance(value, int | float | str) else None
    return number if number is not None and number > 0.0 else None


def _limit(flat: Mapping[str, Any], axis: str) -> float | None:
    """Return the limit of a speed, unless it is switched off."""
    return None if flat.get(f"{axis}.has_velocity_limits") is False else _positive(flat, f"{axis}.max_velocity")


def said_about(names: Set[str], said: Sequence[SaidDrive]) -> SaidDrive:
    """Return what is stated about the drive of the wheels on some joints; the first value of each counts."""
    fitting = [each for each in said if not each.joints or each.joints & names]

    def first(key: str) -> float | None:
        return next((value for each in fitting if (value := getattr(each, key)) is not None), None)

    speeds = {name: speed for each in reversed(fitting) for name, speed in each.wheel_speeds.items() if name in names}
    source = next((each.source for each in fitting if each.max_speed is not None), "")
    return SaidDrive(
        source=source or next((each.source for each in fitting), ""),
        wheel_radius=first("wheel_radius"),
        separation=first("separation"),
        max_speed=first("max_speed"),
        max_turn=first("max_turn"),
        sideways=next((each.sideways for each in fitting if each.sideways), ""),
        wheel_speeds=speeds,
        unused=next((each.unused for each in fitting if each.unused), ()),
    )
