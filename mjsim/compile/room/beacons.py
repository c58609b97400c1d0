"""Beacons: thin planes with pictures or markers.

A beacon in the room, or on a static object, is a plane `beacon/NAME` of the world. One on a moving object or on a
robot is a box as thin as paper, fixed to that body, as planes cannot move in MuJoCo. Both have x to the viewer's
right, y up and z towards the viewer.
"""

import math
from collections.abc import Callable, Sequence
from functools import cache

import mujoco
import numpy as np

from mjsim.compile.room.prisms import Face
from mjsim.compile.room.walls import PLANE_SPACING, VISUAL, WallBox, add_mesh_geom
from mjsim.compile.textures import MAX_BEACON_SIDE, add_material, color_of, marker_picture
from mjsim.errors import UsageError
from mjsim.geometry import Array
from mjsim.interface import Picture
from mjsim.models import bounded, quaternion_of
from mjsim.sentences import Sentence
from mjsim.world import Beacon, Hung, Marker, Robot, World, hung, printed_share

GIVEN_BACK = 0.25
"""Reflectance of a picture; it is emissive, so that its colours are the same at any angle and only a little brighter
where a lamp of high quality adds to them."""
MAX_PICTURES = 900
"""MuJoCo allows 1000 textures and as many materials."""
BACK_GAP = 0.001
"""Distance from a picture to the back that hides it from behind [m]."""
FLUSH_GAP = 0.0005
"""Offset of a picture that lies exactly in the face of a wall, against flicker [m]."""
HALF_THICKNESS = 0.0002
"""Half the thickness of a beacon that moves [m]."""
BACK = "#8d867b"
"""Colour of the back."""
REFLECTOR_PIXELS = 48

PrintedFace = tuple[str, Array]
"""Name of a material, and the size of its picture for a beacon of width 1, (width, height)."""


def face_maker(spec: mujoco.MjSpec, world: World) -> Callable[[Beacon], PrintedFace]:
    """Return a function for the material of a beacon; beacons with the same picture share one.

    Raises:
        UsageError: There are more pictures than MuJoCo can hold.
    """
    numbers = {face: number for number, face in enumerate(dict.fromkeys(map(_face, world.beacons)), start=1)}

    @cache
    def printed(face: str | Marker | None) -> PrintedFace:
        return _add_face(spec, world, face, numbers[face])

    return lambda beacon: printed(_face(beacon))


def add_hung_beacons(
    spec: mujoco.MjSpec, world: World, walls: Sequence[WallBox], face_of: Callable[[Beacon], PrintedFace]
) -> None:
    """Add the static beacons: visible from the front, each with a plain back."""
    removed = {getattr(event, "remove", None) for event in world.run.events}
    backs, solid = [], _Solid(walls)
    for item in hung(world):
        if not item.fixed:
            continue
        beacon, (material, size) = item.beacon, face_of(item.beacon)
        half = size * beacon.width / 2
        world_from_plane = _facing(item.place.heading, math.radians(beacon.tilt_deg))
        at = _before_the_wall(item, world_from_plane, solid)
        spec.worldbody.add_geom(
            name=f"beacon/{beacon.name}",
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=[*half, PLANE_SPACING],
            pos=at,
            quat=quaternion_of(world_from_plane),
            material=material,
            group=VISUAL,
            contype=0,
            conaffinity=0,
        )
        back = _back(at, world_from_plane, half)
        if beacon.name in removed or (beacon.on is not None and beacon.on in removed):
            _add_backs(spec, f"beacon/{beacon.name}:back", [back])
        else:
            backs.append(back)
    if backs:
        _add_backs(spec, "beacon:backs", backs)


def add_carried_beacons(spec: mujoco.MjSpec, world: World, face_of: Callable[[Beacon], PrintedFace]) -> None:
    """Add the beacons on robots and moving objects to their bodies, which must exist already."""
    for item in hung(world):
        if item.fixed or item.carrier is None:
            continue
        beacon, (material, size) = item.beacon, face_of(item.beacon)
        name, lift = f"{beacon.on}/base", 0.0
        if not isinstance(item.carrier, Robot):
            name, lift = f"obstacle/{beacon.on}", item.carrier.origin_height
        carrier_from_plane = _facing(math.radians(beacon.heading_deg), math.radians(beacon.tilt_deg))
        at, half = np.array([*beacon.at, item.center - lift]), size * beacon.width / 2
        common = {
            "type": mujoco.mjtGeom.mjGEOM_BOX,
            "quat": quaternion_of(carrier_from_plane),
            "group": VISUAL,
            "contype": 0,
            "conaffinity": 0,
            "mass": 0.0,
        }
        body, out = spec.body(name), carrier_from_plane[:, 2]
        body.add_geom(
            name=f"beacon/{beacon.name}",
            size=[*half, HALF_THICKNESS],
            pos=at + out * (FLUSH_GAP - HALF_THICKNESS),
            material=material,
            **common,
        )
        body.add_geom(
            name=f"beacon/{beacon.name}:back",
            size=[*half, BACK_GAP / 2],
            pos=at + out * (FLUSH_GAP - 2 * HALF_THICKNESS - BACK_GAP),
            material="matte",
            rgba=color_of(BACK),
            **common,
        )


def _face(beacon: Beacon) -> str | Marker | None:
    """Return the face of a beacon: a picture, a marker, or none."""
    return beacon.image if beacon.image is not None else beacon.marker


def _add_face(spec: mujoco.MjSpec, world: World, face: str | Marker | None, number: int) -> PrintedFace:
    if number > MAX_PICTURES:
        raise UsageError(
            Sentence(
                "more than {max_pictures} different pictures hang in this world; let some beacons share one",
                MAX_PICTURES,
            )
        )
    size = 1.0
    if face is None:
        picture = _reflector()
    elif isinstance(face, Marker):
        picture, size = marker_picture(face.dictionary, face.id), printed_share(face.dictionary)
    else:
        picture = world.read_picture(face)
    name = f"beacon/picture{number}"
    shown = bounded(picture, MAX_BEACON_SIDE)
    add_material(spec, name, shown, emission=1.0 / GIVEN_BACK, gray=GIVEN_BACK)
    return name, size * np.array([1.0, picture.shape[0] / picture.shape[1]])


def _reflector() -> Picture:
    """Return a retroreflector: a plate of small bright prisms, as on road signs."""
    y, x = np.mgrid[:REFLECTOR_PIXELS, :REFLECTOR_PIXELS]
    picture = np.full((REFLECTOR_PIXELS, REFLECTOR_PIXELS, 3), (206, 212, 218), dtype=np.uint8)
    picture[(x + y) // 4 % 2 == (x - y) // 4 % 2] = (240, 243, 246)
    picture[(x < 2) | (y < 2) | (x >= REFLECTOR_PIXELS - 2) | (y >= REFLECTOR_PIXELS - 2)] = (120, 126, 134)
    return picture


def _facing(heading: float, tilt: float) -> Array:
    """Return the axes of a plane that faces a heading and looks up by a tilt [rad], as columns, shape (3, 3)."""
    c, s, cos_tilt, sin_tilt = math.cos(heading), math.sin(heading), math.cos(tilt), math.sin(tilt)
    return np.array(
        [[-s, -c * sin_tilt, c * cos_tilt], [c, -s * sin_tilt, s * cos_tilt], [0.0, cos_tilt, sin_tilt]], dtype=float
    )


class _Solid:
    """The walls, for tests whether a point is inside."""

    def __init__(self, walls: Sequence[WallBox]) -> None:
        self._center = np.array([wall.center for wall in walls]).reshape(-1, 3)
        self._half = np.array([wall.half for wall in walls]).reshape(-1, 3)
        headings = np.array([wall.heading for wall in walls])
        self._cos, self._sin = np.cos(headings), np.sin(headings)

    def holds(self, point: Array) -> bool:
        """Return whether a point, shape (3,) [m], is inside a wall."""
        dx, dy, dz = (point - self._center).T
        c, s = self._cos, self._sin
        p_walls = np.column_stack([c * dx + s * dy, c * dy - s * dx, dz])
        return bool((np.abs(p_walls) < self._half).all(axis=1).any())


def _before_the_wall(item: Hung, world_from_plane: Array, solid: _Solid) -> Array:
    """Return the position of a picture, moved out half a millimetre if it lies in a face of a wall or object."""
    at, out = np.array([item.place.x, item.place.y, item.center]), world_from_plane[:, 2] * FLUSH_GAP
    if item.carrier is not None or (solid.holds(at - out) and not solid.holds(at + out)):
        return np.asarray(at + out, dtype=float)
    return at


def _back(at: Array, world_from_plane: Array, half: Array) -> Face:
    right, up, out = world_from_plane.T
    corners = [
        at - out * BACK_GAP + right * x * half[0] + up * y * half[1] for x, y in ((1, -1), (-1, -1), (-1, 1), (1, 1))
    ]
    return Face(np.array(corners), np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32), -out, 0)


def _add_backs(spec: mujoco.MjSpec, name: str, backs: Sequence[Face]) -> None:
    geom = add_mesh_geom(spec, name, backs, tile=1.0)
    geom.material, geom.rgba = "matte", color_of(BACK)
