"""Shipped presets: one YAML file each, in a folder of the assets per kind."""

from functools import cache
from importlib import resources
from typing import Any

from mjsim.world.yaml import read_text


@cache
def shipped_names(folder: str) -> tuple[str, ...]:
    """Return the names of all presets in a folder such as 'robots' or 'sensors/lidar', sorted."""
    files = resources.files("mjsim.assets").joinpath(folder).iterdir()
    return tuple(sorted(file.name.removesuffix(".yaml") for file in files if file.name.endswith(".yaml")))


@cache
def shipped_keys(folder: str, name: str) -> dict[str, Any]:
    """Return the keys of a preset; copy them before changing them."""
    file = resources.files("mjsim.assets") / folder / f"{name}.yaml"
    node, problems = read_text(file.read_text(encoding="utf-8"), file=str(file))
    assert node is not None, problems
    assert not problems, problems
    return dict(node.value)
