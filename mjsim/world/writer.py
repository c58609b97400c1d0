"""`World` to text; a world that was read keeps its comments and its layout."""

import io
import re
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq
from ruamel.yaml.scalarstring import DoubleQuotedScalarString

from mjsim.errors import WorldError
from mjsim.world.base import Model
from mjsim.world.model import World
from mjsim.world.reader import parse_world
from mjsim.world.robots import Robot
from mjsim.world.sensors import KINDS
from mjsim.world.text import plain_value

_FIRST = ("mjsim", "name", "use", "preset", *KINDS, "box", "cylinder", "type", "segment", "at", "heading_deg")
"""Keys in the order in which people look for them; all others come after, as the models have them."""
_PLAIN = re.compile(r"[A-Za-z_./][\w./+-]*(:[\w./+-]+)*")
"""Text that needs no quotes, wherever it stands, unless it reads as another kind of value."""
_LINE = 110
"""An item that fits into so many characters stands on one line."""


def format_world(world: World) -> str:
    """Return a text that `parse_world` reads as an equal world.

    A world that was read from text gives that text; where it was changed since, only what differs is
    written anew and all other comments stay. Values that say what is the default anyway are left out.
    """
    text = world.source.text
    if text is None:
        return _dumped(_styled(_keys_of_world(world)))
    before = parse_world(text, source=world.source)
    if before == world:
        return text
    tree = _round_trip().load(text)
    _update(tree, _keys_of_world(before), _keys_of_world(world))
    changed = _dumped(tree)
    try:
        if parse_world(changed, source=world.source) == world:
            return changed
    # An alias that stands for two values cannot be changed in one place only.
    except WorldError:
        pass
    return _dumped(_styled(_keys_of_world(world)))


def _keys_of_world(world: World) -> dict[str, Any]:
    """Return what has to be written: all that is not the default, or not the preset's."""
    keys = _plain(world.model_dump(mode="json", exclude_defaults=True, exclude={"robots"}))
    if world.robots:
        keys["robots"] = [_keys_of_robot(robot) for robot in world.robots]
    keys = {"mjsim": world.mjsim, "name": world.name, **keys}
    return {key: keys[key] for key in World.model_fields if key in keys}


def _keys_of_robot(robot: Robot) -> dict[str, Any]:
    given = {"name": robot.name, "at": robot.at}
    if robot.preset is not None:
        given["preset"] = robot.preset
    base = Robot.model_validate(given)
    keys: dict[str, Any] = _plain({**robot.model_dump(mode="json", include=set(given)), **_differing(robot, base)})
    return keys


def _differing(value: Model, base: Model) -> dict[str, Any]:
    """Return the keys of a model whose values differ from those of another of its kind."""
    found = {}
    for key in type(value).model_fields:
        here, there = getattr(value, key), getattr(base, key)
        if here == there:
            continue
        if isinstance(here, Model) and type(here) is type(there):
            found[key] = _differing(here, there)
        else:
            found[key] = value.model_dump(mode="json", include={key}, exclude_defaults=True).get(key, here)
    return found


def _plain(value: Any) -> Any:
    """Return a value in lists and dicts, whole numbers without their '.0', the important keys first."""
    if isinstance(value, dict):
        order = sorted(value, key=lambda key: _FIRST.index(key) if key in _FIRST else len(_FIRST))
        return {key: _plain(value[key]) for key in order}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        return int(value)
    return value


def _styled(value: Any, *, depth: int = 0) -> Any:
    """Return a value laid out for people: what is short or holds only numbers on one line."""
    if isinstance(value, str):
        return _text(value)
    if not isinstance(value, (dict, list)):
        return value
    inner = value.values() if isinstance(value, dict) else value
    flat = isinstance(value, list) and not any(isinstance(item, dict) for item in inner)
    short = depth > 1 and len(str(value)) <= _LINE and not any(isinstance(item, dict) and item for item in inner)
    styled: CommentedMap | CommentedSeq
    if isinstance(value, dict):
        styled = CommentedMap({_text(key): _styled(item, depth=depth + 1) for key, item in value.items()})
    else:
        styled = CommentedSeq([_styled(item, depth=depth + 1) for item in value])
    if flat or short or not value:
        styled.fa.set_flow_style()
    return styled


def _text(value: str) -> str:
    """Return a text with quotes where it needs them; ruamel.yaml leaves them out where not even itself can do so."""
    plain = _PLAIN.fullmatch(value) and plain_value(value) == value
    return value if plain else DoubleQuotedScalarString(value)


def _update(tree: Any, before: Any, after: Any) -> None:
    """Change a text's own tree where the values after differ from those before."""
    if isinstance(after, list):
        _update_list(tree, before, after)
        return
    for key in before.keys() - after.keys():
        tree.pop(key, None)
    for key, value in after.items():
        if key in before and before[key] == value:
            continue
        if key in tree and type(before.get(key)) is type(value) and isinstance(value, (dict, list)):
            _update(tree[key], before[key], value)
        else:
            tree[key] = _styled(value, depth=2)


def _update_list(tree: Any, before: list[Any], after: list[Any]) -> None:
    kept = list(before)
    for index in reversed(range(len(kept))):
        if not any(_same(kept[index], item) for item in after) and len(kept) > len(after):
            del tree[index], kept[index]
    for index, value in enumerate(after):
        if index >= len(kept):
            tree.append(_styled(value, depth=2))
        elif kept[index] != value:
            if isinstance(value, (dict, list)) and type(kept[index]) is type(value) and _same(kept[index], value):
                _update(tree[index], kept[index], value)
            else:
                tree[index] = _styled(value, depth=2)
    del tree[len(after) :]


def _same(one: Any, other: Any) -> bool:
    """Return whether two items are one thing, perhaps changed: by name, else by value."""
    if isinstance(one, dict) and isinstance(other, dict):
        names = [next((item[key] for key in ("name", *KINDS) if key in item), None) for item in (one, other)]
        if names != [None, None]:
            return bool(names[0] == names[1])
        return bool(one == other) or one.keys() == other.keys()
    return bool(one == other)


def _round_trip() -> YAML:
    yaml = YAML(typ="rt", pure=True)
    yaml.width = 120
    yaml.indent(mapping=2, sequence=4, offset=2)
    yaml.preserve_quotes = True
    return yaml


def _dumped(tree: Any) -> str:
    stream = io.StringIO()
    _round_trip().dump(tree, stream)
    return stream.getvalue()
