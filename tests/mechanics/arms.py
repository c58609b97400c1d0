"""Arms of the tests, and the plain product of their Denavit-Hartenberg matrices as the books write it."""

import json
from pathlib import Path

import numpy as np

from mjsim.mechanics import Arm

DATA = Path(__file__).parents[1] / "data" / "joints"
PARAMETERS = json.loads((DATA / "arms.json").read_text())["robots"]

UP6_ROWS = [
    {"alpha": alpha, "a": a, "theta": theta, "d": d}
    for alpha, a, theta, d in PARAMETERS["up6"]["links_alpha_a_theta_d"]
]


def six(matrix):
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = matrix
    return [xx, yy, zz, xy, yz, xz]


PUMA_ROWS = [
    {
        **{key: link[key] for key in ("alpha", "a", "d", "theta")},
        "mass": link["m"],
        "center": link["r"],
        "inertia": six(link["I"]),
        "gear": link["G"],
        "rotor_inertia": link["Jm"],
        "friction": {"viscous": link["B"], "coulomb": link["Tc"]},
    }
    for link in PARAMETERS["puma560"]["links"]
]

SLIDE_ROWS = [
    {
        "theta_deg": 30,
        "d": 0.4,
        "a": 0.1,
        "alpha_deg": -90,
        "mass": 3,
        "center": [0.1, 0, 0.02],
        "inertia": [0.2, 0.3, 0.25, 0.01, 0.02, 0],
    },
    {
        "theta_deg": 90,
        "d": 0.2,
        "alpha_deg": 90,
        "slide": True,
        "range": [-0.5, 0.8],
        "mass": 2,
        "center": [0, 0.1, -0.3],
        "inertia": [0.1, 0.1, 0.05, 0, 0, 0.01],
    },
    {"d": 0.1, "a": 0.3, "alpha_deg": 20, "mass": 1, "center": [-0.1, 0, 0], "inertia": [0.01, 0.02, 0.02, 0, 0, 0]},
]
"""Turns, slides and turns; no axis is parallel to another."""

MODIFIED_ROWS = [
    {"d": 0.3, "mass": 4, "center": [0, 0.05, 0.1], "inertia": [0.1, 0.1, 0.08, 0, 0.01, 0]},
    {
        "alpha_deg": -90,
        "a": 0.05,
        "theta_deg": -20,
        "mass": 3,
        "center": [0.2, 0, 0],
        "inertia": [0.02, 0.2, 0.2, 0, 0, 0],
    },
    {"alpha_deg": 15, "a": 0.4, "d": -0.09, "mass": 2, "center": [0.1, 0.1, 0], "inertia": [0.05, 0.05, 0.02, 0, 0, 0]},
    {
        "alpha_deg": 90,
        "a": -0.02,
        "d": 0.43,
        "slide": True,
        "mass": 1,
        "center": [0, 0, 0.1],
        "inertia": [0.01, 0.01, 0.01, 0, 0, 0],
    },
]

TABLES = {
    "UP6": (UP6_ROWS, "standard", "mm"),
    "Puma 560": (PUMA_ROWS, "standard", "m"),
    "with a slide": (SLIDE_ROWS, "standard", "m"),
    "modified": (MODIFIED_ROWS, "modified", "m"),
}


def arm_of(name):
    rows, convention, unit = TABLES[name]
    return Arm.from_dh(rows, convention, unit)


def golden(name):
    with np.load(DATA / f"{name}.npz") as arrays:
        return dict(arrays)


def book_matrix(row, q, *, convention, scale):
    """Return the matrix of one row at one value, each entry as the books print it."""
    angle = {name: row.get(name, np.radians(row.get(f"{name}_deg", 0.0))) for name in ("theta", "alpha")}
    theta, alpha = angle["theta"], angle["alpha"]
    d, a = (row.get(name, 0.0) * scale for name in ("d", "a"))
    theta, d = (theta, d + q) if row.get("slide") else (theta + q, d)
    ct, st, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
    if convention == "standard":
        return np.array(
            [[ct, -st * ca, st * sa, a * ct], [st, ct * ca, -ct * sa, a * st], [0, sa, ca, d], [0, 0, 0, 1]]
        )
    return np.array([[ct, -st, 0, a], [st * ca, ct * ca, -sa, -sa * d], [st * sa, ct * sa, ca, ca * d], [0, 0, 0, 1]])


def plain_frames(name, q):
    """Return the frame of each link at one posture, shape (n, 4, 4)."""
    rows, convention, unit = TABLES[name]
    frames, reached = [], np.eye(4)
    for row, value in zip(rows, q, strict=True):
        reached = reached @ book_matrix(row, value, convention=convention, scale={"m": 1.0, "mm": 0.001}[unit])
        frames.append(reached)
    return np.array(frames)
