"""The light of a world: from the cache, or baked and kept there."""

import mujoco

from mjsim.light.baked import BakedLight
from mjsim.light.stored import baking, key_of, store, stored
from mjsim.progress import say, tracked
from mjsim.world import World


def light_of(world: World, model: mujoco.MjModel) -> BakedLight | None:
    """Return the light of a world with `shading: baked`, from the cache or computed now with progress on stderr.

    It is None for a world with plain shading, and if the ray caster does not work; then a line says so.

    Args:
        world: The world.
        model: The compiled world, not changed; whether objects are removed or lamps changed has no effect.
    """
    if world.shading == "plain":
        return None
    key = key_of(world, model)
    if (light := stored(key)) is not None:
        return light
    if (reason := _unusable()) is not None:
        say(f"world '{world.name}' is shown with plain light: Embree cannot be used ({reason}); install embreex")
        return None
    with baking(key, lambda: stored(key) is not None):
        if (light := stored(key)) is None:
            light = store(key, _baked(world, model))
    return light


def _baked(world: World, model: mujoco.MjModel) -> BakedLight:
    from mjsim.light.bake import bake

    with tracked(f"light of '{world.name}'", total=100.0, unit="%") as advance:
        return bake(world, model, done=lambda share: advance(100.0 * share))


def _unusable() -> str | None:
    """Return why Embree cannot be used; None if it can."""
    try:
        import embreex.mesh_construction
        import embreex.rtcore_scene  # noqa: F401 (only tried)
    except (ImportError, OSError) as error:
        return str(error).splitlines()[0]
    return None
