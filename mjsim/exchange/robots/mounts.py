"""Sensors of a robot: those its file describes, and links, sites and cameras with the names of sensors."""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from mjsim.exchange.robots.robot_frame import Stand
from mjsim.geometry import Array
from mjsim.inventory import Fate, FileItem
from mjsim.mechanics import placed
from mjsim.models import Anatomy, FileFrame, SaidSensor

WORDS = {
    "lidar": re.compile(r"lidar|laser|(^|_)scan|lds|hokuyo|rplidar|(^|_)sick|velodyne|vlp_?16|ouster|ust10|tim\d{3}"),
    "camera": re.compile(r"camera|realsense|kinect|astra|(^|_)zed|(^|_)oak|webcam|d4[135]5|r200|t265"),
    "imu": re.compile(r"(^|_)imu|inertial_?(sensor|unit|meas|nav)|gyro"),
}
"""Names of links that carry a sensor."""
NO_SENSOR = re.compile(r"mount|standoff|bracket|holder|support|tower|screw|plate|(^|_)cap($|_)")
MAX_TWIN_DISTANCE = 0.15
"""Sensors of one kind closer together than this, and looking the same way, are one sensor [m]."""
ALIKE = math.cos(math.radians(20.0))
"""Sensors whose directions differ by less than this angle look the same way."""
USUAL_KEYS = "range, field of view, rate and noise as usual"
MAX_GUESSED = {"lidar": 2, "camera": 2, "imu": 1}
"""Maximum number of sensors of each kind that only names suggest; all that are described are taken."""
MAX_FAN_BEAMS, MAX_FAN_RANGE = 16, 5.0
"""A fan of at most this many beams and rings, which reach no farther than this, is a proximity sensor [m]."""
MAX_BEAMS, MAX_RINGS, MAX_SIDE = 10_000, 256, 1920
"""Limits of a world: beams of a lidar, rings of a 3-D one, pixels along a picture."""
RING = "a fan of few short beams; each robot has a ring of 16 ranges instead, Observation.proximity"
LOWEST = {"lidar": 0.02, "lidar3d": 0.02, "camera": 0.02, "imu": -0.01}
"""Minimum height above the floor; lower frames are placeholders, or see only the floor [m]."""
OTHER_SENSORS = re.compile(r"sonar|ultraso|cliff|infrared|gps|gnss|radar|bumper", re.IGNORECASE)
NO_OTHERS = "each robot has a ring of 16 ranges and a bumper; mjsim has no other such sensor"
"""Names of links and sites for which mjsim has no sensor, and the note on each."""
WIDTH, HEIGHT = 640, 480
MAX_FOV = 150.0
"""Maximum field of view of a camera [deg]."""
MAX_PITCH = 85.0
"""Sensors that look up or down more steeply are left out [deg]."""
ALL_AROUND = 355.0
"""A lidar with a larger field of view sees all around [deg]."""
BEAM_FOV = 0.1
"""Field of view of a range finder with a single beam, which becomes two beams [deg]."""
RATES = (25.0, 12.5, 5.0, 2.5, 1.0)
"""Rates that divide the tick rate of 25 Hz [Hz]."""


@dataclass(frozen=True, slots=True)
class SensorMount:
    """A sensor of the preset."""

    kind: str
    name: str
    at: tuple[float, float, float]
    """Position, robot frame [m]."""
    yaw_deg: float
    pitch_deg: float
    keys: Mapping[str, Any] = field(default_factory=dict)
    origin: str = ""
    """Where the file describes it."""


def find_mounts(
    anatomy: Anatomy, stand: Stand, sensors: tuple[SaidSensor, ...]
) -> tuple[list[SensorMount], list[FileItem]]:
    """Return the sensors of a robot, lidars first, and notes on those that are left out or changed.

    All sensors that the file describes are taken; a link, site or camera named like one is taken where none is
    described, up to a bound.
    """
    chosen: list[SensorMount] = []
    items: list[FileItem] = []
    described = sorted(_described(anatomy, stand, sensors, items), key=lambda pair: _importance(pair[0]))
    for mount, changes in described:
        reason = _unfit(mount) or _same_as(mount, [other for other in chosen if _looks_alike(other, mount)])
        if reason:
            items.append(FileItem(Fate.LEFT_OUT, mount.kind, mount.name, reason))
        else:
            chosen.append(_renamed(mount, {other.name for other in chosen}))
            items += [FileItem(Fate.GUESSED, mount.kind, mount.name, change) for change in changes]
    for mount in (*_cameras(anatomy, stand), *_named(anatomy, stand)):
        same = [other for other in chosen if _family(other) == _family(mount)]
        if _unfit(mount) or _same_as(mount, same):
            continue
        if len(same) < MAX_GUESSED[mount.kind]:
            chosen.append(_renamed(mount, {other.name for other in chosen}))
            if mount.kind != "imu" and not mount.keys:
                items.append(
                    FileItem(Fate.GUESSED, mount.kind, mount.name, f"{USUAL_KEYS}: the file gives only its position")
                )
        else:
            why = f"{len(same)} of this kind are found by name already; add it to `sensors` of the preset if it is one"
            items.append(FileItem(Fate.LEFT_OUT, f"frame called like a sensor ({mount.kind})", mount.name, why))
    said = {sensor.link for sensor in sensors}
    names = (place.name for place in anatomy.places if place.name not in said and not NO_SENSOR.search(place.name))
    others = (name for name in names if OTHER_SENSORS.search(name))
    items += [FileItem(Fate.LEFT_OUT, "frame called like a sensor", name, NO_OTHERS) for name in others]
    return sorted(chosen, key=lambda mount: list(LOWEST).index(mount.kind)), items


def _importance(mount: SensorMount) -> tuple[int, float]:
    """Return the key by which described sensors are sorted: by kind, scanners that see most and farthest first."""
    seen = float(mount.keys.get("fov_deg", 0.0)) * float(mount.keys.get("range", (0.0, 0.0))[1])
    return list(LOWEST).index(mount.kind), -seen if mount.kind == "lidar" else 0.0


def _family(mount: SensorMount) -> str:
    """Return the kind by which sensors are counted."""
    return mount.kind.removesuffix("3d")


def _looks_alike(one: SensorMount, other: SensorMount) -> bool:
    """Return whether two described sensors are of one kind and look the same way."""
    if one.kind != other.kind:
        return False
    a, b = (math.radians(mount.yaw_deg) for mount in (one, other))
    c, d = (math.radians(mount.pitch_deg) for mount in (one, other))
    return math.cos(c) * math.cos(d) * math.cos(a - b) + math.sin(c) * math.sin(d) > ALIKE


def _same_as(mount: SensorMount, others: Sequence[SensorMount]) -> str:
    """Return which of some other sensors is the same one; '' if none is."""
    found = next((other.name for other in others if math.dist(other.at, mount.at) < MAX_TWIN_DISTANCE), None)
    return "" if found is None else f"at the place of '{found}', which looks the same way"


def _unfit(mount: SensorMount) -> str:
    """Return why a sensor cannot be part of a world; '' if it can."""
    if abs(mount.pitch_deg) >= MAX_PITCH:
        return f"looks {'up' if mount.pitch_deg > 0 else 'down'}, by {abs(mount.pitch_deg):.0f} degrees"
    if mount.at[2] <= LOWEST[mount.kind]:
        return f"{mount.at[2]:.3f} m above the floor; the minimum is {LOWEST[mount.kind]:g}"
    return ""


def _renamed(mount: SensorMount, taken: set[str]) -> SensorMount:
    name, number = mount.name, 2
    while name in taken or name in ("drive", "chase") or name.startswith("wheel_"):
        name, number = f"{mount.name}{number}", number + 1
    return replace(mount, name=name)


def _described(
    anatomy: Anatomy, stand: Stand, sensors: tuple[SaidSensor, ...], items: list[FileItem]
) -> Iterator[tuple[SensorMount, list[str]]]:
    """Yield the sensors that a file describes, each on its link or site, and what is changed.

    Notes on what cannot be a sensor are appended to `items`.
    """
    for sensor in sensors:
        place = next((place for place in anatomy.places if place.name == sensor.link), None)
        why = _unlike(sensor, place)
        if place is None or why:
            kind = "proximity sensor" if why == RING else f"{sensor.kind} sensor"
            items.append(FileItem(Fate.LEFT_OUT, kind, sensor.name, why))
            continue
        at = place.at + place.axes @ np.array(sensor.at)
        ahead = place.axes @ (placed(np.zeros(3), sensor.rpy) @ placed(np.zeros(3), (0.0, 0.0, _middle(sensor))))[:3, 0]
        if sensor.kind == "imu":
            ahead = np.array([math.cos(stand.heading), math.sin(stand.heading), 0.0])
        kind = "lidar3d" if sensor.kind == "lidar" and sensor.keys.get("rings", 1) >= 2 else sensor.kind
        origin = f"described on '{sensor.link}'"
        yield _mount(stand, kind, _plain(sensor.name), at, ahead, _keys(sensor, kind), origin), list(_changed(sensor))


def _unlike(sensor: SaidSensor, place: FileFrame | None) -> str:
    """Return why a world cannot have a described sensor; '' if it can."""
    if sensor.kind not in LOWEST:
        return "mjsim has no sensor of this type"
    beams, farthest = sensor.keys.get("beams", math.inf), sensor.keys.get("farthest", math.inf)
    if (
        sensor.kind == "lidar"
        and max(beams, sensor.keys.get("rings", 1)) <= MAX_FAN_BEAMS
        and farthest <= MAX_FAN_RANGE
    ):
        return RING
    return "" if place is not None else f"its link '{sensor.link}' is not in the file"


def _changed(sensor: SaidSensor) -> Iterator[str]:
    """Yield how properties of a sensor that a world cannot have are changed."""
    rate, keys = sensor.keys.get("rate_hz", 0.0), sensor.keys
    if sensor.kind != "imu" and rate > 0 and _rate(rate) != rate:
        yield f"{_rate(rate):g} Hz for {rate:g} Hz, as its rate divides that of the loop"
    if keys.get("beams", 0) > MAX_BEAMS or keys.get("rings", 0) > MAX_RINGS:
        yield f"at most {MAX_BEAMS} beams in {MAX_RINGS} rings"
    if max(keys.get("width", 0), keys.get("height", 0)) > MAX_SIDE:
        yield f"at most {MAX_SIDE} pixels to a side"
    if sensor.kind == "camera" and keys.get("fov_deg", 0.0) > MAX_FOV:
        yield f"{MAX_FOV:g} degrees wide for {keys['fov_deg']:.0f}, the maximum of a camera"


def _rate(rate: float) -> float:
    return min(RATES, key=lambda other: abs(other - rate))


def _middle(sensor: SaidSensor) -> float:
    """Return the direction of the middle of a lidar's fan in its own frame, left positive [rad]; 0 for a full turn."""
    around = sensor.kind != "lidar" or sensor.keys.get("fov_deg", 0.0) > ALL_AROUND
    return 0.0 if around else math.radians(sensor.keys.get("middle_deg", 0.0))


def _cameras(anatomy: Anatomy, stand: Stand) -> Iterator[SensorMount]:
    """Yield the cameras of an MJCF file, which look along their -z axis."""
    for place in anatomy.places:
        if place.kind == "camera" and place.fov > 0.0:
            width, height = place.size if min(place.size) >= 16 else (WIDTH, HEIGHT)
            wide = 2.0 * math.atan(math.tan(math.radians(min(place.fov, 170.0)) / 2) * width / height)
            keys = {"width": min(width, 1280), "height": min(height, 1280), "fov_deg": _within(wide)}
            name = _plain(place.name or "camera")
            yield _mount(stand, "camera", name, place.at, -place.axes[:, 2], keys, f"camera '{place.name}'")


def _named(anatomy: Anatomy, stand: Stand) -> Iterator[SensorMount]:
    """Yield frames named like a sensor: links and sites, then shapes and meshes."""
    for kind, word in WORDS.items():
        places = [place for place in anatomy.places if place.kind != "camera"]
        for place in sorted(places, key=lambda place: "optical" in place.name):
            name = _plain(place.name)
            if word.search(name) and not NO_SENSOR.search(name):
                yield _mount(
                    stand, kind, _short(kind, name), place.at, _ahead(place, stand, kind), {}, f"'{place.name}'"
                )
        for shape in anatomy.shapes:
            found = next((n for n in shape.names if word.search(_plain(n)) and not NO_SENSOR.search(_plain(n))), None)
            if found is not None:
                at = (shape.points.min(axis=0) + shape.points.max(axis=0)) / 2
                ahead = np.array([math.cos(stand.heading), math.sin(stand.heading), 0.0])
                yield _mount(stand, kind, kind, at, ahead, {}, f"shape '{found}'")


def _ahead(place: FileFrame, stand: Stand, kind: str) -> Array:
    """Return the viewing direction of a link: along x, or along z for an optical frame of ROS."""
    ahead = place.axes[:, 2] if "optical" in place.name else place.axes[:, 0]
    if kind == "imu" or abs(ahead[2]) > math.sin(math.radians(MAX_PITCH)):
        return np.array([math.cos(stand.heading), math.sin(stand.heading), 0.0])
    return np.asarray(ahead)


def _mount(
    stand: Stand, kind: str, name: str, at: Array, ahead: Array, keys: Mapping[str, object], origin: str
) -> SensorMount:
    x, y, z = (round(float(value), 4) + 0.0 for value in stand.point(at))
    direction = stand.direction(ahead)
    yaw = math.degrees(math.atan2(direction[1], direction[0]))
    pitch = math.degrees(math.asin(float(np.clip(direction[2], -1.0, 1.0))))
    if kind.startswith("lidar"):
        pitch = 0.0 if abs(pitch) < 3.0 else pitch
    return SensorMount(kind, name, (x, y, z), round(yaw, 2) + 0.0, round(pitch, 2) + 0.0, keys, origin)


def _keys(sensor: SaidSensor, kind: str) -> dict[str, object]:
    """Return a sensor's properties from the file as keys of a world, limited to their valid ranges."""
    stated = sensor.keys
    keys: dict[str, object] = {}
    if sensor.kind == "lidar":
        keys = _fan(stated, kind)
    if sensor.kind == "camera":
        width, height = stated.get("width", 0), stated.get("height", 0)
        if min(width, height) >= 16:
            share = min(1.0, MAX_SIDE / max(width, height))
            keys |= {"width": max(16, round(width * share)), "height": max(16, round(height * share))}
        if stated.get("fov_deg", 0) > 0:
            keys["fov_deg"] = _within(math.radians(stated["fov_deg"]))
        if stated.get("depth"):
            keys["depth"] = True
    if sensor.kind != "imu" and stated.get("rate_hz", 0) > 0:
        keys["rate_hz"] = _rate(stated["rate_hz"])
    return keys


def _fan(stated: Mapping[str, float], kind: str) -> dict[str, object]:
    """Return the properties of a lidar as keys of a world."""
    keys: dict[str, object] = {}
    if stated.get("beams", 0) >= 2:
        keys["beams" if kind == "lidar" else "columns"] = min(round(stated["beams"]), MAX_BEAMS)
    if stated.get("fov_deg", 0) > 0:
        keys["fov_deg"] = 360.0 if stated["fov_deg"] > ALL_AROUND else round(stated["fov_deg"], 2)
    if stated.get("beams") == 1 and kind == "lidar":
        keys |= {"beams": 2, "fov_deg": BEAM_FOV}
    if kind == "lidar3d":
        keys["rings"] = min(round(stated["rings"]), MAX_RINGS)
        ends = [max(-89.0, min(89.0, stated.get(f"{end}_deg", 0.0))) for end in ("lowest", "highest")]
        if ends[0] < ends[1]:
            keys["elevation_deg"] = [round(end, 2) for end in ends]
    nearest, farthest = stated.get("nearest", 0.1), stated.get("farthest", 10.0)
    if 0 <= nearest < farthest <= 200:
        keys["range"] = [nearest, farthest]
    if 0 < stated.get("noise", 0) < 1:
        keys["noise"] = {"range": stated["noise"]}
    return keys


def _within(angle: float) -> float:
    """Return a field of view limited to the valid range, given in [rad], returned in [deg]."""
    return round(min(max(math.degrees(angle), 5.0), MAX_FOV), 2)


def _plain(name: str) -> str:
    """Return a name in lower case that is valid in a world."""
    return re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")[:40] or "sensor"


def _short(kind: str, name: str) -> str:
    """Return a name without the words common to all links."""
    return re.sub(r"_(link|frame|base|rgb|depth|optical|sensor)(?=_|$)", "", name) or kind
