"""Labels of compared runs, from the settings that differ, or else from their files."""

import json
import re
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from mjsim.report.comparison import RunFigures
from mjsim.sentences import Sentence
from mjsim.world import World

MAX_SETTINGS = 4
"""Worlds that differ in more settings are labelled by their names."""
PARTS = ("observer", "estimator", "navigator")
"""Parts of a driver whose classes are in a recording."""
_LEFT_OUT = ("run.seed", "run.view", "mjsim")
"""Keys of a world without effect on a run, and the seed."""
_OF_THE_RUN = ("name", "robots", "run")
"""Keys of a world whose values may differ between runs in the same environment."""
_NUMBERED = re.compile(r"[-_. ]*(?:seed|run)?[-_. ]*\d+$", re.IGNORECASE)


@dataclass(frozen=True, slots=True, kw_only=True)
class Found:
    """A run that is not yet labelled."""

    run: RunFigures
    path: Path
    settings: Mapping[str, str]
    world: str
    """Name of the world."""
    folder: str = ""
    """The label given with it, or the folder of several runs that contains it."""


def settings_of(world: World, metadata: Mapping[str, str]) -> dict[str, str]:
    """Return all settings of a run as text, by keys such as 'robots.scout.odometry.noise.turn'.

    Args:
        world: Its world.
        metadata: Metadata of its recording, which gives the modules if they are not those of the world.
    """
    leaves = dict(_leaves(world.model_dump(mode="json"), ""))
    if "modules" in metadata:
        modules = json.loads(metadata["modules"])
        for robot in {*modules, *world.run.drivers}:
            for part in PARTS:
                _put_module(leaves, f"run.drivers.{robot}.{part}", modules.get(robot, {}).get(part))
    for part in PARTS:
        if f"replayed {part}" in metadata:
            _put_module(leaves, f"run.drivers.{metadata['replayed robot']}.{part}", metadata[f"replayed {part}"])
    for part, use in json.loads(metadata.get("replayed modules", "{}")).items():
        key = f"run.drivers.{metadata['replayed robot']}.{part}"
        _put_module(leaves, key, None)
        leaves |= dict(_leaves(use, key))
    return {key: value for key, value in leaves.items() if not key.startswith(_LEFT_OUT)}


def _put_module(leaves: dict[str, str], key: str, name: str | None) -> None:
    """Set the class that was used, or none; settings of another class in the world are dropped."""
    if name is not None and _class(leaves.get(f"{key}.use", "")) == name:
        return
    for other in [leaf for leaf in leaves if leaf == key or leaf.startswith(f"{key}.")]:
        del leaves[other]
    if name is not None:
        leaves[f"{key}.use"] = name


def _class(use: str) -> str:
    """Return the class of 'dotted.module:Class'."""
    return use.rpartition(":")[2]


def _leaves(value: Any, path: str) -> Iterable[tuple[str, str]]:
    """Yield key and text of each value in a tree; items of lists go by their names."""
    before = f"{path}." if path else ""
    if isinstance(value, Mapping):
        for key, item in value.items():
            yield from _leaves(item, f"{before}{key}")
    elif isinstance(value, list) and any(isinstance(item, Mapping) for item in value):
        for number, item in enumerate(value):
            name = item.get("name") if isinstance(item, Mapping) else None
            yield from _leaves(item, f"{before}{name or number}")
    elif value is not None:
        # With all digits: values that differ only in the last one are different.
        yield path, value if isinstance(value, str) else json.dumps(value)


def setting_labels(settings: Sequence[Mapping[str, str]], names: Sequence[str]) -> list[str] | None:
    """Return a label for each run, made of the settings in which the runs differ.

    Args:
        settings: Settings of each run, from `settings_of`.
        names: Names of their worlds, for runs in which nothing differs, or too much.

    Returns:
        Labels such as 'EkfSlam, jacobians=invariant', equal for equal settings; None if too much differs for that, and
        the names do not distinguish the worlds.
    """
    implied = (_implied_by_class, _implied_by_world)
    keys = [key for key in _differing(settings) if not any(implies(key, settings) for implies in implied)]
    if len(keys) <= MAX_SETTINGS:
        return [", ".join(_label_parts(each, keys, settings)) for each in settings] if keys else list(names)
    kinds = {tuple(sorted(each.items())) for each in settings}
    return list(names) if len(set(names)) == len(kinds) else None


def _differing(settings: Sequence[Mapping[str, str]]) -> list[str]:
    everything = dict.fromkeys(key for each in settings for key in each)
    return [key for key in everything if len({each.get(key) for each in settings}) > 1]


def _implied_by_class(key: str, settings: Sequence[Mapping[str, str]]) -> bool:
    """Return whether an argument of a module is the same wherever its class is, so that the class implies it."""
    use = f"{key.rpartition('.')[0]}.use"
    if key.endswith(".use") or not any(use in each for each in settings):
        return False
    classes = {each.get(use) for each in settings}
    return len(classes) > 1 and len({(each.get(use), each.get(key)) for each in settings}) == len(classes)


def _implied_by_world(key: str, settings: Sequence[Mapping[str, str]]) -> bool:
    """Return whether a setting of the environment is implied by the name of the world."""
    names = {each.get("name") for each in settings}
    if key.partition(".")[0] in _OF_THE_RUN or None in names or len(names) == 1:
        return False
    return len({(each.get("name"), each.get(key)) for each in settings}) == len(names)


def _label_parts(own: Mapping[str, str], keys: Sequence[str], settings: Sequence[Mapping[str, str]]) -> Iterable[str]:
    """Yield the label text of each key; an argument that the class of the run does not accept is left out."""
    shorts = _short_keys(keys)
    for key in keys:
        use = f"{key.rpartition('.')[0]}.use"
        if key == "name" and key in own:
            yield own[key]
        elif key.endswith(".use"):
            yield _class_name(own.get(key), key, [each[key] for each in settings if key in each])
        elif any(key in each and each.get(use) == own.get(use) for each in settings):
            yield f"{shorts[key]}={own.get(key, 'default')}"


def _class_name(use: str | None, key: str, uses: Sequence[str]) -> str:
    """Return a class without its module, if that is unique."""
    if use is None:
        return "odometry" if key.endswith(".estimator.use") else Sentence("no {key}", key.split(".")[-2])
    return use if len({_class(each) for each in uses}) < len(set(uses)) else _class(use)


def _short_keys(keys: Sequence[str]) -> dict[str, str]:
    """Return the shortest unique end of each key; for a module its last part may suffice."""
    shorts = {}
    for key in keys:
        parts = key.split(".")
        least = 1 if key.startswith("run.drivers.") else min(2, len(parts))
        ends = (".".join(parts[-count:]) for count in range(least, len(parts) + 1))
        shorts[key] = next(end for end in ends if sum(f".{other}".endswith(f".{end}") for other in keys) == 1)
    return shorts


def file_labels(paths: Sequence[Path]) -> list[str]:
    """Return a label for each recording from its file: equal for files that only differ in a number at the end.

    'ekf-1.mcap' and 'ekf-2.mcap' are both 'ekf'; files with the same name are distinguished by their folders.
    """
    stems = [_NUMBERED.sub("", path.stem) for path in paths]
    if len(set(stems)) > 1 and all(stems):
        return stems
    folders = [path.absolute().parent.name for path in paths]
    return folders if len(set(folders)) > 1 else [path.stem for path in paths]


def labelled(found: Sequence[Found]) -> list[RunFigures]:
    """Return runs with their labels: those given, the settings that differ, or their files, whichever can be paired.

    If some have the name of a folder or a given label, the others have the names of their files.
    """
    files = file_labels([each.path for each in found])
    settings = setting_labels([each.settings for each in found], [each.world for each in found]) or files
    choices = [settings, files, _joined(settings, files)]
    if any(each.folder for each in found):
        given = [each.folder or _NUMBERED.sub("", each.path.stem) or each.path.stem for each in found]
        choices = [given, _joined(given, settings), _joined(given, files)]
    kinds = [tuple(sorted(each.settings.items())) for each in found]
    runs = list(zip(kinds, (each.run.seed for each in found), strict=True))
    labels = next((choice for choice in choices if _fit(choice, runs)), [str(each.path) for each in found])
    return [replace(each.run, label=label) for each, label in zip(found, labels, strict=True)]


def differing_worlds(found: Sequence[Found]) -> str:
    """Describe how the worlds of runs differ, except in robots and run settings; empty if they do not.

    Only worlds whose settings are all known are considered; sweeps only store changed settings.
    """
    keys = _differing([each.settings for each in found])
    parts = sorted({part for key in keys if (part := key.partition(".")[0]) not in _OF_THE_RUN})
    if not parts:
        return ""
    shown = ", ".join(parts[:MAX_SETTINGS]) + (", ..." if len(parts) > MAX_SETTINGS else "")
    return Sentence("the worlds of these runs differ in {shown}; this may be why the runs differ", shown)


def _fit(labels: Sequence[str], runs: Sequence[tuple[Hashable, int]]) -> bool:
    """Return whether runs with the same label have equal settings and different seeds."""
    kinds = {(label, settings) for label, (settings, _) in zip(labels, runs, strict=True)}
    seeds = {(label, seed) for label, (_, seed) in zip(labels, runs, strict=True)}
    return all(labels) and len(kinds) == len(set(labels)) and len(seeds) == len(labels)


def _joined(first: Sequence[str], second: Sequence[str]) -> list[str]:
    return [", ".join(part for part in pair if part) for pair in zip(first, second, strict=True)]
