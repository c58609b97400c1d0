"""Repair of invalid inertias in the text of a model."""

import copy
import math
from collections.abc import Callable, Collection, Iterator
from typing import Any

import mujoco
import numpy as np

from mjsim.geometry import Array, nearest_moments
from mjsim.models.model_sources import Element

MIN_MASS = 1e-3
"""Mass of a link without mass [kg]."""
BALL_INERTIA = 0.4
"""Inertia of a ball divided by its mass and the square of its radius."""
GUESSED_RADIUS = 0.05
"""Radius of a ball that replaces a link [m]."""
TRIANGLE_TOLERANCE = 1.0001
"""Tolerance factor of the triangle inequality, because files are rounded."""
MAX_VIOLATION = 0.25
"""Maximum violation as a fraction of the largest moment: real arms reach this; larger violations are mistakes."""
MOMENT_TOLERANCE = 1e-8
"""Rounding tolerance as a fraction of the largest moment."""
MIN_MOMENT = 2e-14
"""MuJoCo treats smaller moments as zero [kg m^2]."""
DIGITS = ".9g"
FEATHER_MASS = 1e-6
"""Mass given to a massless link, since MuJoCo takes 0 for unknown [kg]."""
LIGHT = 0.01
"""Bodies with less mass [kg], and less than this share of the robot's moment of inertia, may have any inertia."""
IMPOSSIBLE, USUAL_SHARE = 2.0, 0.5
"""Radius of gyration, as a share of the reach of a body's shapes: above the first it is reduced to the second."""
MIN_STATED = 1e-9
"""Exporters write smaller masses as placeholders for none [kg]."""
GUESSED = "guessed"
"""Attribute of a guessed inertia, which that of the link's shapes replaces; its value is the note if there are none."""
FEATHER_SIZE = 1e-4
"""Moments of inertia of a massless link, relative to the mass given to it [m^2]."""
_URDF_KEYS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def mend_inertias(root: Element, path: str, *, feather: float = FEATHER_MASS) -> list[str]:
    """Repair masses and inertias in a model's text in place; return notes on what was done.

    Args:
        root: Tree of MJCF or URDF.
        path: Its file, for the notes.
        feather: Mass given to a massless link of URDF [kg].
    """
    return list(_mend_urdf(root, path, feather) if root.tag == "robot" else _mend_mjcf(root, path))


def mend_weightless(root: Element, path: str) -> Iterator[str]:
    """For a URDF robot without any mass, derive masses from its shapes; yield notes on what was done."""
    links = root.findall("link")
    masses = [finite_number(mass.get("value")) for link in links for mass in link.findall("inertial/mass")]
    if root.tag != "robot" or any(mass is not None and mass >= MIN_STATED for mass in masses):
        return
    for link in links:
        if link.find("collision") is None:
            # Visual shapes have no mass.
            for picture in link.findall("visual"):
                solid = copy.deepcopy(picture)
                solid.tag = "collision"
                link.append(solid)
    yield f"{path}: no link has a mass; its shapes get a density of 1000 kg/m^3 instead"


def mended(inertia: Array) -> tuple[Array, str] | None:
    """Return a physically valid inertia, and what was wrong with the given one; None if it is valid.

    Args:
        inertia: Symmetric, shape (3, 3) [kg m^2].
    """
    if not np.isfinite(inertia).all():
        return np.eye(3) * BALL_INERTIA * MIN_MASS * GUESSED_RADIUS**2, "is no number"
    values, vectors = np.linalg.eigh(inertia)
    if values[2] <= MIN_MOMENT:
        return None  # MuJoCo derives it from the shapes, or uses the minimum
    low = values[0]
    if low <= MIN_MOMENT:
        rod = abs(low) < MOMENT_TOLERANCE * values[2] and values[1] > values[2] / TRIANGLE_TOLERANCE
        wrong = "is that of a rod without thickness" if rod else f"has a principal moment of {low:.3g} kg m^2"
        values = np.maximum(values, values[2] / 2)
        return vectors @ np.diag(values) @ vectors.T, wrong
    if values[0] + values[1] < values[2] / TRIANGLE_TOLERANCE:
        miss = values[2] - values[0] - values[1]
        verb = "breaks" if miss > MAX_VIOLATION * values[2] else "slightly misses"
        reason = f"{verb} the triangle inequality ({values[0]:.3g} + {values[1]:.3g} < {values[2]:.3g} kg m^2)"
        # Slightly more than required: it is rounded when it is written.
        spare = MOMENT_TOLERANCE * values[2] * np.array([1.0, 1.0, -1.0])
        return vectors @ np.diag(nearest_moments(values) + spare) @ vectors.T, reason
    return None


def gyrations(model: Any) -> Iterator[tuple[str, float, float]]:
    """Yield the name, the largest radius of gyration, and the reach of the shapes of each body that matters [m].

    A body without shapes may reach as far as the widest of the others.
    """
    away = np.linalg.norm(model.geom_pos - model.body_ipos[model.geom_bodyid], axis=1) + model.geom_rbound
    reaches = np.zeros(model.nbody)
    np.maximum.at(reaches, model.geom_bodyid, away)
    masses, moments, widest = model.body_mass, model.body_inertia.max(axis=1), float(reaches.max())
    matters = (masses > LIGHT) | (moments > LIGHT * masses.sum() * widest**2)
    for body in np.flatnonzero(matters & (masses > 0.0) & (widest > 0.0)):
        gyration = float(np.sqrt(moments[body] / masses[body]))
        yield model.body(int(body)).name, gyration, float(reaches[body]) or widest


def mend_impossible(root: Element, path: str, model: Any) -> Iterator[str]:
    """Reduce inertias that are far beyond what the shapes of a body can have, and yield notes on what was done.

    Args:
        root: The tree of the file, which is changed.
        path: The file.
        model: The model that MuJoCo compiles from it.
    """
    found = {
        name: (gyration, reach) for name, gyration, reach in gyrations(model) if name and gyration > IMPOSSIBLE * reach
    }
    for item in [*root.iter("link"), *root.iter("body")]:
        gyration, reach = found.get(item.get("name", ""), (0.0, 0.0))
        tensor = item.find("inertial/inertia") if item.tag == "link" else item.find("inertial")
        if tensor is None or not gyration:
            continue
        factor = (USUAL_SHARE * reach / gyration) ** 2
        for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz", "diaginertia", "fullinertia"):
            numbers = [finite_number(word) for word in tensor.get(key, "").split()]
            if numbers and None not in numbers:
                tensor.set(key, " ".join(format(factor * (value or 0.0), DIGITS) for value in numbers))
        yield (
            f"{path}: the inertia of {item.tag} '{item.get('name')}' is as if all its mass were {gyration:.2f} m away,"
            f" but it reaches {reach:.2f} m; scaled to its size"
        )


def mend_guessed(root: Element, path: str, compiled: Callable[[], Any]) -> Iterator[str]:
    """Give URDF links with a mass but no inertia the inertia of their shapes, and yield notes on what was done.

    Args:
        root: The tree of the file, which is changed.
        path: The file.
        compiled: Returns the model that MuJoCo compiles from the tree.
    """
    notes = [(link, held, held.attrib.pop(GUESSED)) for link in root.findall("link") for held in _guessed(link)]
    if not notes:
        return
    held_by = {link: held for link, _, _ in notes if (held := link.find("inertial")) is not None}
    for link, inertial in held_by.items():
        link.remove(inertial)
    model = compiled()  # MuJoCo computes what is missing from the shapes, at one density.
    for link, inertia, note in notes:
        link.append(held_by[link])
        body = model.body(link.get("name", ""))
        if not model.body_geomnum[body.id]:  # Its meshes are missing.
            yield note
            continue
        turned = np.zeros(9)
        mujoco.mju_quat2Mat(turned, body.iquat)
        axes = turned.reshape(3, 3)
        matrix = axes @ np.diag(body.inertia) @ axes.T * (_stated(link) / float(body.mass[0]))
        _write_tensor(inertia, matrix)
        for origin in held_by[link].findall("origin"):
            origin.attrib.pop("rpy", None)
        yield f"{note.partition('; made')[0]}; made {_moments(matrix)}, that of its shapes with its mass"


def _guessed(link: Element) -> list[Element]:
    """Return the inertia of a link, if it is to be computed from its shapes."""
    return link.findall(f"inertial/inertia[@{GUESSED}]")[:1]


def _write_tensor(inertia: Element, matrix: Array) -> None:
    for key, value in zip(_URDF_KEYS, matrix[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]], strict=True):
        inertia.set(key, format(value, DIGITS))


def _mend_urdf(root: Element, path: str, feather: float) -> Iterator[str]:
    heavy = {link.get("name", "?") for link in root.findall("link") if _weight_of(link) > 0.0}
    carried = _fixed_to(root, heavy)
    for link in root.findall("link"):
        inertial, name = link.find("inertial"), link.get("name", "?")
        if name in carried:
            below = _stated(link)
            if below != 0.0:
                yield f"{path}: link '{name}' has a mass of {below:g} kg; it gets a negligible mass instead"
            _lighten(link, feather)
            continue
        has = link.find("collision") is not None
        if inertial is None:
            if heavy and has:
                yield f"{path}: link '{name}' has no mass; its shapes get a density of 1000 kg/m^3 instead"
            continue
        mass, inertia = inertial.find("mass"), inertial.find("inertia")
        weight = finite_number(mass.get("value") if mass is not None else None)
        if weight is None or weight < MIN_STATED:
            link.remove(inertial)
            instead = "its shapes get a density of 1000 kg/m^3 instead" if has else "it gets a negligible mass instead"
            yield f"{path}: link '{name}' has a mass of {_shown(weight)} kg; {instead}"
            continue
        if inertia is None:
            yield from _ball(inertial, weight, f"{path}: link '{name}'", shapes=has)
            continue
        a, b, c, ab, ac, bc = (finite_number(inertia.get(key, "0")) or 0.0 for key in _URDF_KEYS)
        found = mended(np.array([[a, ab, ac], [ab, b, bc], [ac, bc, c]]))
        if found is None and max(a, b, c) <= MIN_MOMENT:
            inertial.remove(inertia)
            given = f" (its file says {a:g}, {b:g}, {c:g})" if any((a, b, c)) else ""
            yield from _ball(inertial, weight, f"{path}: link '{name}'", given, shapes=has)
        elif found is not None:
            matrix, wrong = found
            _write_tensor(inertia, matrix)
            yield f"{path}: the inertia of link '{name}' {wrong}; made {_moments(matrix)}"


def _stated(link: Element) -> float:
    """Return the mass that the file states for a link of URDF, 0 if none [kg]."""
    mass = link.find("inertial/mass")
    return finite_number(mass.get("value") if mass is not None else None) or 0.0


def _weight_of(link: Element) -> float:
    """Return the mass of a link of URDF, 0 if the file gives none, or a placeholder [kg]."""
    stated = _stated(link)
    return stated if stated < 0.0 or stated >= MIN_STATED else 0.0


def _fixed_to(root: Element, heavy: Collection[str]) -> frozenset[str]:
    """Return the URDF links that fixed joints attach to some links, without these."""
    ends = [
        {end.get("link", "") for end in (*joint.findall("parent"), *joint.findall("child"))}
        for joint in root.findall("joint")
        if joint.get("type") == "fixed"
    ]
    found = set(heavy)
    while more := {name for pair in ends if pair & found for name in pair} - found:
        found |= more
    return frozenset(found.difference(heavy))


def _lighten(link: Element, feather: float) -> None:
    """Make a link massless, as one without a mass is in URDF; MuJoCo would derive a mass from its shapes."""
    for inertial in link.findall("inertial"):
        link.remove(inertial)
    new = link.makeelement("inertial", {})
    new.append(new.makeelement("mass", {"value": format(feather, DIGITS)}))
    moments = dict.fromkeys(("ixx", "iyy", "izz"), format(max(FEATHER_SIZE * feather, 5.0 * MIN_MOMENT), DIGITS))
    new.append(new.makeelement("inertia", moments | dict.fromkeys(("ixy", "ixz", "iyz"), "0")))
    link.append(new)


def _ball(inertial: Element, weight: float, called: str, given: str = "", *, shapes: bool = False) -> Iterator[str]:
    """Give a link the inertia of a ball; yield what was done, unless `mend_guessed` will use its shapes."""
    value = BALL_INERTIA * weight * GUESSED_RADIUS**2
    keys = dict.fromkeys(("ixx", "iyy", "izz"), format(value, DIGITS)) | dict.fromkeys(("ixy", "ixz", "iyz"), "0")
    new = inertial.makeelement("inertia", keys)
    inertial.append(new)
    note = f"{called} has no inertia{given}; made {value:.3g} kg m^2, that of a ball of {GUESSED_RADIUS:g} m"
    if shapes:
        new.set(GUESSED, note)
    else:
        yield note


def _mend_mjcf(root: Element, path: str) -> Iterator[str]:
    for body in root.iter("body"):
        inertial = body.find("inertial")
        if inertial is None:
            continue
        called = f"body '{body.get('name', '?')}'"
        weight = finite_number(inertial.get("mass"))
        if weight is None or weight < MIN_STATED:
            body.remove(inertial)
            yield f"{path}: {called} has a mass of {_shown(weight)} kg; its mass is computed from its shapes instead"
            continue
        for key, count in (("diaginertia", 3), ("fullinertia", 6)):
            numbers = [finite_number(word) for word in inertial.get(key, "").split()]
            if len(numbers) != count:
                continue
            values = np.array([np.nan if number is None else number for number in numbers])
            found = mended(_matrix(values))
            if found is not None:
                inertial.attrib.pop(key)
                matrix, wrong = found
                ordered = matrix[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
                inertial.set("fullinertia", " ".join(format(value, DIGITS) for value in ordered))
                if key == "diaginertia":
                    inertial.attrib.pop("fullinertia")
                    inertial.set(key, " ".join(format(value, DIGITS) for value in np.diag(matrix)))
                yield f"{path}: the inertia of {called} {wrong}; made {_moments(matrix)}"


def _matrix(values: Array) -> Array:
    """Return the matrix of three or six numbers in the order of MJCF, shape (3, 3)."""
    if len(values) == 3:
        return np.diag(values)
    a, b, c, ab, ac, bc = values
    return np.array([[a, ab, ac], [ab, b, bc], [ac, bc, c]])


def _moments(matrix: Array) -> str:
    return f"{', '.join(f'{value:.3g}' for value in np.linalg.eigvalsh(matrix))} kg m^2"


def finite_number(text: str | None) -> float | None:
    """Return a finite number from a text; None if it is not one."""
    try:
        value = float(text or "")
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _shown(weight: float | None) -> str:
    return "nothing" if weight is None else f"{weight:g}"
