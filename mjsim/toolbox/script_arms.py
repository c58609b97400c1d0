"""Arms of a script: from the fields of its links to an `Arm`, and to a file with its table."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mjsim.geometry import Array
from mjsim.mechanics import Arm


def arm_rows(fields: Mapping[str, Any]) -> tuple[list[dict[str, Any]], str]:
    """Return the rows of an arm's table, and its convention."""
    links = fields["links"] if isinstance(fields["links"], list) else [fields["links"]]
    rows = []
    for link in links:
        slides = bool(_number(link["sigma"]))
        offset = _number(link["offset"])
        row: dict[str, Any] = {
            "theta_deg": math.degrees(_number(link["theta"]) if slides else offset),
            "d": _number(link["d"]) + 0.0 if not slides else offset,
            "a": _number(link["a"]),
            "alpha_deg": math.degrees(_number(link["alpha"])),
        }
        if slides:
            row["slide"] = True
        limits = np.ravel(link["qlim"])
        if len(limits) == 2 and limits[0] < limits[1]:
            row["range" if slides else "range_deg"] = (limits if slides else np.degrees(limits)).tolist()
        rows.append({key: _tidy(value) for key, value in row.items()})
    modified = any(_number(link["mdh"]) for link in links)
    return rows, "modified" if modified else "standard"


def start_of(rows: Sequence[Mapping[str, Any]], q: Array) -> list[float] | None:
    """Return joint values in degrees, or in metres, turned into their limits; None if some are outside."""
    found = []
    for row, value in zip(rows, q.tolist(), strict=True):
        angle = value if row.get("slide") else math.degrees(value)
        low, high = row.get("range" if row.get("slide") else "range_deg", (-math.inf, math.inf))
        turns = (0.0,) if row.get("slide") else (0.0, -360.0, 360.0)
        inside = [angle + turn for turn in turns if low <= angle + turn <= high]
        if not inside:
            return None
        found.append(round(inside[0], 9) + 0.0)
    return found


def arm_of(fields: Mapping[str, Any]) -> Arm:
    """Return the arm of the fields of a robot; masses are left out, as pictures need none.

    Raises:
        ValueError: Its base or tool is not a pose.
    """
    rows, convention = arm_rows(fields)
    base, tool = (np.asarray(fields[key], dtype=float) for key in ("base", "tool"))
    light = [{**row, "mass": 0.0} for row in rows]
    return Arm.from_dh(light, convention, name=str(fields["name"]) or "robot", base=base, tool=tool)


def _number(value: Any) -> float:
    return float(np.ravel(value)[0]) if np.size(value) else 0.0


def _tidy(value: Any) -> Any:
    """Return numbers without the last digits, which conversion to degrees made."""
    if isinstance(value, list):
        return [_tidy(each) for each in value]
    return value if isinstance(value, bool) else round(value, 12) + 0.0
