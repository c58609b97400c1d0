"""Sensors of a robot: those its file describes, and links, sites and cameras with the names of sensors."""

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from mjsim.exchange.robots.frame import Stand
from mjsim.geometry import Array
from mjsim.mechanics import placed
from mjsim.models import Anatomy, FileFrame, SaidSensor

WORDS = {
    "lidar": re.compile(r"lidar|laser|(^|_)scan|lds|hokuyo|rplidar|(^|_)sick|velodyne|vlp_?16|ouster|ust10|tim\d{3}"),
    "camera": re.compile(r"camera|realsense|kinect|astra|(^|_)zed|(^|_)oak|webcam|d4[135]5|r200|t265"),
    "imu": re.compile(r"(^|_)imu|inertial_?(sensor|unit|meas|nav)|gyro"),
}
"""Names of links that carry a sensor."""
NO_SENSOR = re.compile(r"mount|bracket|holder|support|tower|screw|plate|(^|_)cap($|_)")
SAME = 0.15
"""Links of one kind closer together than this belong to one sensor [m]."""
MAX_COUNT = {"lidar": 2, "camera": 2, "imu": 1}
"""Maximum number of sensors of each kind in a preset; rendering takes time."""
LOWEST = {"lidar": 0.02, "camera": 0.02, "imu": -0.01}
"""Minimum height above the floor; lower frames are placeholders, or see only the floor [m]."""
WIDTH, HEIGHT = 640, 480
STEEP = 85.0
"""Cameras that look up or down more steeply are ignored [deg]."""
ALL_AROUND = 355.0
"""A lidar with a larger field of view sees all around [deg]."""
NARROW = 0.1
"""Field of view of a range finder with a single beam, for which mjsim has two [deg]."""
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
    keys: Mapping[str, object] = field(default_factory=dict)
    origin: str = ""
    """Where the file describes it."""


def find_mounts(anatomy: Anatomy, stand: Stand, sensors: tuple[SaidSensor, ...]) -> list[SensorMount]:
    """Return the sensors of a robot; those its file describes come first."""
    chosen: list[SensorMount] = []
    for mount in (*_described(anatomy, stand, sensors), *_cameras(anatomy, stand), *_named(anatomy, stand)):
        same = [other for other in chosen if other.kind == mount.kind]
        occupied = any(math.dist(other.at, mount.at) < SAME for other in same)
        if (
            len(same) < MAX_COUNT[mount.kind]
            and not occupied
            and abs(mount.pitch_deg) < STEEP
            and mount.at[2] > LOWEST[mount.kind]
        ):
            taken = {other.name for other in chosen}
            chosen.append(_renamed(mount, taken))
    return chosen


def _renamed(mount: SensorMount, taken: set[str]) -> SensorMount:
    name, number = mount.name, 2
    while name in taken or name in ("drive", "chase") or name.startswith("wheel_"):
        name, number = f"{mount.name}{number}", number + 1
    return SensorMount(mount.kind, name, mount.at, mount.yaw_deg, mount.pitch_deg, mount.keys, mount.origin)


def _described(anatomy: Anatomy, stand: Stand, sensors: tuple[SaidSensor, ...]) -> Iterator[SensorMount]:
    """Yield the sensors that a file describes, each on its link or site."""
    for sensor in sensors:
        place = next((place for place in anatomy.places if place.name == sensor.link), None)
        if place is None:
            continue
        at = place.at + place.axes @ np.array(sensor.at)
        ahead = place.axes @ (placed(np.zeros(3), sensor.rpy) @ placed(np.zeros(3), (0.0, 0.0, _middle(sensor))))[:3, 0]
        if sensor.kind == "imu":
            ahead = np.array([math.cos(stand.heading), math.sin(stand.heading), 0.0])
        yield _mount(stand, sensor.kind, _plain(sensor.name), at, ahead, _keys(sensor), f"described on '{sensor.link}'")


def _middle(sensor: SaidSensor) -> float:
    """Return where the middle of a lidar's fan is, in its own frame, to the left [rad]; 0 if it goes all around."""
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
    if kind == "imu" or abs(ahead[2]) > math.sin(math.radians(STEEP)):
        return np.array([math.cos(stand.heading), math.sin(stand.heading), 0.0])
    return np.asarray(ahead)


def _mount(
    stand: Stand, kind: str, name: str, at: Array, ahead: Array, keys: Mapping[str, object], origin: str
) -> SensorMount:
    x, y, z = (round(float(value), 4) + 0.0 for value in stand.point(at))
    direction = stand.direction(ahead)
    yaw = math.degrees(math.atan2(direction[1], direction[0]))
    pitch = math.degrees(math.asin(float(np.clip(direction[2], -1.0, 1.0))))
    if kind == "lidar":
        pitch = 0.0 if abs(pitch) < 3.0 else pitch
    return SensorMount(kind, name, (x, y, z), round(yaw, 2) + 0.0, round(pitch, 2) + 0.0, keys, origin)


def _keys(sensor: SaidSensor) -> dict[str, object]:
    """Return a sensor's properties from the file as keys of a world, limited to their valid ranges."""
    stated = sensor.keys
    keys: dict[str, object] = {}
    if sensor.kind == "lidar":
        if stated.get("beams", 0) >= 2:
            keys["beams"] = min(round(stated["beams"]), 1440)
        if stated.get("fov_deg", 0) > 0:
            keys["fov_deg"] = 360.0 if stated["fov_deg"] > ALL_AROUND else round(stated["fov_deg"], 2)
        if stated.get("beams") == 1:
            keys |= {"beams": 2, "fov_deg": NARROW}
        nearest, farthest = stated.get("nearest", 0.1), stated.get("farthest", 10.0)
        if 0 <= nearest < farthest <= 200:
            keys["range"] = [nearest, farthest]
        if 0 < stated.get("noise", 0) < 1:
            keys["noise"] = {"range": stated["noise"]}
    if sensor.kind == "camera":
        if 16 <= stated.get("width", 0) <= 1920 and 16 <= stated.get("height", 0) <= 1920:
            keys |= {"width": round(stated["width"]), "height": round(stated["height"])}
        if stated.get("fov_deg", 0) > 0:
            keys["fov_deg"] = _within(math.radians(stated["fov_deg"]))
    if sensor.kind != "imu" and stated.get("rate_hz", 0) > 0:
        keys["rate_hz"] = min(RATES, key=lambda rate: abs(rate - stated["rate_hz"]))
    return keys


def _within(angle: float) -> float:
    """Return a field of view limited to the valid range, given in [rad], returned in [deg]."""
    return round(min(max(math.degrees(angle), 5.0), 150.0), 2)


def _plain(name: str) -> str:
    """Return a name in lower case that is valid in a world."""
    return re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")[:40] or "sensor"


def _short(kind: str, name: str) -> str:
    """Return a name without the words common to all links."""
    return re.sub(r"_(link|frame|base|rgb|depth|optical|sensor)(?=_|$)", "", name) or kind
