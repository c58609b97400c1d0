"""What SimMechanics has and mechanisms here do not: what to use in its place."""

from collections.abc import Mapping
from typing import Any

from mjsim.world.ground import fault

INSTEAD = {
    ("bodies", "variable_mass"): "a mass that changes is not simulated; give the change of weight as"
    " {force: BODY.center, axis: [0, 0, -1], signal: ...}",
    ("bodies", "variable_inertia"): "an inertia that changes is not simulated; move a mass on a prismatic joint with"
    " position: JOINT",
}
"""By the list and the key."""


def refuse(keys: Any) -> None:
    """Raise a fault for what stands in a mechanism and cannot be simulated.

    Args:
        keys: Of the mechanism, as they are written.
    """
    for (part, key), line in INSTEAD.items():
        items = keys.get(part) if isinstance(keys, Mapping) else None
        for number, item in enumerate(items if isinstance(items, (list, tuple)) else ()):
            if isinstance(item, Mapping) and key in item:
                raise fault(line, part, number, key)
