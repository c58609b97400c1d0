"""The baked light of a world, asked for when a picture first shows it."""

from collections.abc import Callable

import mujoco

from mjsim.light import BakedLight, key_of, light_of, stored
from mjsim.sim.rendering.snapshot import Snapshot
from mjsim.world import World

LightSource = Callable[[], BakedLight | None]
"""Returns the baked light of a model; None for plain light."""


def light_source(world: World, model: mujoco.MjModel) -> LightSource | None:
    """Return the source of a world's light, None for a world with plain shading.

    The light is that of the compiled world at its start, even if events have changed it since.

    Args:
        world: The world.
        model: The compiled world, at its start.
    """
    if world.shading == "plain":
        return None
    start, kept = Snapshot(model), list[BakedLight | None]()

    def light() -> BakedLight | None:
        if not kept:
            now = Snapshot(model)
            start.restore(model)
            try:
                kept.append(light_of(world, model))
            finally:
                now.restore(model)
        return kept[0]

    return light


def kept_light(world: World, model: mujoco.MjModel) -> BakedLight | None:
    """Return the light of a world if it is in the cache, for views that do not wait; None for plain light too.

    Args:
        world: The world.
        model: The compiled world, at its start.
    """
    return None if world.shading == "plain" else stored(key_of(world, model))
