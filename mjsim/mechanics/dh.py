"""Denavit-Hartenberg tables: rows to links.

References:
    "standard": Spong, Hutchinson, Vidyasagar, Robot Modeling and Control (2006), section 3.2, and Corke, Robotics,
    Vision and Control (2017), section 7.1.2; "modified": Craig, Introduction to Robotics (1989), section 3.4.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mjsim.errors import did_you_mean
from mjsim.geometry import Array
from mjsim.mechanics.arm_links import Link
from mjsim.mechanics.link_inertias import Solid, capsule
from mjsim.mechanics.transforms import IDENTITY, about_x, about_z, inverted
from mjsim.sentences import Sentence

CONVENTIONS = ("standard", "modified")
UNITS: Mapping[str, float] = {"m": 1.0, "mm": 0.001}
"""Unit of the lengths in a table -> metres."""
ANGLE_KEYS = ("theta", "alpha", "range", "velocity")
"""Keys in radians, or with the suffix `_deg` in degrees; the last two for revolute joints."""
LENGTHS, LENGTHS_OF_SLIDE = ("d", "a", "center", "radius"), ("range", "velocity")
NUMBER_KEYS = ("torque", "mass", "inertia", "gear", "rotor_inertia", "friction", "slide")
KEYS = (*ANGLE_KEYS, *LENGTHS, *NUMBER_KEYS)
IN_DEGREES = tuple(f"{name}_deg" for name in ANGLE_KEYS)
RADIUS_RATIO, MIN_RADIUS = 0.04, 0.01
"""Default radius of a link relative to the length of the arm, and its minimum [m]."""
Row = Mapping[str, Any] | Sequence[float]


def links_of(rows: Sequence[Row], *, convention: str, unit: str) -> tuple[Link, ...]:
    """Return the links of a table; the arguments are those of `Arm.from_dh`.

    Raises:
        ValueError: A row is wrong; the message says which.
    """
    for value, name, known in ((convention, "convention", CONVENTIONS), (unit, "unit", UNITS)):
        if value not in known:
            raise ValueError(
                Sentence("{name} is '{value}'{did_you_mean}", name, value, did_you_mean(str(value), known))
            )
    if not rows:
        raise ValueError("the arm has no links; give at least one row")
    numbered = list(enumerate(rows, 1))
    table = [_of_row(number, _in_metres, row, UNITS[unit]) for number, row in numbered]
    frames = [_around_joint(row, modified=convention == "modified") for row in table]
    length = sum(abs(row["d"]) + abs(row["a"]) for row in table)
    ahead = [*(before[:3, 3] for before, _ in frames[1:]), np.zeros(3)]
    parts = zip(numbered, table, frames, ahead, strict=True)
    return tuple(
        _of_row(number, _link, row, *frame, end, max(RADIUS_RATIO * length, MIN_RADIUS))
        for (number, _), row, frame, end in parts
    )


def _of_row(number: int, make: Any, *arguments: Any) -> Any:
    """Return the result of a function for a row; errors name the row."""
    try:
        return make(*arguments)
    except (TypeError, ValueError) as error:
        raise ValueError(Sentence("row {number}: {error}", number, error)) from None


def _in_metres(row: Row, scale: float) -> dict[str, Any]:
    """Return the keys of a row in metres and radians; four numbers are theta, d, a, alpha."""
    if not isinstance(row, Mapping):
        row = dict(zip(("theta", "d", "a", "alpha"), _numbers("the row", row, 4), strict=True))
    slides = bool(row.get("slide", False))
    keys: dict[str, Any] = {"theta": 0.0, "d": 0.0, "a": 0.0, "alpha": 0.0}
    for key, value in row.items():
        name = key.removesuffix("_deg")
        if name not in KEYS or (name != key and name not in ANGLE_KEYS):
            raise ValueError(
                Sentence("unknown key '{key}'{did_you_mean}", key, did_you_mean(str(key), KEYS + IN_DEGREES))
            )
        if name != key and slides and name in LENGTHS_OF_SLIDE:
            raise ValueError(
                Sentence("{key} is in degrees; this joint slides: give {name}, in the unit of the table", key, name)
            )
        if name != key and name in row:
            raise ValueError(Sentence("both '{name}' and '{key}' are given; give one", name, key))
        if name in LENGTHS or (slides and name in LENGTHS_OF_SLIDE):
            value = (scale * np.asarray(value, dtype=float)).tolist()
        keys[name] = value if name == key else np.radians(value).tolist()
    for name in ("theta", "d", "a", "alpha"):
        (keys[name],) = _numbers(name, [keys[name]], 1)
    return keys


def _around_joint(row: Mapping[str, Any], *, modified: bool) -> tuple[Array, Array]:
    """Return the factors before and after the joint's own motion in the matrix of a row, shape (4, 4) each.

    Standard: A = Rz(theta) Tz(d) Tx(a) Rx(alpha); modified: A = Rx(alpha) Tx(a) Rz(theta) Tz(d). The joint turns about
    z or slides along it, which commutes with Rz and Tz.
    """
    along_z, along_x = about_z(row["theta"], row["d"]), about_x(row["alpha"], row["a"])
    return (along_x @ along_z, IDENTITY) if modified else (along_z, along_x)


def _link(row: Mapping[str, Any], before: Array, after: Array, end: Array, radius: float) -> Link:
    """Return the link of a row; `end` is the place of the next joint in its frame, shape (3,) [m]."""
    lower, upper = _numbers("range", row.get("range", (-math.inf, math.inf)), 2, finite=False)
    slides = bool(row.get("slide", False))
    # A sliding joint has a rod behind it, as long as its travel.
    behind = max(upper, 0.0) if slides and math.isfinite(upper) else 0.0
    start = (inverted(after) @ [0.0, 0.0, -behind, 1.0])[:3]
    radius = float(row.get("radius", radius))
    solid = _solid(row, start, end, radius)
    friction = row.get("friction") or {}
    return Link(
        before=before,
        after=after,
        slide=slides,
        lower=lower,
        upper=upper,
        mass=solid.mass,
        center=solid.center,
        inertia=solid.inertia,
        gear=float(row.get("gear", 1.0)),
        rotor_inertia=float(row.get("rotor_inertia", 0.0)),
        viscous=float(friction.get("viscous", 0.0)),
        coulomb=_coulomb_pair(friction.get("coulomb", 0.0)),
        max_torque=float(row.get("torque", math.inf)),
        max_velocity=float(row.get("velocity", math.inf)),
        bone=(_numbers("bone", start, 3), _numbers("bone", end, 3)),
        radius=radius,
        dh=(row["theta"], row["d"], row["a"], row["alpha"]),
    )


def _solid(row: Mapping[str, Any], start: Array, end: Array, radius: float) -> Solid:
    """Return mass, centre and inertia of the row; those of the capsule if it gives no mass."""
    if "mass" in row:
        center, inertia = row.get("center", (0.0,) * 3), row.get("inertia", (0.0,) * 6)
        return Solid(float(row["mass"]), _numbers("center", center, 3), _numbers("inertia", inertia, 6))
    for name in ("center", "inertia"):
        if name in row:
            raise ValueError(Sentence("{name} is given without mass; give mass too, or neither", name))
    return capsule(start, end, radius)


def _coulomb_pair(coulomb: Any) -> tuple[float, float]:
    """Return dry friction in positive and negative direction; one number is used for both."""
    if np.ndim(coulomb) == 0:
        return float(coulomb), -float(coulomb)
    plus, minus = _numbers("coulomb", coulomb, 2)
    return plus, minus


def _numbers(name: str, values: Any, count: int, *, finite: bool = True) -> Any:
    numbers = tuple(float(value) for value in values)
    if len(numbers) != count:
        raise ValueError(
            Sentence("{name} holds {count} numbers; it must hold {other_count}", name, len(numbers), count)
        )
    if finite and not np.isfinite(numbers).all():
        raise ValueError(
            Sentence(
                "{name} is {value}; it must be finite",
                name,
                next(value for value in numbers if not math.isfinite(value)),
            )
        )
    return numbers
