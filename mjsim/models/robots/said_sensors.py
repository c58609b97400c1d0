"""Sensors that a robot's file describes for a simulator."""

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from mjsim.models.inertia_repair import finite_number
from mjsim.models.model_sources import Element

KINDS = {"ray": "lidar", "lidar": "lidar", "camera": "camera", "depth": "camera", "imu": "imu"}
"""Words in Gazebo's sensor types -> kinds of mjsim; other types keep their names."""


@dataclass(frozen=True, slots=True)
class SaidSensor:
    """A sensor described in a file for a simulator."""

    link: str
    """Name of the body that carries it."""
    kind: str
    """lidar, camera or imu; or Gazebo's type for a sensor that mjsim lacks."""
    name: str
    keys: Mapping[str, float] = field(default_factory=dict)
    """Its properties: beams, fov_deg, middle_deg (of its fan, to the left), rings, lowest_deg, highest_deg, nearest,
    farthest, rate_hz, noise, width, height, depth (1 for a camera that measures it)."""
    at: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Position in the frame of the body [m]."""
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Roll, pitch and yaw in the frame of the body [rad]."""


def said_sensors(root: Element) -> tuple[SaidSensor, ...]:
    """Return the sensors that a URDF describes for Gazebo, or an MJCF for MuJoCo, in the order of the file."""
    return tuple(_urdf_sensors(root) if root.tag == "robot" else _mjcf_sensors(root))


def _urdf_sensors(root: Element) -> Iterator[SaidSensor]:
    for gazebo in root.findall("gazebo"):
        for sensor in gazebo.findall("sensor"):
            text = sensor.get("type", "")
            kind = next((kind for word, kind in KINDS.items() if word in text), text or "nameless")
            at, rpy = _pose(sensor.findtext("pose", ""))
            yield SaidSensor(gazebo.get("reference", ""), kind, sensor.get("name", kind), _gazebo_keys(sensor), at, rpy)


def _pose(text: str) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    numbers = [finite_number(word) for word in text.split()[:6]]
    x, y, z, roll, pitch, yaw = (numbers + [None] * 6)[:6]
    return (x or 0.0, y or 0.0, z or 0.0), (roll or 0.0, pitch or 0.0, yaw or 0.0)


def _gazebo_keys(sensor: Element) -> dict[str, float]:
    """Return the properties of a sensor by the keys of mjsim."""
    found: dict[str, float | None] = {"rate_hz": finite_number(sensor.findtext("update_rate"))}
    ray = next((item for name in ("ray", "lidar") for item in sensor.iter(name)), None)
    if ray is not None:
        found |= _fan_keys(ray)
    camera = sensor.find("camera")
    if camera is not None:
        found |= {
            "fov_deg": _degrees(finite_number(camera.findtext("horizontal_fov"))),
            "width": finite_number(camera.findtext("image/width")),
            "height": finite_number(camera.findtext("image/height")),
            "depth": 1.0 if re.search("depth|rgbd", sensor.get("type", "")) else None,
        }
    return {key: value for key, value in found.items() if value is not None}


def _fan_keys(ray: Element) -> dict[str, float | None]:
    """Return the properties of a lidar's fan of beams."""
    low, high = (finite_number(ray.findtext(f"scan/horizontal/{end}_angle")) for end in ("min", "max"))
    both = low is not None and high is not None
    return {
        "beams": finite_number(ray.findtext("scan/horizontal/samples")),
        "fov_deg": _degrees((high or 0.0) - (low or 0.0)) if both else None,
        "middle_deg": _degrees((high or 0.0) + (low or 0.0), share=0.5) if both else None,
        "rings": finite_number(ray.findtext("scan/vertical/samples")),
        "lowest_deg": _degrees(finite_number(ray.findtext("scan/vertical/min_angle"))),
        "highest_deg": _degrees(finite_number(ray.findtext("scan/vertical/max_angle"))),
        "nearest": finite_number(ray.findtext("range/min")),
        "farthest": finite_number(ray.findtext("range/max")),
        "noise": finite_number(ray.findtext("noise/stddev")),
    }


def _degrees(angle: float | None, *, share: float = 1.0) -> float | None:
    return None if angle is None else share * math.degrees(angle)


def _mjcf_sensors(root: Element) -> Iterator[SaidSensor]:
    """Yield the inertial sensors in an MJCF; the site that carries one serves as its link."""
    sites = {item.get("site", "") for kind in ("accelerometer", "gyro") for item in root.findall(f"sensor/{kind}")}
    for site in sorted(sites - {""}):
        yield SaidSensor(site, "imu", "imu")
