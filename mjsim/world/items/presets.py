"""Robot presets, overridden by the user's keys."""

import posixpath
from collections.abc import Mapping
from typing import Any

from mjsim.errors import did_you_mean
from mjsim.sentences import Sentence
from mjsim.world.files import Source, read_asset
from mjsim.world.items.bodies import SHAPES
from mjsim.world.items.shipped_presets import shipped_keys, shipped_names
from mjsim.world.yaml import read_text

_OTHER_SHAPES = ("box", "polygon", "model")
"""Keys of bodies other than a cylinder."""
OF_ONE = ("name", "at", "heading_deg")
"""Keys of a robot that a preset does not contain."""


def over_preset(name: str, keys: Mapping[str, Any], source: Source) -> dict[str, Any]:
    """Return the keys of a robot merged with those of its preset.

    Args:
        name: Name of a robot that comes with mjsim, or the path of a file relative to the world's folder.
        keys: The user's own.
        source: Source of the world, to locate the file.

    Raises:
        ValueError: The preset does not exist, or its file is invalid.
    """
    if is_preset_file(name):
        below = _from_file(name, source)
    elif name in preset_names():
        below = dict(shipped_keys("robots", name))
    else:
        raise ValueError(Sentence("no preset '{name}'{meant}", name, did_you_mean(name, preset_names())))
    _check_drive(name, below.get("drive", {}), keys.get("drive"))
    body = keys.get("body")
    if isinstance(body, Mapping) and any(key in body for key in _OTHER_SHAPES):
        # Another shape replaces that of the preset with all its keys, including the look of the old one.
        of_shape = {key for shape in SHAPES.values() for key in shape}
        below["body"] = {key: value for key, value in below["body"].items() if key not in {*of_shape, "look"}}
    merged: dict[str, Any] = _merged(below, keys)
    return merged


def _check_drive(name: str, below: Mapping[str, Any], above: Any) -> None:
    """Raise ValueError if the user's keys describe another kind of drive than the preset."""
    if not isinstance(above, Mapping):
        return
    kind, requested = below.get("type", "differential"), above.get("type")
    if "use" in above:
        raise ValueError(
            Sentence("preset '{name}' has a drive of its own, {kind}; leave out the preset to use yours", name, kind)
        )
    if requested is not None and requested != kind:
        raise ValueError(
            Sentence(
                "preset '{name}' has the drive {kind}, not {requested}; leave out 'type' or the preset",
                name,
                kind,
                requested,
            )
        )


def is_preset_file(name: str) -> bool:
    """Return whether a preset is a file, not the name of a shipped preset."""
    return name.endswith((".yaml", ".yml"))


def _from_file(name: str, source: Source) -> dict[str, Any]:
    """Return the keys of the robot in a file: a world with one robot, or only its keys."""
    try:
        text = read_asset(name, source).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError(Sentence("'{name}' is not UTF-8 text; write the file as UTF-8 text", name)) from None
    node, problems = read_text(text, file=name)
    if problems or node is None:
        raise ValueError(str(problems[0]) if problems else Sentence("'{name}' is empty", name))
    keys = node.value
    if isinstance(keys, dict) and "mjsim" in keys:
        robots = keys.get("robots")
        if not (isinstance(robots, list) and len(robots) == 1 and isinstance(robots[0], dict)):
            raise ValueError(Sentence("'{name}' is a world without exactly one robot; name the file of a robot", name))
        keys = {key: value for key, value in robots[0].items() if key not in OF_ONE}
    if not isinstance(keys, dict) or "preset" in keys:
        raise ValueError(Sentence("'{name}' does not describe a robot; name what mjsim new --robot-from wrote", name))
    body = keys.get("body")
    if isinstance(body, dict) and isinstance(body.get("model"), str):
        keys = {**keys, "body": {**body, "model": posixpath.join(posixpath.dirname(name), body["model"])}}
    return dict(keys)


def preset_names() -> tuple[str, ...]:
    """Return the names of all presets, sorted."""
    return shipped_names("robots")


def _merged(below: Any, above: Any) -> Any:
    """Return mappings merged key by key; any other value overrides the lower one."""
    if not (isinstance(below, Mapping) and isinstance(above, Mapping)):
        return above
    return {**below, **{key: _merged(below.get(key), value) for key, value in above.items()}}
