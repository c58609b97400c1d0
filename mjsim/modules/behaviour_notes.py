"""Notes on behaviour of a valid world that a user may not expect; no module is run."""

from collections.abc import Iterator, Set
from functools import partial

from mjsim.errors import Problem
from mjsim.modules.use import NamedModule, host_of, modules_of
from mjsim.sentences import Sentence
from mjsim.world import SENSOR_KINDS, Robot, Source, Use, World, name_of, problems_at, world_notes

_LOOKS = frozenset({"sightings", "cameras", "scans", "clouds", "ranges", "proximity", "bump"})
"""Readings of a robot's surroundings; a module needs only one of those that it uses."""
_ALWAYS = frozenset({"proximity", "bump", "messages"})
"""Readings that every robot has."""
_ROLES = ("observer", "estimator", "navigator", "avoidance")
_NAMING = {"cameras": "camera", "scans": "lidar"}
"""Reading -> the key of a module that names the sensor with such readings."""
_SOURCES: dict[str, str] = {
    model.reading: Sentence("a sensor ({kind}: NAME)", kind) for kind, model in SENSOR_KINDS.items()
}
_SOURCES |= {"sightings": "a sensor (beacons: NAME) or an observer", "joints": "an arm"}
_EFFECTS = {"estimator": ", so it is dead reckoning", "observer": ", so it sees nothing"}


def notes_on(world: World) -> list[Problem]:
    """Return notes on behaviour of a valid world that its user may not expect, sorted by position."""
    return sorted([*world_notes(world), *unfed_modules(world)])


def unfed_modules(world: World) -> list[Problem]:
    """Return the modules that use readings which their robot does not get, sorted by position."""
    faults = ((path, partial(str, message)) for message, path in _unfed(world))
    return sorted(problems_at(world.source.written, world.source.file, faults))


def readings_needed(use: str, role: str, source: Source) -> Set[str]:
    """Return readings of which a module needs one, as far as its text shows; none if every robot has one."""
    needed = _needed(set(host_of(use).readings(Use(use=use), role, source)))
    return frozenset() if needed & _ALWAYS else needed


def _unfed(world: World) -> Iterator[tuple[str, tuple[str | int, ...]]]:
    """Yield the modules that use readings which their robot does not have."""
    robots = {robot.name: robot for robot in world.robots}
    for named in modules_of(world):
        if named.role in _ROLES and (message := _lacking(named, robots[named.robot], world)):
            yield message, (*named.path, "use")


def _lacking(named: NamedModule, robot: Robot, world: World) -> str | None:
    """Return which readings a module uses and does not get; None if it gets one of the readings that it needs."""
    host, given = host_of(named.use.use), _given(robot, world)
    who, used = f"{named.role} {named.use.use.rpartition(':')[2]}", set[str]()
    for reading in host.readings(named.use, named.role, world.source):
        used.add(reading)
        if reading in _LOOKS & given:
            return _misnamed(named, robot, reading, world)
    needed = _needed(used)
    if not needed or needed & given:
        return None
    kinds, effect = sorted(needed), _EFFECTS.get(named.role, "")
    lacks = Sentence(
        "{who} uses {kinds}, which robot '{name}' does not get{effect}", who, " and ".join(kinds), robot.name, effect
    )
    if "sightings" in {sensor.reading for sensor in robot.sensors} & needed:
        return Sentence("{lacks}; this world has no beacons, add some", lacks)
    return Sentence("{lacks}; add {kinds}", lacks, " or ".join(_SOURCES[kind] for kind in kinds))


def _needed(used: Set[str]) -> Set[str]:
    """Return the readings that a module uses and of which it needs at least one."""
    return used & _LOOKS or used & _SOURCES.keys()


def _misnamed(named: NamedModule, robot: Robot, reading: str, world: World) -> str | None:
    """Return a note that a module names a sensor which its robot does not have; None otherwise."""
    key = _NAMING.get(reading)
    name = host_of(named.use.use).key(named.use, key, world.source) if key is not None else None
    sensors = [name_of(sensor) for sensor in robot.sensors if sensor.reading == reading]
    if not isinstance(name, str) or name in sensors:
        return None
    who = f"{named.role} {named.use.use.rpartition(':')[2]}"
    return Sentence(
        "{who} uses {key} '{name}', which robot '{robot}' does not have; it has {sensors}",
        *(who, key, name, robot.name, ", ".join(sensors)),
    )


def _given(robot: Robot, world: World) -> frozenset[str]:
    """Return the readings that a robot has in its world."""
    found = {sensor.reading for sensor in robot.sensors}
    modules = world.run.drivers.get(robot.name)
    if not world.beacons:
        found.discard("sightings")
    if modules is not None and modules.observer is not None:
        found.add("sightings")
    if robot.arms:
        found.add("joints")
    return _ALWAYS | found
