"""Features of SimMechanics that mechanisms here lack: what to use instead."""

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
    """Raise a fault for keys of a mechanism that cannot be simulated.

    Args:
        keys: Of the mechanism, as written.
    """
    for (part, key), line in INSTEAD.items():
        items = keys.get(part) if isinstance(keys, Mapping) else None
        for number, item in enumerate(items if isinstance(items, (list, tuple)) else ()):
            if isinstance(item, Mapping) and key in item:
                raise fault(line, part, number, key)
