"""The map as Foxglove draws it: walls, obstacles, beacons, doors, movers and people."""

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from foxglove.messages import (
    Color,
    CubePrimitive,
    Point3,
    Quaternion,
    SceneEntity,
    SceneEntityDeletion,
    SceneEntityDeletionType,
    SceneUpdate,
    SpherePrimitive,
    TextPrimitive,
    TriangleListPrimitive,
    Vector3,
)
from foxglove.messages import Pose as FoxglovePose
from numpy.typing import NDArray

from mjsim.geometry import Array, Pose
from mjsim.models import shown_size
from mjsim.plan import INKS
from mjsim.record.drawn.scene_messages import stamp
from mjsim.world import (
    Beacon,
    Hung,
    Looks,
    Obstacle,
    Robot,
    World,
    first_looks,
    hung,
    item_names,
    leaves,
    prisms,
    solid_pieces,
    stays,
    world_from_obstacle,
)

BEACON_THICKNESS = 0.02
"""Drawn thickness [m]."""
LAMP_SIZE = 0.15
"""Drawn diameter [m]."""


def map_update(world: World, files: Mapping[str, bytes]) -> SceneUpdate:
    """Return the whole world at the start.

    Moving things are drawn in frames of their own: `obstacle/NAME` and `door/NAME`.

    Args:
        world: World of the recording.
        files: The pictures that it names.
    """
    walls = [
        _prism(piece.outline, piece.low, piece.high, wall.color)
        for wall, pieces in zip(world.walls, solid_pieces(world.walls), strict=True)
        for piece in pieces
    ]
    doors = [
        _entity(
            f"door/{leaf.name}",
            f"door/{leaf.name}",
            triangles=[_prism(leaf.outline(), leaf.low, leaf.high, leaf.door.color)],
        )
        for leaf in leaves(world)
    ]
    looks = first_looks(world)
    entities = [_entity("walls", triangles=walls), *doors, *_people(world), *_changeable(world, files, looks)]
    return SceneUpdate(entities=entities)


def looks_update(world: World, files: Mapping[str, bytes], looks: Looks, *, time: float) -> SceneUpdate:
    """Return the changes made by events until a time [s]: brightness of lamps, and removed things."""
    carried = [f"beacon/{item.beacon.name}" for item in hung(world) if not item.fixed]
    moving = [f"obstacle/{name}" for item, name in _obstacles(world) if not stays(item)]
    removed = [
        SceneEntityDeletion(timestamp=stamp(time), type=SceneEntityDeletionType.MatchingId, id=name)
        for name in (*moving, *carried)
        if name.partition("/")[2] in looks.removed
    ]
    return SceneUpdate(deletions=removed, entities=_changeable(world, files, looks, time=time))


def _changeable(world: World, files: Mapping[str, bytes], looks: Looks, *, time: float = 0.0) -> list[SceneEntity]:
    """Return the entities that events may change."""
    present = [(item, name) for item, name in _obstacles(world) if name not in looks.removed]
    beacons = [item for item in hung(world) if item.beacon.name not in looks.removed]
    fixed = [item for item in beacons if item.fixed]
    standing = [_prism(*prism, item.color) for item, _ in present if stays(item) for prism in prisms(item)]
    return [
        _entity("obstacles", time=time, triangles=standing),
        *(_moving(item, name, time) for item, name in present if not stays(item)),
        _entity(
            "beacons",
            time=time,
            cubes=[_plate(item, item.place, files) for item in fixed],
            texts=[_label(item, item.place) for item in fixed],
        ),
        *(_carried(item, files, time) for item in beacons if not item.fixed),
        _entity("lamps", time=time, spheres=list(_lamps(world, looks))),
    ]


def _people(world: World) -> Iterator[SceneEntity]:
    """Yield people, each as prisms in the colours of the clothes."""
    if not world.people:
        return
    from mjsim.posture import columns_of

    for person in world.people:
        body = [_prism(*prism, person.color_of(segment)) for segment, prism in columns_of(world, person).items()]
        yield _entity(f"person/{person.name}", triangles=body)


def _entity(
    name: str,
    frame: str = "world",
    *,
    time: float = 0.0,
    triangles: Sequence[TriangleListPrimitive] = (),
    spheres: Sequence[SpherePrimitive] = (),
    cubes: Sequence[CubePrimitive] = (),
    texts: Sequence[TextPrimitive] = (),
) -> SceneEntity:
    """Return an entity in a frame; it moves along if the frame moves."""
    return SceneEntity(
        timestamp=stamp(time),
        frame_id=frame,
        id=name,
        frame_locked=frame != "world",
        triangles=list(triangles),
        spheres=list(spheres),
        cubes=list(cubes),
        texts=list(texts),
    )


def _obstacles(world: World) -> Iterator[tuple[Obstacle, str]]:
    return zip(world.obstacles, item_names(world.obstacles), strict=True)


def _moving(item: Obstacle, name: str, time: float) -> SceneEntity:
    own = world_from_obstacle(item).inverse()
    shown = [_prism(own.transform(outline), low, high, item.color) for outline, low, high in prisms(item)]
    return _entity(f"obstacle/{name}", f"obstacle/{name}", time=time, triangles=shown)


def _carried(item: Hung, files: Mapping[str, bytes], time: float) -> SceneEntity:
    """Return a beacon in the frame of its carrier."""
    carrier = item.carrier
    assert carrier is not None
    place = Pose(carrier.at[0], carrier.at[1], math.radians(carrier.heading_deg)).inverse() @ item.place
    frame = f"{carrier.name}/base" if isinstance(carrier, Robot) else f"obstacle/{carrier.name}"
    plate, label = [_plate(item, place, files)], [_label(item, place)]
    return _entity(f"beacon/{item.beacon.name}", frame, time=time, cubes=plate, texts=label)


def _plate(item: Hung, place: Pose, files: Mapping[str, bytes]) -> CubePrimitive:
    size = Vector3(x=BEACON_THICKNESS, y=item.beacon.width, z=_height(item.beacon, files))
    return CubePrimitive(pose=_pose_of(item, place), size=size, color=_color(INKS["beacon"].light))


def _label(item: Hung, place: Pose) -> TextPrimitive:
    return TextPrimitive(
        pose=_pose_of(item, place),
        billboard=True,
        font_size=12.0,
        scale_invariant=True,
        color=_color("#000000"),
        text=item.beacon.name,
    )


def _lamps(world: World, looks: Looks) -> Iterator[SpherePrimitive]:
    for lamp, name in zip(world.lamps, item_names(world.lamps), strict=True):
        x, y = lamp.at
        yield SpherePrimitive(
            pose=FoxglovePose(position=Vector3(x=x, y=y, z=lamp.height), orientation=Quaternion(w=1.0)),
            size=Vector3(x=LAMP_SIZE, y=LAMP_SIZE, z=LAMP_SIZE),
            color=_color(lamp.color, share=min(looks.lamps[name], 1.0)),
        )


def _color(text: str, *, share: float = 1.0) -> Color:
    """Return a colour '#rrggbb', darkened by a factor."""
    r, g, b = (share * int(text[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return Color(r=r, g=g, b=b, a=1.0)


def _height(beacon: Beacon, files: Mapping[str, bytes]) -> float:
    """Return the height of a beacon in the map [m]; without a picture it is as high as wide."""
    width, height = (1, 1) if beacon.image is None else shown_size(files[beacon.image])
    return beacon.width * height / width


def _pose_of(item: Hung, place: Pose) -> FoxglovePose:
    """Return the pose of a beacon, with x in its facing direction and z up, in the frame in which it is drawn."""
    turn, tilt = place.heading / 2, -math.radians(item.beacon.tilt_deg) / 2
    c, s, cos_tilt, sin_tilt = math.cos(turn), math.sin(turn), math.cos(tilt), math.sin(tilt)
    return FoxglovePose(
        position=Vector3(x=float(place.x), y=float(place.y), z=item.center),
        orientation=Quaternion(x=-s * sin_tilt, y=c * sin_tilt, z=s * cos_tilt, w=c * cos_tilt),
    )


def _prism(outline: Array, low: float, high: float, color: str) -> TriangleListPrimitive:
    corners, triangles = prism(outline, low, high)
    return TriangleListPrimitive(
        points=[Point3(x=x, y=y, z=z) for x, y, z in corners.tolist()],
        color=_color(color),
        indices=triangles.ravel().tolist(),
    )


def prism(outline: Array, low: float, high: float) -> tuple[Array, NDArray[np.int64]]:
    """Return the mesh of an upright prism.

    Args:
        outline: Convex, counter-clockwise, shape (n, 2) [m].
        low: Height of its lower face [m].
        high: Height of its upper face [m].

    Returns:
        corners: Shape (2 n, 3) [m], the lower ones first.
        triangles: Indices of corners, counter-clockwise from outside, shape (4 n - 4, 3).
    """
    n = len(outline)
    corners = np.vstack([np.column_stack([outline, np.full(n, z)]) for z in (low, high)])
    faces = []
    for i in range(n):
        j = (i + 1) % n
        faces += [(i, j, n + j), (i, n + j, n + i)]
    for i in range(1, n - 1):
        faces += [(n, n + i, n + i + 1), (0, i + 1, i)]
    return corners, np.array(faces)
