"""Beacons: thin planes with pictures."""

import math
from collections.abc import Sequence

import mujoco
import numpy as np

from mjsim.compile.pictures import LONGEST_BEACON_SIDE, add_material, bounded, color_of, read_picture
from mjsim.compile.solids import Face
from mjsim.compile.walls import UNDIVIDED, VISUAL, WallBox, add_mesh_geom
from mjsim.errors import UsageError
from mjsim.geometry import Array
from mjsim.interface import Picture
from mjsim.world.model import World
from mjsim.world.things import Beacon

GIVEN_BACK = 0.25
"""Share of the lamps' light that a picture gives back; it shines by itself, so that its colours are its own at
any angle and only a little brighter where a lamp of high quality adds to it."""
MOST_PICTURES = 900
"""MuJoCo holds 1000 textures and as many materials."""
BACK_GAP = 0.001
"""From a picture to the back that hides it from behind [m]."""
FLUSH_GAP = 0.0005
"""By which a picture that lies exactly in the face of a wall stands out, lest both flicker [m]."""
REFLECTOR_PIXELS = 48


def add_beacons(spec: mujoco.MjSpec, world: World, walls: Sequence[WallBox]) -> None:
    """Add the beacons: flat pictures that are seen from their front, each with a plain back."""
    materials: dict[str | None, tuple[str, float]] = {}
    backs, solid = [], _Solid(walls)
    for beacon in world.beacons:
        if beacon.image not in materials:
            materials[beacon.image] = _add_picture(spec, world, beacon.image, len(materials) + 1)
        material, shape = materials[beacon.image]
        half = np.array([beacon.width, beacon.width * shape]) / 2
        at = _before_the_wall(beacon, solid)
        spec.worldbody.add_geom(
            name=f"beacon/{beacon.name}",
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=[*half, UNDIVIDED],
            pos=[*at, beacon.center],
            quat=_upright(beacon.heading_deg),
            material=material,
            group=VISUAL,
            contype=0,
            conaffinity=0,
        )
        backs.append(_back(beacon, at, half))
    if backs:
        geom = add_mesh_geom(spec, "beacon:backs", backs, tile=1.0)
        geom.material, geom.rgba = "matte", color_of("#8d867b")


def _add_picture(spec: mujoco.MjSpec, world: World, image: str | None, number: int) -> tuple[str, float]:
    """Add the material of a picture; return its name and the picture's height as a share of its width."""
    if number > MOST_PICTURES:
        raise UsageError(f"more than {MOST_PICTURES} different pictures hang in this world; let some beacons share one")
    picture = _reflector() if image is None else read_picture(world.read_asset(image))
    name = f"beacon/picture{number}"
    shown = bounded(picture, LONGEST_BEACON_SIDE)
    add_material(spec, name, shown, emission=1.0 / GIVEN_BACK, gray=GIVEN_BACK)
    return name, picture.shape[0] / picture.shape[1]


def _reflector() -> Picture:
    """Return a plate of small bright prisms, as on road signs."""
    y, x = np.mgrid[:REFLECTOR_PIXELS, :REFLECTOR_PIXELS]
    picture = np.full((REFLECTOR_PIXELS, REFLECTOR_PIXELS, 3), (206, 212, 218), dtype=np.uint8)
    picture[(x + y) // 4 % 2 == (x - y) // 4 % 2] = (240, 243, 246)
    picture[(x < 2) | (y < 2) | (x >= REFLECTOR_PIXELS - 2) | (y >= REFLECTOR_PIXELS - 2)] = (120, 126, 134)
    return picture


def _upright(heading_deg: float) -> Array:
    """Return the quaternion of a plane that faces a heading: its x to the viewer's right, its y up, its z outwards."""
    c, s = math.cos(math.radians(heading_deg)), math.sin(math.radians(heading_deg))
    world_from_plane = np.array([[-s, 0.0, c], [c, 0.0, s], [0.0, 1.0, 0.0]])
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, world_from_plane.ravel())
    return quaternion


def _facing(beacon: Beacon) -> Array:
    return np.array([math.cos(math.radians(beacon.heading_deg)), math.sin(math.radians(beacon.heading_deg))])


class _Solid:
    """The walls, to ask whether a point is inside."""

    def __init__(self, walls: Sequence[WallBox]) -> None:
        self._center = np.array([wall.center for wall in walls]).reshape(-1, 3)
        self._half = np.array([wall.half for wall in walls]).reshape(-1, 3)
        headings = np.array([wall.heading for wall in walls])
        self._cos, self._sin = np.cos(headings), np.sin(headings)

    def holds(self, point: Array) -> bool:
        """Say whether a point, shape (3,) [m], is inside a wall."""
        dx, dy, dz = (point - self._center).T
        c, s = self._cos, self._sin
        p_walls = np.column_stack([c * dx + s * dy, c * dy - s * dx, dz])
        return bool((np.abs(p_walls) < self._half).all(axis=1).any())


def _before_the_wall(beacon: Beacon, solid: _Solid) -> Array:
    """Return where a picture hangs, moved out by half a millimetre when it lies in the face of a wall."""
    at, facing = np.array(beacon.at), _facing(beacon)
    behind, before = (np.append(at + facing * gap, beacon.center) for gap in (-FLUSH_GAP, FLUSH_GAP))
    return at + facing * FLUSH_GAP if solid.holds(behind) and not solid.holds(before) else at


def _back(beacon: Beacon, at: Array, half: Array) -> Face:
    facing = _facing(beacon)
    left = np.array([-facing[1], facing[0]])
    x, y = at - facing * BACK_GAP + np.outer([1, -1], left) * half[0], beacon.center + half[1] * np.array([-1, 1])
    corners = [(*x[0], y[0]), (*x[1], y[0]), (*x[1], y[1]), (*x[0], y[1])]
    return Face(np.array(corners), np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32), np.array([*-facing, 0.0]), 0)
