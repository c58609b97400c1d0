"""Appearance of a figure: a smooth surface around each segment, with the depth, breadth and mass of the body.

Depths and breadths of head and trunk are measures of the body. Limbs have the volume of their mass; its distribution
along them is modelled by eye, as are the shapes of head, hands and feet (no data set).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from mjsim.geometry import Array
from mjsim.people.figure import Figure
from mjsim.people.loft import Mesh, Ring, loft

DENSITY = 1050.0
"""Density of limbs [kg/m^3]: between 1040 for the thigh and 1130 for forearm and lower leg; Winter, Biomechanics and
Motor Control of Human Movement (2009), table 4.1."""
FIT_ITERATIONS = 3
"""Number of iterations in which the thickness of a limb is fitted to its volume."""


def surfaces(figure: Figure) -> dict[str, tuple[Mesh, ...]]:
    """Return the surfaces of all segments by name, each in the frame of its segment; hands have a thumb."""
    found: dict[str, tuple[Mesh, ...]] = {**_trunk(figure), **_head(figure)}
    for name, make in _LEFT.items():
        left = make(figure)
        found[f"left_{name}"] = left
        found[f"right_{name}"] = tuple(_mirrored(mesh) for mesh in left)
    return {name: found[name] for name in figure.segments}


def hair(figure: Figure) -> Mesh:
    """Return the surface of the hair, in the frame of the head; it covers the skull and does not belong to the body."""
    high, long, broad = _head_sizes(figure)
    middle, thick = _mark(figure, "occiput")[0] + long / 2, 0.006
    rings = [
        Ring(0.34 * high, 0.06 * long, 0.52 * long + thick, broad / 2 + thick),
        Ring(0.62 * high, 0.30 * long, 0.515 * long + thick, broad / 2 + thick),
        Ring(0.80 * high, 0.455 * long, 0.455 * long + thick, 0.44 * broad + thick),
        Ring(0.93 * high, 0.28 * long + thick, 0.30 * long + thick, 0.29 * broad + thick),
    ]
    return _shifted(loft(rings, start=0.03, end=0.07 * high + thick), (middle, 0.0, _head_low(figure)))


def _mirrored(mesh: Mesh) -> Mesh:
    return Mesh(mesh.vertices * (1.0, -1.0, 1.0), mesh.faces[:, ::-1].copy())


def _shifted(mesh: Mesh, by: Sequence[float]) -> Mesh:
    return Mesh(mesh.vertices + np.asarray(by), mesh.faces)


def _forward(mesh: Mesh) -> Mesh:
    """Return a surface along z rotated to x: its front points up."""
    return Mesh(np.stack([mesh.vertices[:, 2], -mesh.vertices[:, 1], mesh.vertices[:, 0]], axis=-1), mesh.faces)


def _mark(figure: Figure, name: str) -> Array:
    """Return a landmark in the frame of its segment, shape (3,) [m]."""
    return np.array(figure.landmarks[name].at)


def _length(figure: Figure, segment: str) -> float:
    """Return the distance of a limb's next joint below its own [m]."""
    return -figure.segments[segment].at[2]


def _filled(figure: Figure, segment: str, make: Callable[[float], Mesh]) -> tuple[Mesh]:
    """Return a limb with the thickness that its mass requires.

    Args:
        figure: The figure.
        segment: Name of the limb.
        make: Returns its surface for a thickness [m].
    """
    volume, thickness = figure.segments[segment].solid.mass / DENSITY, 0.05
    for _ in range(FIT_ITERATIONS):
        thickness *= (volume / make(thickness).volume()) ** 0.5
    return (make(thickness),)


def _oval(along: float, thickness: float, shape: tuple[float, ...]) -> Ring:
    front, back, left, right = (thickness * each for each in shape)
    return Ring(along, front, back, left, right)


_Table = Sequence[tuple[float, tuple[float, float, float, float]]]


def _limb(figure: Figure, segment: str, length: float, table: _Table, *, ends: tuple[float, float]) -> tuple[Mesh]:
    """Return a limb from a table: positions as fractions of its length; front, back, outside and inside in thicknesses.

    The thickness follows from the volume; the rounding of the ends is given in thicknesses.
    """

    def make(thickness: float) -> Mesh:
        rings = [_oval(-place * length, thickness, shape) for place, shape in table]
        return loft(rings, start=ends[0] * thickness, end=ends[1] * thickness)

    return _filled(figure, segment, make)


def _upper_arm(figure: Figure) -> tuple[Mesh, ...]:
    table = (
        (-0.04, (0.95, 0.95, 0.00, 0.70)),
        (0.10, (1.16, 1.12, 0.00, 0.85)),
        (0.25, (1.16, 1.10, 0.00, 0.95)),
        (0.55, (1.08, 1.06, 0.00, 0.94)),
        (0.80, (0.92, 0.92, 0.86, 0.86)),
        (1.00, (0.80, 0.84, 0.86, 0.86)),
    )
    length, deltoid = _length(figure, "left_forearm"), _mark(figure, "left_deltoid")[1]
    # The shoulder muscle is as broad as measured.
    outside = {-0.04: 0.55 * deltoid, 0.10: 0.88 * deltoid, 0.25: deltoid, 0.55: 0.76 * deltoid}

    def make(thickness: float) -> Mesh:
        rings = [_oval(-place * length, thickness, shape) for place, shape in table]
        rings = [replace(ring, left=outside.get(row[0], ring.left)) for ring, row in zip(rings, table, strict=True)]
        return loft(rings, start=0.6 * thickness, end=0.8 * thickness)

    return _filled(figure, "left_upper_arm", make)


def _forearm(figure: Figure) -> tuple[Mesh, ...]:
    table = (
        (0.00, (1.02, 0.98, 1.10, 1.05)),
        (0.18, (1.22, 1.10, 1.22, 1.12)),
        (0.40, (1.12, 1.02, 1.05, 1.00)),
        (0.75, (0.84, 0.80, 0.70, 0.68)),
        (1.00, (0.74, 0.70, 0.52, 0.52)),
    )
    return _limb(figure, "left_forearm", _length(figure, "left_hand"), table, ends=(0.9, 0.5))


def _thigh(figure: Figure) -> tuple[Mesh, ...]:
    table = (
        (-0.04, (0.95, 1.00, 0.95, 0.80)),
        (0.12, (1.14, 1.12, 1.06, 0.95)),
        (0.35, (1.12, 1.02, 1.00, 0.92)),
        (0.65, (0.95, 0.84, 0.84, 0.82)),
        (0.90, (0.76, 0.72, 0.68, 0.72)),
        (1.00, (0.74, 0.68, 0.68, 0.70)),
    )
    return _limb(figure, "left_thigh", _length(figure, "left_shank"), table, ends=(0.8, 0.66))


def _shank(figure: Figure) -> tuple[Mesh, ...]:
    table = (
        (0.00, (1.06, 0.92, 1.02, 1.04)),
        (0.10, (1.04, 1.00, 1.00, 1.04)),
        (0.30, (0.92, 1.36, 1.10, 1.16)),
        (0.55, (0.82, 1.06, 0.90, 0.92)),
        (0.85, (0.62, 0.66, 0.58, 0.60)),
        (1.00, (0.66, 0.70, 0.66, 0.66)),
    )
    return _limb(figure, "left_shank", _length(figure, "left_foot"), table, ends=(0.8, 0.4))


def _hand(figure: Figure) -> tuple[Mesh, ...]:
    length, palm = (-_mark(figure, f"left_{name}")[2] for name in ("fingertip", "palm_end"))
    broad, thick = 0.225 * length, 0.068 * length
    rings = [
        Ring(0.02 * length, 0.66 * broad, 0.62 * broad, 1.05 * thick, square=2.4),
        Ring(-0.18 * length, 0.88 * broad, 0.80 * broad, 1.12 * thick, square=2.6),
        Ring(-0.92 * palm, 0.98 * broad, 0.92 * broad, 0.98 * thick, square=2.8),
        Ring(-palm - 0.25 * (length - palm), 0.92 * broad, 0.84 * broad, 0.80 * thick, square=2.8),
        Ring(-0.93 * length, 0.62 * broad, 0.42 * broad, 0.60 * thick, square=2.6),
    ]
    fingers = loft(rings, start=0.04 * length, end=0.07 * length)
    x, _, tip = _mark(figure, "left_thumb_tip")
    wide, base = 0.055 * length, -0.20 * length
    thumb = loft(
        [
            Ring(base, wide, wide, wide),
            Ring(0.6 * tip + 0.4 * base, wide, wide, wide),
            Ring(tip + wide, wide, wide, wide),
        ],
        start=wide,
        end=wide,
    )
    lean = 0.45 * (thumb.vertices[:, 2] - base) / (tip - base) * (x + 0.5 * broad)
    moved = thumb.vertices + np.column_stack([0.55 * broad + lean, np.full(len(lean), -0.3 * thick), 0.0 * lean])
    return fingers, Mesh(moved, thumb.faces)


def _foot(figure: Figure) -> tuple[Mesh, ...]:
    heel, toe = (_mark(figure, f"left_{name}") for name in ("heel", "toe"))
    long, ankle, floor = toe[0] - heel[0], -heel[2], heel[2]
    # Along x, front is up and left is the right side; rings stand on the floor.
    rows = (
        (0.06, 0.55, 0.11, 0.11),
        (0.16, 0.80, 0.13, 0.13),
        (0.30, 1.06, 0.135, 0.135),
        (0.45, 0.86, 0.145, 0.14),
        (0.62, 0.60, 0.165, 0.165),
        (0.78, 0.42, 0.175, 0.185),
        (0.93, 0.28, 0.125, 0.155),
    )
    rings = [
        Ring(heel[0] + place * long, height * ankle / 2, height * ankle / 2, outer * long, inner * long, square=2.5)
        for place, height, outer, inner in rows
    ]
    rings = [Ring(r.along, r.front, r.back, r.right or r.left, r.left, r.square) for r in rings]
    mesh = _forward(loft(rings, start=0.06 * long, end=0.07 * long))
    return (_standing(mesh, floor, rows, heel[0], long, ankle),)


def _standing(
    mesh: Mesh, floor: float, rows: Sequence[tuple[float, ...]], heel: float, long: float, ankle: float
) -> Mesh:
    """Return a foot whose rings stand on the floor instead of being centred on one axis."""
    place = (mesh.vertices[:, 0] - heel) / long
    half = np.interp(place, [row[0] for row in rows], [row[1] * ankle / 2 for row in rows])
    lifted = mesh.vertices.copy()
    lifted[:, 2] += floor + half
    # Ends are round, and never below the floor.
    lifted[:, 2] = np.maximum(lifted[:, 2], floor)
    return Mesh(lifted, mesh.faces)


_LEFT: Mapping[str, Callable[[Figure], tuple[Mesh, ...]]] = {
    "upper_arm": _upper_arm,
    "forearm": _forearm,
    "hand": _hand,
    "thigh": _thigh,
    "shank": _shank,
    "foot": _foot,
}


def _head_low(figure: Figure) -> float:
    """Return the height of the chin in the frame of the head [m]."""
    return float(_mark(figure, "vertex")[2]) - _head_sizes(figure)[0]


def _head_sizes(figure: Figure) -> tuple[float, float, float]:
    """Return height, length and breadth of the head [m]."""
    m = figure.measures
    return 1.72 * m["tragion_to_vertex"], m["head_length"], m["head_breadth"]


def _head(figure: Figure) -> dict[str, tuple[Mesh, ...]]:
    high, long, broad = _head_sizes(figure)
    middle = _mark(figure, "occiput")[0] + long / 2
    rings = [
        Ring(0.04 * high, 0.42 * long, -0.16 * long, 0.17 * broad),
        Ring(0.14 * high, 0.44 * long, 0.05 * long, 0.30 * broad),
        Ring(0.28 * high, 0.45 * long, 0.26 * long, 0.40 * broad),
        Ring(0.42 * high, 0.45 * long, 0.42 * long, 0.455 * broad),
        Ring(0.55 * high, 0.465 * long, 0.485 * long, 0.485 * broad),
        Ring(0.68 * high, 0.500 * long, 0.50 * long, 0.5 * broad),
        Ring(0.82 * high, 0.44 * long, 0.445 * long, 0.44 * broad),
        Ring(0.93 * high, 0.28 * long, 0.30 * long, 0.29 * broad),
    ]
    skull = _shifted(loft(rings, start=0.03 * high, end=0.07 * high), (middle, 0.0, _head_low(figure)))
    thick = 0.31 * broad + 0.06 * figure.measures["waist_depth"]
    top = np.array(figure.segments["head"].at)
    neck = [
        Ring(-0.25 * top[2], 0.92 * thick, 0.80 * thick, 1.05 * thick),
        Ring(0.30 * top[2], 0.90 * thick, 0.84 * thick, 0.95 * thick),
        Ring(0.95 * top[2], 0.92 * thick, 0.92 * thick, 0.92 * thick),
    ]
    made = loft(neck, start=0.02, end=0.02)
    # From the middle of the collar to below the skull.
    base, height = 0.4 * top[0], np.clip(made.vertices[:, 2] / top[2], 0.0, 1.0)
    lean = np.outer(base + height * (top[0] + 0.003 - base), (1.0, 0.0, 0.0))
    return {"head": (skull,), "neck": (Mesh(made.vertices + lean, made.faces),)}


def _trunk(figure: Figure) -> dict[str, tuple[Mesh, ...]]:
    """Return pelvis, abdomen and thorax: one outline, cut where the spine bends, with rounded transitions."""
    rows = np.array(_outline(figure))
    hip = figure.segments["pelvis"].at[2]
    omphalion = hip + figure.segments["abdomen"].at[2]
    xiphion = omphalion + figure.segments["thorax"].at[2]
    origins = {"pelvis": (0.0, hip)}
    for name, below in (("abdomen", "pelvis"), ("thorax", "abdomen")):
        x, _, z = figure.segments[name].at
        origins[name] = (origins[below][0] + x, origins[below][1] + z)
    pieces = {
        "pelvis": ([*rows[rows[:, 0] < omphalion - 0.01, 0], omphalion], 0.02, 0.05),
        "abdomen": ([omphalion, 0.5 * (omphalion + xiphion), xiphion], 0.05, 0.05),
        "thorax": ([xiphion, *rows[rows[:, 0] > xiphion + 0.01, 0]], 0.05, 0.012),
    }
    found: dict[str, tuple[Mesh, ...]] = {}
    for name, (places, start, end) in pieces.items():
        x, z = origins[name]
        mesh = loft(_rings(rows, places), start=start, end=end)
        found[name] = (_shifted(mesh, (-x, 0.0, -z)),)
    return found


def _rings(rows: Array, places: Sequence[float]) -> list[Ring]:
    """Return rings of the trunk at heights above the floor [m]."""
    from scipy.interpolate import PchipInterpolator

    found = PchipInterpolator(rows[:, 0], rows[:, 1:], axis=0)(places).tolist()
    return [
        Ring(place, front, back, side, square=square)
        for place, (front, back, side, square) in zip(places, found, strict=True)
    ]


def _outline(figure: Figure) -> list[tuple[float, ...]]:
    """Return rings of the trunk of a figure standing at the origin.

    Height, extent to the front, to the back and to a side [m], exponent of the superellipse.
    """
    m, hip = figure.measures, figure.segments["pelvis"].at[2]
    spots = figure.spots(figure.poses())
    back, buttock = -spots["chest_back"][0], -spots["buttock"][0]
    chest, waist = m["chest_depth"] - back, m["waist_depth"] - back
    broad, crest = 0.46 * m["hip_breadth_sitting"], m["bicristal_breadth"] / 2
    shoulder, neck = m["biacromial_breadth"] / 2, 0.45 * m["head_breadth"]
    girth = 0.55 * m["waist_depth"] + 0.03
    omphalion, breast = spots["waist_front"][2], spots["chest_front"][2]
    acromion, cervicale = m["acromial_height"], m["cervicale_height"]
    bosom = 0.015 if m.sex == "female" else 0.0
    return [
        (hip - figure.seat_to_hip, 0.42 * waist, 0.62 * buttock, 0.72 * broad, 2.2),
        (hip - 0.2 * figure.seat_to_hip, 0.80 * waist, 0.94 * buttock, broad, 2.3),
        (hip + 0.04, 0.90 * waist, 0.96 * buttock, 0.99 * broad, 2.3),
        (m["iliocristale_height"] - 0.03, 0.99 * waist, 0.5 * (back + 0.9 * buttock), max(crest + 0.018, girth), 2.3),
        (omphalion + 0.01, waist, back - 0.012, girth, 2.2),
        (
            0.5 * (omphalion + breast) + 0.01,
            0.5 * (waist + chest) - 0.5 * bosom,
            back - 0.006,
            0.5 * girth + 0.39 * shoulder,
            2.3,
        ),
        (breast, chest, back, 0.80 * shoulder, 2.4),
        (0.5 * (breast + acromion), 0.88 * chest - bosom, 0.98 * back, 0.88 * shoulder, 2.4),
        (acromion - 0.035, 0.60 * chest, 0.86 * back, 0.93 * shoulder, 2.2),
        (acromion - 0.012, 0.42 * chest, 0.74 * back, 0.78 * shoulder, 2.1),
        (0.55 * acromion + 0.45 * cervicale, 0.26 * chest, 0.70 * back, 0.42 * shoulder, 2.0),
        (cervicale - 0.012, 0.22 * chest, 0.62 * back, 0.95 * neck, 2.0),
    ]
