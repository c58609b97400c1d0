"""Lamps whose baked light reaches nothing: above the ceiling, or inside a wall or an object."""

from collections.abc import Iterator

import numpy as np

from mjsim.world.check.overlaps import MAX_OVERLAP, Finding, Solids, pair
from mjsim.world.items import World


def hidden_lamps(world: World) -> Iterator[Finding]:
    """Yield the lamps that light nothing; in plain light there are no shadows, and all lamps shine."""
    if world.shading == "plain" or not world.lamps:
        return
    solids, ceiling = Solids(world), _ceiling(world)
    for index, lamp in enumerate(world.lamps):
        level = lamp.height - MAX_OVERLAP
        found = solids.reached(np.array([lamp.at]), depth=MAX_OVERLAP, low=level, high=lamp.height)
        name = f"lamp '{lamp.name}'" if lamp.name else f"lamps[{index}]"
        if found:
            yield f"{name} at {pair(lamp.at)} is inside {found} and lights nothing; move it out", ("lamps", index, "at")
        elif ceiling is not None and level > ceiling:
            yield (
                f"{name} is {lamp.height:g} m high, above the ceiling at {ceiling:g} m, and lights nothing; lower it",
                ("lamps", index, "height" if "height" in lamp.model_fields_set else "at"),
            )


def _ceiling(world: World) -> float | None:
    """Return the height of the ceiling [m]; None if there is none, or objects alone determine it."""
    if world.ceiling is None:
        return None
    if world.ceiling.height is not None:
        return world.ceiling.height
    return max((wall.height for wall in world.walls), default=None)
