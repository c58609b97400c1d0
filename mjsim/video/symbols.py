"""Symbols on a sheet of paper: walls in architectural style, doors with their swing, and so on."""

import itertools
import math

import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.video.ink import BEACON, INK, MUTED, PAPER, SEEN, TRUTH, WALL, Color, blend, parse_color
from mjsim.video.paper import Paper, arc
from mjsim.world import (
    Beacon,
    FloorPatch,
    Lamp,
    Leaf,
    Obstacle,
    OpenEvent,
    Opening,
    RampObstacle,
    Robot,
    StepsObstacle,
    Wall,
    World,
    footprint,
    top,
    wall_pieces,
)

CUT = 1.0
"""Height of the section of an architectural plan [m]: through windows and doors, above tables and benches."""
LAMP: Color = (214, 158, 0)
LOW = blend(WALL, PAPER, 0.78)
"""Colour of what ends below the section."""
LEAST_ROBOT = 1.0
"""Minimum radius of a drawn robot [mm]."""
SWING = 90.0
"""Angle of the swing arc of a closed door [deg]."""


def draw_patch(drawing: Paper, patch: FloorPatch) -> None:
    """Draw a floor patch as a pale area with a fine border."""
    outline, color = patch.outline(), parse_color(patch.color)
    drawing.fill(outline, blend(color, PAPER, 0.72))
    drawing.dashes(np.vstack([outline, outline[:1]]), blend(color, PAPER, 0.3), 0.15)


def draw_low_wall(drawing: Paper, wall: Wall) -> None:
    """Draw the parts of a wall that end below `CUT`, pale: low walls, and parts below windows."""
    pieces = [piece.outline for piece in wall_pieces(wall) if piece.high <= CUT]
    for outline in pieces:
        drawing.line(outline, WALL, 0.35, closed=True)
    for outline in pieces:
        drawing.fill(outline, LOW)  # over the inner half of the lines: no seams where pieces meet


def draw_wall(drawing: Paper, wall: Wall) -> None:
    """Draw the section of a wall at `CUT`, solid, and the panes of its windows."""
    for piece in wall_pieces(wall):
        if piece.low <= CUT < piece.high:
            drawing.fill(piece.outline, WALL)
            drawing.line(piece.outline, WALL, 0.1, closed=True)  # so that the thinnest wall is visible
    for opening in wall.openings:
        if opening.sill > 0.0:
            start, along = _opening_frame(wall, opening)
            drawing.line([start, start + along * opening.width], TRUTH, 0.2)


def draw_door(drawing: Paper, leaf: Leaf, *, opens_to: float) -> None:
    """Draw a door's leaf in its initial position, and the arc of its swing to an angle [deg]."""
    path, stands = leaf_path(leaf, opens_to), leaf_path(leaf, leaf.door.angle_deg)
    drawing.line(path, MUTED, 0.12)
    drawing.line(np.stack([leaf.hinge, path[-1]]), MUTED, 0.12)
    drawing.line(np.stack([leaf.hinge, stands[-1]]), blend(parse_color(leaf.door.color), INK, 0.25), 0.5)


def leaf_path(leaf: Leaf, angle_deg: float) -> Array:
    """Return the path of a leaf's free edge from closed to an angle, world frame, shape (n, 2) [m]."""
    return arc(leaf.hinge, leaf.width, leaf.closed, leaf.closed + leaf.turn * math.radians(angle_deg))


def _opening_frame(wall: Wall, opening: Opening) -> tuple[Array, Array]:
    """Return the start of an opening on the centreline [m], and the unit vector along it, world frame, (2,) each."""
    first, last = (np.array(end) for end in wall.segments()[opening.segment])
    along = (last - first) / np.hypot(*(last - first))
    return first + along * opening.at, along


def swing(world: World, leaf: Leaf) -> float:
    """Return the drawn swing of a door [deg]: to which an event opens it, its initial angle, or a right angle."""
    opened = [event for event in world.run.events if isinstance(event, OpenEvent) and event.open == leaf.name]
    if opened:
        return max((event.angle_deg for event in opened), key=abs)
    standing = leaf.door.angle_deg
    return standing if abs(standing) > SWING else math.copysign(SWING, standing)


def draw_obstacle(drawing: Paper, obstacle: Obstacle) -> None:
    """Draw an obstacle in a muted version of its colour.

    Ramps and steps have an arrow up; movable objects have a dashed edge, those hanging above the section a fine one.
    """
    outline, color = footprint(obstacle), parse_color(obstacle.color)
    edge = blend(color, INK, 0.45)
    if obstacle.elevation <= CUT:
        drawing.fill(outline, blend(color, PAPER, 0.7 if top(obstacle) < CUT else 0.5))
    ring = np.vstack([outline, outline[:1]])
    if obstacle.elevation > CUT:
        drawing.dashes(ring, blend(edge, PAPER, 0.3), 0.12, dash=0.8)
    elif obstacle.movable or obstacle.path is not None:
        drawing.dashes(ring, edge, 0.3)
    else:
        drawing.line(ring, edge, 0.2)
    if isinstance(obstacle, StepsObstacle):
        _draw_treads(drawing, obstacle, edge)
    if isinstance(obstacle, (RampObstacle, StepsObstacle)):
        length = (obstacle.ramp if isinstance(obstacle, RampObstacle) else obstacle.steps)[0]
        place = Pose(obstacle.at[0], obstacle.at[1], math.radians(obstacle.heading_deg))
        drawing.arrow(place.transform([[-0.42 * length, 0.0], [0.42 * length, 0.0]]), edge)


def _draw_treads(drawing: Paper, steps: StepsObstacle, color: Color) -> None:
    length, width, _ = steps.steps
    place = Pose(steps.at[0], steps.at[1], math.radians(steps.heading_deg))
    for number in range(1, steps.count):
        x = length * (number / steps.count - 0.5)
        drawing.line(place.transform([[x, -width / 2], [x, width / 2]]), color, 0.15)


def draw_path(drawing: Paper, obstacle: Obstacle) -> None:
    """Draw the path of a scripted object: dots, and an arrow on each straight leg."""
    if obstacle.path is None:
        return
    points = np.array([obstacle.at, *obstacle.path.points, *([obstacle.at] if obstacle.path.closed else [])])
    drawing.dashes(points, SEEN, 0.35, dash=0.7)
    for start, end in itertools.pairwise(points):
        length = np.hypot(*(end - start))
        if length > drawing.metres(6.0):
            middle, along = (start + end) / 2, (end - start) / length
            reach = along * drawing.metres(0.8)
            drawing.arrow(np.stack([middle - reach, middle + reach]), SEEN)


def draw_beacon(drawing: Paper, beacon: Beacon, place: Pose) -> None:
    """Draw a beacon as a line of its width with a tick in the direction that it faces; a reflector is a ring."""
    half = max(beacon.width / 2, drawing.metres(0.6))
    ahead, depth = drawing.metres(1.3), drawing.metres(0.35)
    if not beacon.has_face:
        drawing.disc((place.x, place.y), drawing.metres(0.7), PAPER)
        drawing.disc((place.x, place.y), drawing.metres(0.7), SEEN if beacon.anchor else TRUTH, thickness=0.3)
        return
    color = BEACON if beacon.image is not None else SEEN
    drawing.line(place.transform([[depth, 0.0], [ahead, 0.0]]), color, 0.35)
    drawing.fill(place.transform([[0.0, -half], [2 * depth, -half], [2 * depth, half], [0.0, half]]), color)


def draw_lamp(drawing: Paper, lamp: Lamp) -> None:
    """Draw a lamp as a small sun; a lamp that is off is hollow."""
    middle, radius = np.array(lamp.at), drawing.metres(0.8)
    for angle in np.arange(8) * (np.pi / 4):
        ray = np.array([math.cos(angle), math.sin(angle)])
        drawing.line(np.stack([middle + 1.5 * radius * ray, middle + 2.2 * radius * ray]), LAMP, 0.2)
    drawing.disc(middle, radius, LAMP if lamp.brightness > 0 else PAPER)
    drawing.disc(middle, radius, LAMP, thickness=0.2)


def draw_robot(drawing: Paper, robot: Robot) -> None:
    """Draw a robot at its initial pose, with an arrow in its forward direction."""
    least, color = drawing.metres(LEAST_ROBOT), blend(parse_color(robot.body.color), PAPER, 0.5)
    place = Pose(robot.at[0], robot.at[1], math.radians(robot.heading_deg))
    outline = robot.body.outline() * max(1.0, least / robot.body.radius)
    drawing.fill(place.transform(outline), color)
    drawing.line(place.transform(outline), INK, 0.3, closed=True)
    drawing.arrow(place.transform([[0.0, 0.0], [np.max(outline[:, 0]) + drawing.metres(2.4), 0.0]]), INK, 0.4)
