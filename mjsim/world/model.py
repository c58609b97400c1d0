"""The world: everything that a world file says, checked and frozen."""

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import Field, PrivateAttr, model_validator

from mjsim.errors import did_you_mean
from mjsim.world.base import KEY, Model, Name, fault
from mjsim.world.robots import Camera, Robot
from mjsim.world.running import Run, nearest_divisor, whole_steps
from mjsim.world.source import BUILT, Source
from mjsim.world.source import read_asset as read_named_asset
from mjsim.world.structure import Beacon, Floor, Obstacle, Wall


class World(Model):
    """A room or a floor of a building, its robots, and how a run drives them."""

    mjsim: Literal[1] = 1
    """Version of this format."""
    name: Name = "world"
    """Names the folder of its runs."""
    walls: Annotated[tuple[Wall, ...], Field(strict=False)] = ()
    """Runs of straight walls."""
    obstacles: Annotated[tuple[Obstacle, ...], Field(strict=False)] = ()
    """Boxes and cylinders on the floor."""
    beacons: Annotated[tuple[Beacon, ...], Field(strict=False)] = ()
    """Pictures on the walls, and reflectors."""
    floor: Floor = Floor()
    """The level floor under everything."""
    robots: Annotated[tuple[Robot, ...], Field(strict=False)] = ()
    """Wheeled robots."""
    run: Run = Run()
    """How `mjsim run` drives this world."""
    _source: Source = PrivateAttr(default=BUILT)

    @property
    def source(self) -> Source:
        """Where it was written."""
        return self._source

    def read_asset(self, name: str) -> bytes:
        """Return a file that this world names; raises ValueError when there is none."""
        return read_named_asset(name, self._source)

    @model_validator(mode="after")
    def _parts_fit(self) -> Self:
        named = {"walls", "obstacles", "beacons", "robots"}
        for message, path in misfits(self.model_dump(include={*named, "run"})):
            raise fault(message, *path)
        return self


def misfits(keys: Mapping[str, Any]) -> Iterator[tuple[str, tuple[str | int, ...]]]:
    """Yield what does not fit together in the keys of a world, each a sentence and where the value stands.

    The values may be of any type: what is wrong on its own is for the models to say.
    """
    yield from _names_taken(keys)
    yield from _sensors_taken(keys)
    run = keys.get("run", {})
    if isinstance(run, dict):
        yield from _drivers_without_robot(run, keys)
        yield from _rates_between_ticks(run, keys)


def _items(keys: Mapping[str, Any], kind: str) -> Iterator[tuple[int, dict[str, Any]]]:
    items = keys.get(kind)
    if isinstance(items, (list, tuple)):
        yield from ((index, item) for index, item in enumerate(items) if isinstance(item, dict))


def _names_taken(keys: Mapping[str, Any]) -> Iterator[tuple[str, tuple[str | int, ...]]]:
    owners: dict[str, str] = {}
    for kind in ("walls", "obstacles", "beacons", "robots"):
        for index, item in _items(keys, kind):
            name = item.get("name")
            if not isinstance(name, str):
                continue
            if name in owners:
                yield f"name '{name}' is taken by {owners[name]}; give each item its own", (kind, index, "name")
            owners.setdefault(name, f"{kind}[{index}]")


def _sensors_taken(keys: Mapping[str, Any]) -> Iterator[tuple[str, tuple[str | int, ...]]]:
    for index, robot in _items(keys, "robots"):
        known: set[str] = set()
        for number, sensor in _items(robot, "sensors"):
            name = sensor.get("camera")
            if isinstance(name, str) and name in known:
                message = f"name '{name}' is taken by another sensor of this robot; give each its own"
                yield message, ("robots", index, "sensors", number, "camera")
            elif isinstance(name, str):
                known.add(name)


def _drivers_without_robot(
    run: Mapping[str, Any], keys: Mapping[str, Any]
) -> Iterator[tuple[str, tuple[str | int, ...]]]:
    drivers = run.get("drivers")
    robots = [item["name"] for _, item in _items(keys, "robots") if isinstance(item.get("name"), str)]
    for name in drivers if isinstance(drivers, dict) else ():
        if name not in robots:
            yield f"no robot '{name}' in this world{did_you_mean(name, robots)}", ("run", "drivers", name, KEY)


def _rates_between_ticks(
    run: Mapping[str, Any], keys: Mapping[str, Any]
) -> Iterator[tuple[str, tuple[str | int, ...]]]:
    tick = run.get("rate_hz", Run().rate_hz)
    if not _is_rate(tick) or not whole_steps(tick):
        return
    for index, robot in _items(keys, "robots"):
        for number, sensor in _items(robot, "sensors"):
            rate = sensor.get("rate_hz", Camera.model_fields["rate_hz"].default)
            if not _is_rate(rate) or abs(tick / rate - round(tick / rate)) < 1e-9:
                continue
            nearest = nearest_divisor(tick, rate)
            yield (
                f"rate_hz is {rate:g} Hz; it must divide the {tick:g} Hz of the tick, the nearest is {nearest:g} Hz",
                ("robots", index, "sensors", number, "rate_hz"),
            )


def _is_rate(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and 0 < value <= 1000
