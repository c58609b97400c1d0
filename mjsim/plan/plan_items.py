"""The display list of a world at its start, from the floor up."""

import itertools
import math
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.plan.shapes import ORIGIN, PlanItem
from mjsim.posture import from_above
from mjsim.world import (
    FloorPatch,
    Hung,
    Lamp,
    Leaf,
    Obstacle,
    OpenEvent,
    Opening,
    Person,
    Piece,
    RampObstacle,
    Robot,
    RobotArm,
    StepsObstacle,
    Wall,
    World,
    footprint,
    hung,
    item_names,
    leaves,
    solid_pieces,
    stays,
    top,
    world_from_obstacle,
)

SECTION_HEIGHT = 1.0
"""Height of the section [m]: through windows and doors, above tables and benches."""
SWING_ANGLE = 90.0
"""Angle of the swing arc of a closed door, unless its limit is below [deg]."""
MIN_ROBOT = 1.0
"""Minimum radius of a drawn robot [mm]."""
HEAD = np.array([[0.0, 0.0], [-1.6, 0.6], [-1.6, -0.6]])
"""Head of an arrow, its tip at the origin [mm]."""


def world_shapes(world: World) -> list[PlanItem]:
    """Return the shapes of all that a plan shows, from the floor up; mechanisms are left to `mjsim.video`."""
    walls = [shape for pieces in solid_pieces(world.walls) for shape in wall_shapes(pieces)]
    named = list(zip(world.obstacles, item_names(world.obstacles), strict=True))
    lamps = zip(world.lamps, item_names(world.lamps), strict=True)
    return [
        *map(patch_shape, world.floor.patches),
        *(shape for shape in walls if shape.role == "low wall"),
        *(shape for each in sorted(named, key=lambda each: top(each[0])) for shape in obstacle_shapes(*each)),
        *(shape for each in named for shape in route_shapes(*each)),
        *(shape for shape in walls if shape.role == "wall"),
        *(shape for wall in world.walls for opening in wall.openings for shape in window_shapes(wall, opening)),
        *(shape for leaf in leaves(world) for shape in leaf_shapes(world, leaf)),
        *(shape for lamp, name in lamps for shape in lamp_shapes(lamp, name)),
        *(shape for person in world.people for shape in person_shapes(world, person)),
        *(shape for robot in world.robots for shape in robot_shapes(robot)),
        *(shape for item in hung(world) for shape in beacon_shapes(item)),
    ]


def patch_shape(patch: FloorPatch) -> PlanItem:
    """Return a patch of the floor."""
    return PlanItem(role="patch", parts=(patch.outline(),), tint=patch.color)


def wall_shapes(pieces: Iterable[Piece]) -> Iterator[PlanItem]:
    """Yield the parts of a wall that end below `SECTION_HEIGHT`, and its section there."""
    low = [piece.outline for piece in pieces if piece.high <= SECTION_HEIGHT]
    cut = [piece.outline for piece in pieces if piece.low <= SECTION_HEIGHT < piece.high]
    for role, parts in (("low wall", low), ("wall", cut)):
        if parts:
            yield PlanItem(role=role, parts=parts)


def window_shapes(wall: Wall, opening: Opening) -> Iterator[PlanItem]:
    """Yield the pane of a window; nothing for a doorway."""
    if opening.sill > 0.0:
        first, last = (np.array(end) for end in wall.segments()[opening.segment])
        along = (last - first) / np.hypot(*(last - first))
        ends = first + np.outer([opening.at, opening.at + opening.width], along)
        yield PlanItem(role="window", kind="line", parts=(ends,))


def route_shapes(item: Obstacle, name: str) -> Iterator[PlanItem]:
    """Yield the path of an obstacle that moves by itself, with an arrow in each of its segments."""
    if item.path is None:
        return
    points = np.array([item.at, *item.path.points, *([item.at] if item.path.closed else [])])
    yield PlanItem(role="route", kind="line", parts=(points,), of=name)
    for start, end in itertools.pairwise(points):
        x, y = ((start + end) / 2).tolist()
        place = Pose(x, y, math.atan2(*(end - start)[::-1]))
        yield PlanItem(role="route", parts=(HEAD,), symbol=True, place=place, of=name)


def obstacle_shapes(item: Obstacle, name: str) -> Iterator[PlanItem]:
    """Yield an obstacle in a muted version of its colour; ramps and steps have an arrow up.

    Movable objects have a dashed edge, those hanging above the section a fine one.
    """
    place = world_from_obstacle(item)
    frame = "" if stays(item) else f"obstacle/{name}"
    movable = "obstacle" if stays(item) else "movable"
    role = "hanging" if item.elevation > SECTION_HEIGHT else movable
    outline = place.inverse().transform(footprint(item))
    level = 0.6 if top(item) < SECTION_HEIGHT else 1.0

    def shape(role: str, *parts: Array, line: bool = False, symbol: bool = False, at: Pose = ORIGIN) -> PlanItem:
        return PlanItem(
            role=role, parts=parts, kind="line" if line else "area", symbol=symbol, of=name, frame=frame,
            place=place @ at, frame_from_shape=at, tint=item.color, level=level,
        )  # fmt: skip

    yield shape(role, outline)
    if isinstance(item, (RampObstacle, StepsObstacle)):
        length, width, _ = item.ramp if isinstance(item, RampObstacle) else item.steps
        if isinstance(item, StepsObstacle):
            steps = length * (np.arange(1, item.count) / item.count - 0.5)
            yield shape("tread", *(np.array([[x, -width / 2], [x, width / 2]]) for x in steps), line=True)
        yield shape("way up", np.array([[-0.42 * length, 0.0], [0.42 * length, 0.0]]), line=True)
        yield shape("way up", HEAD, symbol=True, at=Pose(0.42 * length, 0.0, 0.0))


def leaf_shapes(world: World, leaf: Leaf) -> Iterator[PlanItem]:
    """Yield the arc of a door's swing, and its leaf in its initial position."""
    path = leaf_path(leaf, swing(world, leaf))
    yield PlanItem(role="swing", kind="line", parts=(path, np.stack([leaf.hinge, path[-1]])), of=leaf.name)
    yield PlanItem(
        role="leaf",
        parts=(leaf.outline(),),
        place=leaf.pose(math.radians(leaf.door.angle_deg)),
        frame=f"door/{leaf.name}",
        of=leaf.name,
        tint=leaf.door.color,
    )


def leaf_path(leaf: Leaf, angle_deg: float) -> Array:
    """Return the path of a leaf's free edge from closed to an angle, world frame, shape (n, 2) [m]."""
    return arc(leaf.hinge, leaf.width, leaf.closed, leaf.closed + leaf.turn * math.radians(angle_deg))


def swing(world: World, leaf: Leaf) -> float:
    """Return the drawn swing of a door [deg]: as an event opens it, or its initial angle if above `SWING_ANGLE`."""
    opened = [event for event in world.run.events if isinstance(event, OpenEvent) and event.open == leaf.name]
    if opened:
        return max((event.angle_deg for event in opened), key=abs)
    standing = leaf.door.angle_deg
    return math.copysign(max(abs(standing), min(SWING_ANGLE, leaf.door.limit_deg)), standing)


def lamp_shapes(lamp: Lamp, name: str) -> Iterator[PlanItem]:
    """Yield a lamp as a small sun; a lamp that is off is hollow."""
    angles = np.arange(8) * (np.pi / 4)
    rays = [np.outer([1.2, 1.8], (math.cos(angle), math.sin(angle))) for angle in angles]
    place = Pose(lamp.at[0], lamp.at[1], 0.0)
    yield PlanItem(role="lamp", kind="line", parts=rays, symbol=True, place=place)
    level = min(lamp.brightness, 1.0)
    yield PlanItem(role="lamp", parts=(circle(0.8),), symbol=True, place=place, frame=f"lamp/{name}", level=level)


def person_shapes(world: World, person: Person) -> Iterator[PlanItem]:
    """Yield the segments of a person, the lowest first."""
    for outline, tint in from_above(world, person):
        yield PlanItem(role="person", parts=(outline,), tint=tint, of=person.name)


def robot_shapes(robot: Robot) -> Iterator[PlanItem]:
    """Yield a robot at its initial pose, with an arrow in its forward direction, and its arms."""
    place, outline = start_of(robot), robot.body.outline()
    nose = Pose(float(np.max(outline[:, 0])), 0.0, 0.0)
    body = PlanItem(
        role="robot", parts=(outline,), place=place, of=robot.name, frame=f"robot/{robot.name}",
        tint=robot.body.color, least=MIN_ROBOT,
    )  # fmt: skip
    yield body
    shaft = replace(body, role="heading", kind="line", parts=(np.array([[0.0, 0.0], [nose.x, 0.0]]),), least=0.0)
    tip = replace(shaft, parts=(np.array([[0.0, 0.0], [1.0, 0.0]]),), symbol=True, place=place @ nose)
    yield shaft
    yield replace(tip, frame_from_shape=nose)
    yield replace(tip, frame_from_shape=nose, kind="area", parts=(HEAD + np.array([2.4, 0.0]),))
    for arm in robot.arms:
        yield from arm_shapes(robot.name, arm, np.array(arm.start()), place)


def start_of(robot: Robot) -> Pose:
    """Return the initial pose of a robot."""
    return Pose(robot.at[0], robot.at[1], math.radians(robot.heading_deg))


def arm_shapes(robot: str, item: RobotArm, q: Array, place: Pose) -> Iterator[PlanItem]:
    """Yield the links of an arm seen from above, the lowest first, and its tool.

    Args:
        robot: Name of its robot.
        item: The arm.
        q: Joint values, shape (n,) [rad, m].
        place: Pose of the robot.
    """
    links, tool = shadows(item, q)
    at, frame = Pose(float(tool[0]), float(tool[1]), 0.0), f"robot/{robot}"
    for link in links:
        yield PlanItem(role="link", parts=(link_outline(link),), place=place, of=robot, frame=frame, tint=item.color)
    sign = (circle(0.5),)
    yield PlanItem(role="tool", parts=sign, symbol=True, place=place @ at, of=robot, frame=frame, frame_from_shape=at)


def shadows(item: RobotArm, q: Array) -> tuple[Array, Array]:
    """Return the links of an arm seen from above, the lowest first, and its tool, in the robot's frame.

    Args:
        item: The arm.
        q: Joint values, shape (n,) [rad, m].

    Returns:
        links: Both ends and radius of each, (x, y, x, y, radius), shape (n, 5) [m].
        tool: Position, shape (2,) [m].
    """
    posture = item.arm.posture(q)
    bones = np.array([[[*end, 1.0] for end in link.bone] for link in item.arm.links])
    ends = (posture.links[:, None] @ bones[..., None])[..., :3, 0]
    order = np.argsort(ends[..., 2].mean(axis=1), kind="stable")
    radii = np.array([[link.radius] for link in item.arm.links])
    flat = np.concatenate([ends[:, 0, :2], ends[:, 1, :2], radii], axis=1)
    return flat[order], posture.tool[:2, 3]


def link_outline(link: Array) -> Array:
    """Return the outline of a link (x, y, x, y, radius), counter-clockwise, shape (n, 2) [m]."""
    first, last, radius = link[:2], link[2:4], float(link[4])
    angle = math.atan2(*(last - first)[::-1])
    right = angle - math.pi / 2
    return np.concatenate(
        [arc(last, radius, right, right + math.pi), arc(first, radius, right + math.pi, angle + 1.5 * math.pi)]
    )


def arm_outlines(item: RobotArm, q: Array) -> list[Array]:
    """Return the outlines of an arm's links from above, lowest first, in the robot's frame, shape (n, 2) each [m]."""
    return [link_outline(link) for link in shadows(item, q)[0]]


def beacon_shapes(item: Hung) -> Iterator[PlanItem]:
    """Yield a beacon as a line of its width with a tick in the direction that it faces; a marker is hollow.

    A reflector is a ring, a radio anchor a diamond.
    """
    beacon, carrier = item.beacon, item.carrier
    prefix = "robot" if isinstance(carrier, Robot) else "obstacle"
    frame = "" if item.fixed or carrier is None else f"{prefix}/{carrier.name}"
    local = Pose(beacon.at[0], beacon.at[1], math.radians(beacon.heading_deg))
    face = np.array([[0.0, -beacon.width / 2], [0.0, beacon.width / 2]])
    plate = PlanItem(
        role="beacon", kind="line", parts=(face,), least=0.6, ahead=0.3, of=beacon.name, frame=frame,
        place=item.place, frame_from_shape=local,
    )  # fmt: skip
    sign = replace(plate, role="reflector", kind="area", parts=(circle(0.7),), symbol=True, least=0.0, ahead=0.0)
    if not beacon.has_face:
        yield replace(sign, parts=(circle(0.8, 4),)) if beacon.anchor else sign
        return
    yield replace(sign, role="tick", kind="line", parts=(np.array([[0.3, 0.0], [1.4, 0.0]]),))
    yield plate
    if beacon.marker is not None:
        yield replace(plate, role="marker")


def arc(middle: "Array | tuple[float, float]", radius: float, first: float, last: float) -> Array:
    """Return points of an arc between two angles [rad], counter-clockwise from x, shape (n, 2), in the unit given."""
    angles = np.linspace(first, last, max(2, math.ceil(abs(last - first) / 0.1)))
    return np.asarray(middle, dtype=float) + radius * np.stack([np.cos(angles), np.sin(angles)], axis=-1)


def circle(radius: float, sides: int = 24) -> Array:
    """Return the corners of a circle about the origin, shape (sides, 2), in the unit of the radius."""
    angles = np.arange(sides) * (2.0 * np.pi / sides)
    return radius * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
