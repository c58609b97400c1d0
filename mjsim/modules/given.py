"""Read-only inputs of modules, since they are shared with other modules, the recording and the simulation."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from functools import cache
from typing import Any, NoReturn, TypeVar

import numpy as np

from mjsim.interface import BeaconInfo, Observation, RobotInfo, WorldMap, all_fields

K = TypeVar("K")
V = TypeVar("V")
_READINGS = tuple(part.name for part in all_fields(Observation) if part.is_mapping)
"""The fields of an observation with readings by the name of their sensor."""
_PLAIN = frozenset({float, int, str, bool, type(None), np.float64})


class Sealed(dict[K, V]):
    """A read-only dict; a copy, also a deep or pickled one, is a plain dict."""

    def _refuse(self, *arguments: object, **named: object) -> NoReturn:
        raise TypeError("inputs of a module are read-only; copy them first")

    __setitem__ = __delitem__ = __ior__ = clear = pop = popitem = setdefault = update = _refuse

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle and deepcopy as a plain dict."""
        return dict, (dict(self),)


_EMPTY: Sealed[str, Any] = Sealed()


def sealed_observation(seen: Observation) -> Observation:
    """Return a read-only observation: its arrays are made read-only in place, its dicts are read-only copies."""
    seal(seen)
    readings = {name: getattr(seen, name) for name in _READINGS}
    sealed: dict[str, Any] = {
        name: Sealed(items) if items else _EMPTY for name, items in readings.items() if type(items) is dict
    }
    return replace(seen, **sealed) if sealed else seen


def sealed_robot(robot: RobotInfo) -> RobotInfo:
    """The same for the data sheet of a robot."""
    seal(robot)
    return replace(robot, sensors=_sealed(robot.sensors), arms=_sealed(robot.arms))


def sealed_catalogue(catalogue: Mapping[str, BeaconInfo]) -> Mapping[str, BeaconInfo]:
    """The same for the catalogue of beacons."""
    seal(dict(catalogue))
    return Sealed(catalogue)


def sealed_map(map: WorldMap | None) -> WorldMap | None:
    """The same for the map."""
    seal(map)
    return map if map is None else replace(map, beacons=_sealed(map.beacons))


def seal(value: Any) -> None:
    """Make the arrays in a value read-only, also those within tuples, dicts and values of mjsim."""
    kind: Any = type(value)
    if kind is np.ndarray:
        value.setflags(False)  # not to be written
    elif kind is tuple:
        for item in value:
            seal(item)
    elif kind is dict or kind is Sealed:
        for item in value.values():
            seal(item)
    elif kind not in _PLAIN:
        # Lazily rendered pictures have no fields, and stay as they are.
        for name in _sealable(kind):
            seal(getattr(value, name))


@cache
def _sealable(kind: Any) -> tuple[str, ...]:
    """Return the fields of a value of mjsim that are not just a number or a text."""
    parts = fields(kind) if is_dataclass(kind) else ()
    return tuple(part.name for part in parts if getattr(part.type, "__origin__", part.type) not in _PLAIN)


def _sealed(items: Mapping[K, V]) -> Mapping[K, V]:
    return Sealed(items) if type(items) is dict else items
