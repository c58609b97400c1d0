"""The robot and the sensor of a configuration of MATLAB, as keys of a world file."""

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mjsim.geometry import Array

Path = tuple[str, ...]
DEGREES = 180.0 / math.pi
MAX_NOISE = 0.5
"""Bearing noise above this is taken as degrees [rad]."""
ROBOT_KEYS: Mapping[str, tuple[Path, float]] = {
    **dict.fromkeys(("radius", "bodyradius", "robotradius", "rayon", "radio"), (("body", "radius"), 1.0)),
    **dict.fromkeys(
        ("wheelbase", "track", "trackwidth", "base", "axle", "radstand", "spurweite", "entraxe", "voie"),
        (("drive", "track"), 1.0),
    ),
    **dict.fromkeys(("wheelradius", "rw"), (("drive", "wheel_radius"), 1.0)),
    **dict.fromkeys(
        (
            "maxspeed",
            "speedmax",
            "vmax",
            "speed",
            "v",
            "maxvelocity",
            "geschwindigkeit",
            "vitesse",
            "vitessemax",
            "velocidad",
        ),
        (("drive", "max_speed"), 1.0),
    ),
    **dict.fromkeys(
        ("maxturn", "turnmax", "wmax", "omegamax", "maxomega", "turnrate", "rotationspeed", "drehrate", "w"),
        (("drive", "max_turn_deg"), DEGREES),
    ),
    **dict.fromkeys(
        ("sigmav", "speednoise", "noisespeed", "noisev", "noisesv", "noisesspeed"), (("drive", "noise", "speed"), 1.0)
    ),
    **dict.fromkeys(
        ("sigmaw", "sigmaomega", "turnnoise", "noiseturn", "noisew", "noisesw", "noisesturn"),
        (("drive", "noise", "turn"), 1.0),
    ),
    **dict.fromkeys(("sigmad", "distancenoise", "noisedistance"), (("odometry", "noise", "distance"), 1.0)),
    "odometryturnnoise": (("odometry", "noise", "turn"), 1.0),
}
"""Names of the robot's values, without underscores and case -> keys of a robot, and the factor from the file's unit to
that of the key."""
SENSOR_KEYS: Mapping[str, tuple[Path, float]] = {
    **dict.fromkeys(
        ("range", "maxrange", "rangemax", "rmax", "reichweite", "portee", "alcance"), (("range", "1"), 1.0)
    ),
    **dict.fromkeys(("minrange", "rangemin", "rmin"), (("range", "0"), 1.0)),
    **dict.fromkeys(
        (
            "angle",
            "angles",
            "fov",
            "fieldofview",
            "view",
            "maxangle",
            "winkel",
            "oeffnungswinkel",
            "ouverture",
            "angulo",
        ),
        (("fov_deg",), DEGREES),
    ),
    **dict.fromkeys(
        ("sigma", "sigmar", "sigmarange", "rangenoise", "noiserange", "noisesrange"), (("noise", "range"), 1.0)
    ),
    **dict.fromkeys(
        ("sigmab", "sigmabearing", "sigmaphi", "sigmatheta", "bearingnoise", "noisebearing", "noisesbearing"),
        (("noise", "bearing_deg"), DEGREES),
    ),
    **dict.fromkeys(("rate", "ratehz", "frequency"), (("rate_hz",), 1.0)),
}
"""The same for the beacon sensor."""
VECTORS: Mapping[str, tuple[tuple[str, ...], ...]] = {
    "robot": (("radius", "wheelbase", "maxspeed", "maxturn"), ("radius", "wheelbase", "maxspeed", "maxturn",
              "sigmav", "sigmaw")),
    "sensor": (("maxrange", "angle"), ("maxrange", "angle", "sigmar", "sigmab"),
               ("minrange", "maxrange", "angle", "sigmar", "sigmab")),
}  # fmt: skip
"""Order of values of a robot or a sensor that is a vector, by their number."""
PAIRS: Mapping[tuple[str, str], tuple[str, str]] = {
    **dict.fromkeys(
        (("robot", key) for key in ("noise", "noises", "rauschen", "bruit", "ruido")), ("sigmav", "sigmaw")
    ),
    **dict.fromkeys((("robot", key) for key in ("odometrynoise", "noiseodometry")), ("sigmad", "odometryturnnoise")),
    **dict.fromkeys(
        (("robot", key) for key in ("speeds", "speed", "geschwindigkeit", "vitesse")), ("maxspeed", "maxturn")
    ),
    **dict.fromkeys(
        (("sensor", key) for key in ("noise", "noises", "rauschen", "bruit", "ruido")), ("sigmar", "sigmab")
    ),
    **dict.fromkeys(
        (("sensor", key) for key in ("range", "ranges", "reichweite", "portee", "alcance")), ("minrange", "maxrange")
    ),
}
"""Values that are two numbers."""
POSES = ("pose", "start", "startpose", "x0", "initial", "initialpose", "xtrue")
OWNERS = {
    **dict.fromkeys(("robot", "vehicle", "roboter", "fahrzeug", "vehicule"), "robot"),
    **dict.fromkeys(
        ("sensor", "sensors", "observation", "capteur", "laser", "lidar", "scanner", "rangefinder"), "sensor"
    ),
}
DATA = re.compile(r"_?(params?|parameters|config|data)$")
"""Possible ends of names of structs, as in robotParams."""
ALONE = {
    **dict.fromkeys(
        ("wheelbase", "robotradius", "sigmav", "sigmaw", "sigmaomega", "vmax", "wmax", "wheelradius"), "robot"
    ),
    **dict.fromkeys(("maxrange", "sigmar", "sigmab"), "sensor"),
}
"""Variables whose owner is clear from their names, as in Bailey's configurations."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Equipment:
    """Data of the robot and its sensor in a file."""

    robot: Mapping[str, Any] = field(default_factory=dict)
    """Keys of a robot."""
    sensor: Mapping[str, Any] = field(default_factory=dict)
    """Keys of a beacon sensor; `range` is a mapping from index to bound."""
    pose: tuple[float, float, float] | None = None
    """Start [m, rad]."""
    preset: str | None = None
    told: tuple[str, ...] = ()
    """Notes on each value."""

    def sensor_over(self, usual: Mapping[str, Any]) -> dict[str, Any]:
        """Return the keys of the sensor, with usual values for those that the file lacks."""
        ends = self.sensor.get("range", {})
        low, high = (ends.get(str(k), usual["range"][k]) for k in range(2))
        noise = {**usual["noise"], **self.sensor.get("noise", {})}
        return {**usual, **self.sensor, "range": [min(low, high / 2.0), high], "noise": noise}


def equipment_of(content: Mapping[str, Any], *, scale: float) -> tuple[Equipment, list[str]]:
    """Return the robot and the sensor of a file's variables, and the names of unused variables.

    Args:
        content: The variables by name.
        scale: Metres per unit of places in the file.
    """
    keys: dict[str, dict[str, Any]] = {"robot": {}, "sensor": {}}
    pose, preset = None, None
    told, unused = [], []
    for name, owner, key, value in _named(content):
        numbers = None if isinstance(value, str | list | Mapping) else np.ravel(value)
        if owner == "robot" and key in POSES and numbers is not None and _is_pose(numbers):
            is_in_degrees = abs(numbers[2]) > 2.0 * math.pi + 0.01
            heading = math.radians(numbers[2]) if is_in_degrees else float(numbers[2])
            pose = (float(numbers[0]) * scale, float(numbers[1]) * scale, heading)
            unit = ", as it exceeds 2 pi" if is_in_degrees else ""
            told.append(f"{name} is the start: {pose[0]:g}, {pose[1]:g}, {math.degrees(heading):g} degrees{unit}")
        elif owner == "robot" and key == "preset" and isinstance(value, str):
            preset = value
            told.append(f"{name} is the preset {value}")
        elif owner is None or numbers is None or not (lines := _put(keys[owner], owner, name, key, numbers.tolist())):
            unused.append(name)
        else:
            told += lines
    found = Equipment(robot=keys["robot"], sensor=keys["sensor"], pose=pose, preset=preset, told=tuple(told))
    return found, unused


def _is_pose(numbers: Array) -> bool:
    return len(numbers) == 3 and bool(np.isfinite(numbers).all())


def _named(content: Mapping[str, Any]) -> Iterator[tuple[str, str | None, str, Any]]:
    """Yield for each value its name, owner, key in lower case without underscores, and the value."""
    for name, value in content.items():
        lower = name.lower()
        owner = owner_of(name)
        prefix = next((each for each in OWNERS if lower.startswith(f"{each}_")), None)
        if owner is not None and isinstance(value, Mapping):
            for key, each in value.items():
                yield from _parts(f"{name}.{key}", owner, key, each)
        elif owner is not None:
            yield name, owner, "", value
        elif prefix is not None:
            yield name, OWNERS[prefix], _bare(lower.removeprefix(f"{prefix}_")), value
        else:
            yield name, ALONE.get(_bare(lower), "robot" if _bare(lower) in POSES else None), _bare(lower), value


def owner_of(name: str) -> str | None:
    """Return the owner of the values in a struct, by its name: robot or sensor; None if unknown."""
    return OWNERS.get(DATA.sub("", name.lower()))


def _parts(name: str, owner: str, key: str, value: Any) -> Iterator[tuple[str, str | None, str, Any]]:
    """Yield a field, or the fields of a struct in it: noise.v gets the key noisev."""
    if isinstance(value, Mapping):
        for inner, each in value.items():
            yield f"{name}.{inner}", owner, _bare(key + inner), each
    else:
        yield name, owner, _bare(key), value


def _bare(name: str) -> str:
    """Return a name in lower case without underscores."""
    return name.lower().replace("_", "")


def _put(keys: dict[str, Any], owner: str, name: str, key: str, values: list[float]) -> list[str]:
    """Store the values under keys of a world file; return lines about it, none if the key has no meaning."""
    table = ROBOT_KEYS if owner == "robot" else SENSOR_KEYS
    degrees = key.endswith("deg")
    key = key.removesuffix("deg")
    if key == "" or len(values) > 2:
        order = next((each for each in VECTORS[owner] if len(each) == len(values)), ()) if not key else ()
    elif len(values) == 2:
        order = PAIRS.get((owner, key), ())
    else:
        order = (key,)
    if len(values) == 2 and not order and table.get(key) == (("fov_deg",), DEGREES) and values[1] > values[0]:
        # The minimum and the maximum bearing that it sees.
        order, values = (key,), [values[1] - values[0]]
    if not order or any(each not in table for each in order) or not np.isfinite(values).all():
        return []
    lines = []
    for each, value in zip(order, values, strict=True):
        path, unit = table[each]
        limit = MAX_NOISE if path == ("noise", "bearing_deg") else 2.0 * math.pi + 0.01
        if unit == DEGREES and (degrees or abs(value) > limit):
            unit = 1.0
        _store(keys, path, round(value * unit, 6))
        lines.append(f"{name} is {owner}'s {'.'.join(path).replace('.0', ' from').replace('.1', ' to')}:"
                     f" {value * unit:.6g}")  # fmt: skip
    return lines


def _store(keys: dict[str, Any], path: Path, value: float) -> None:
    for key in path[:-1]:
        keys = keys.setdefault(key, {})
    keys[path[-1]] = value
