"""Writes worlds as SDF for Gazebo: walls, obstacles, people, doors on hinges, beacons with their images, lamps.

Robots are left out: Gazebo has its own drives and sensors.
"""

import math
from collections.abc import Sequence
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np

from mjsim.exchange.beacon_images import BeaconFace, shown_of
from mjsim.exchange.sdf_parts import Appearance, add_box, add_geometry, add_link, add_prism, numbers, pose_of
from mjsim.geometry import Array
from mjsim.output import write_files
from mjsim.posture import columns_of
from mjsim.world import (
    THICKNESS,
    BoxObstacle,
    CylinderObstacle,
    Hung,
    Leaf,
    ModelObstacle,
    Obstacle,
    Person,
    RampObstacle,
    SphereObstacle,
    StepsObstacle,
    Wall,
    World,
    hung,
    item_names,
    leaves,
    prisms,
    solid_pieces,
    world_from_obstacle,
)

VERSION = "1.9"
MARGIN = 10.0
"""Margin of the floor around everything [m]."""
CEILING_THICKNESS = 0.05
"""Thickness of a ceiling [m]."""
LEAF_GAP = 0.006
"""Gap around a door leaf [m]."""
HINGE_DAMPING = 0.6
"""Damping of a hinge, as a fraction of the leaf's inertia [1/s]."""


def write_sdf(world: World, path: str | Path, *, overwrite: bool = False) -> Path:
    """Write a world as SDF 1.9, with its images in a folder beside it; return the path of the file.

    Walls are boxes; ramps, models from files and the segments of people are prisms on their outlines. A moving obstacle
    stands at the start of its path. Robots and the beacons on them are left out.

    Args:
        world: The world.
        path: Output file; images go into `NAME_pictures` beside it.
        overwrite: Whether existing files may be replaced.

    Raises:
        UsageError: A file exists, or cannot be written.
    """
    path = Path(path)
    root = Element("sdf", version=VERSION)
    place = SubElement(root, "world", name=world.name)
    pictures: dict[str, bytes] = {}
    _add_sky(place, world)
    _add_ground(place, world)
    for wall, name, pieces in zip(world.walls, item_names(world.walls), solid_pieces(world.walls), strict=True):
        _add_wall(place, wall, name, [(piece.outline, piece.low, piece.high) for piece in pieces])
    for obstacle, name in zip(world.obstacles, item_names(world.obstacles), strict=True):
        _add_obstacle(place, obstacle, f"obstacle_{name}")
    for leaf in leaves(world):
        _add_door(place, leaf)
    for person in world.people:
        _add_person(place, world, person)
    folder = f"{path.stem}_pictures"
    for item in hung(world):
        if item.carrier is None or item.carrier not in world.robots:
            shown = shown_of(world, item.beacon)
            pictures[shown.file] = shown.png
            _add_beacon(place, item, shown, f"{folder}/{shown.file}")
    indent(root)
    files = {f"{folder}/{file}": data for file, data in pictures.items()}
    text = tostring(root, encoding="utf-8", xml_declaration=True)
    write_files(path.parent, files | {path.name: text}, overwrite=overwrite)
    return path


def _add_sky(place: Element, world: World) -> None:
    """Add physics, the ambient light and the lamps."""
    physics = SubElement(place, "physics", name="default", type="ignored")
    SubElement(physics, "max_step_size").text = "0.004"
    SubElement(physics, "real_time_factor").text = "1"
    scene = SubElement(place, "scene")
    SubElement(scene, "ambient").text = numbers(*[0.6 * world.light] * 3, 1)
    SubElement(scene, "background").text = numbers(0.7, 0.8, 0.9, 1)
    SubElement(scene, "shadows").text = "false"
    sun = SubElement(place, "light", name="general_light", type="directional")
    SubElement(sun, "pose").text = numbers(0, 0, 10, 0, 0, 0)
    SubElement(sun, "diffuse").text = numbers(*[min(1.0, 0.6 * world.light)] * 3, 1)
    SubElement(sun, "direction").text = numbers(0.3, 0.2, -1)
    for lamp, name in zip(world.lamps, item_names(world.lamps), strict=True):
        point = SubElement(place, "light", name=f"lamp_{name}", type="point")
        SubElement(point, "pose").text = numbers(*lamp.at, lamp.height, 0, 0, 0)
        color = [int(lamp.color[at : at + 2], 16) / 255 * min(1.0, lamp.brightness) for at in (1, 3, 5)]
        SubElement(point, "diffuse").text = numbers(*color, 1)
        fading = SubElement(point, "attenuation")
        SubElement(fading, "range").text = numbers(lamp.range)
        SubElement(fading, "quadratic").text = "0.25"


def _add_ground(place: Element, world: World) -> None:
    corners = [corner for wall in world.walls for corner in wall.points]
    corners += [obstacle.at for obstacle in world.obstacles] + [robot.at for robot in world.robots] or [(0.0, 0.0)]
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    middle, size = ((low + high) / 2).tolist(), (high - low + 2 * MARGIN).tolist()
    link = add_link(place, "floor", at=(*middle, 0.0))
    plane = [("normal", numbers(0, 0, 1)), ("size", numbers(*size))]
    add_geometry(link, "floor", "plane", plane, appearance=Appearance(world.floor.color, world.floor.friction))
    if world.ceiling is not None:
        height = world.ceiling.height or max((wall.height for wall in world.walls), default=2.5)
        above = add_link(place, "ceiling", at=(*middle, height + CEILING_THICKNESS / 2))
        add_box(
            above, "ceiling", [*(high - low).tolist(), CEILING_THICKNESS], appearance=Appearance(world.ceiling.color)
        )


def _add_wall(place: Element, wall: Wall, name: str, pieces: Sequence[tuple[Array, float, float]]) -> None:
    if not pieces:
        return
    link = add_link(place, f"wall_{name}")
    for number, (outline, low, high) in enumerate(pieces):
        box, at = _box_around(outline, low, high)
        add_box(link, f"part_{number}", box, at=at, appearance=Appearance(wall.color))


def _box_around(outline: Array, low: float, high: float) -> tuple[list[float], tuple[float, ...]]:
    """Return the bounding box of a piece of a wall: its sizes [m], and x, y, z [m], roll, pitch, yaw [rad].

    At a mitre the box extends into the other wall up to the outer tip, so that it adds nothing outside the two walls.
    """
    along = outline[1] - outline[0] if math.dist(*outline[:2]) > 1e-9 else outline[2] - outline[3]
    heading = math.atan2(along[1], along[0])
    c, s = math.cos(heading), math.sin(heading)
    turned = outline @ [[c, -s], [s, c]]
    least, greatest = turned.min(axis=0), turned.max(axis=0)
    x, y = ((least + greatest) / 2 @ [[c, s], [-s, c]]).tolist()
    return [*(greatest - least).tolist(), high - low], (x, y, (low + high) / 2, 0.0, 0.0, heading)


def _add_person(place: Element, world: World, person: Person) -> None:
    """Add a person as vertical prisms, one per segment."""
    link = add_link(place, f"person_{person.name}")
    for segment, (outline, low, high) in columns_of(world, person).items():
        add_prism(link, segment, outline, high - low, at=(0, 0, low), appearance=Appearance(person.color_of(segment)))


def _add_obstacle(place: Element, obstacle: Obstacle, name: str) -> None:
    pose = world_from_obstacle(obstacle)
    mass = obstacle.mass if obstacle.movable else None
    friction = obstacle.friction if obstacle.movable else None
    at = (pose.x, pose.y, obstacle.elevation, 0.0, 0.0, pose.heading)
    link = add_link(place, name, at=at, mass=mass, size=_extent(obstacle))
    appearance = Appearance(obstacle.color, friction)
    match obstacle:
        case BoxObstacle(box=(length, width, height)):
            add_box(link, "box", [length, width, height], at=(0, 0, height / 2), appearance=appearance)
        case CylinderObstacle(cylinder=(radius, height)):
            sizes = [("radius", numbers(radius)), ("length", numbers(height))]
            add_geometry(link, "cylinder", "cylinder", sizes, at=(0, 0, height / 2), appearance=appearance)
        case SphereObstacle(sphere=radius):
            add_geometry(
                link, "sphere", "sphere", [("radius", numbers(radius))], at=(0, 0, radius), appearance=appearance
            )
        case RampObstacle(ramp=(length, width, rise)):
            profile = np.array([[-length / 2, 0.0], [length / 2, 0.0], [length / 2, rise]])
            # A right angle about x turns what pointed up to -y.
            add_prism(link, "ramp", profile, width, at=(0, width / 2, 0, math.pi / 2, 0, 0), appearance=appearance)
        case StepsObstacle(steps=(length, width, rise), count=count):
            for step in range(count):
                depth, high = length * (count - step) / count, rise * (step + 1) / count
                middle = (length - depth) / 2
                add_box(link, f"step_{step}", [depth, width, high], at=(middle, 0, high / 2), appearance=appearance)
        case ModelObstacle():
            inverse = pose.inverse()
            for number, (outline, low, high) in enumerate(prisms(obstacle)):
                lift = low - obstacle.elevation
                add_prism(
                    link,
                    f"part_{number}",
                    inverse.transform(outline),
                    high - low,
                    at=(0, 0, lift),
                    appearance=appearance,
                )


def _extent(obstacle: Obstacle) -> list[float]:
    """Return the sizes of an obstacle's bounding box, in its frame [m]; its inertia is approximated as the box's."""
    parts = prisms(obstacle)
    inverse = world_from_obstacle(obstacle).inverse()
    points = np.concatenate([inverse.transform(outline) for outline, _, _ in parts])
    low, high = min(part[1] for part in parts), max(part[2] for part in parts)
    return [*np.ptp(points, axis=0).tolist(), high - low]


def _add_door(place: Element, leaf: Leaf) -> None:
    """Add a door leaf in its start position; its joint is 0 there, and positive towards the left side of its wall."""
    pose = leaf.pose(math.radians(leaf.door.angle_deg))
    size = [leaf.width - 2 * LEAF_GAP, THICKNESS, leaf.high - leaf.low - 2 * LEAF_GAP]
    middle = (leaf.width / 2, 0.0, (leaf.low + leaf.high) / 2)
    at = (pose.x, pose.y, 0.0, 0.0, 0.0, pose.heading)
    link = add_link(place, f"door_{leaf.name}", at=at, mass=leaf.door.mass, size=size, center=middle)
    add_box(link, "leaf", size, at=middle, appearance=Appearance(leaf.door.color))
    model = place[-1]
    kind = "fixed" if leaf.door.locked else "revolute"
    joint = SubElement(model, "joint", name="hinge", type=kind)
    SubElement(joint, "parent").text = "world"
    SubElement(joint, "child").text = "link"
    if leaf.door.locked:
        return
    axis = SubElement(joint, "axis")
    SubElement(axis, "xyz").text = numbers(0, 0, leaf.turn)
    limit = SubElement(axis, "limit")
    SubElement(limit, "lower").text = numbers(math.radians(-leaf.door.limit_deg - leaf.door.angle_deg))
    SubElement(limit, "upper").text = numbers(math.radians(leaf.door.limit_deg - leaf.door.angle_deg))
    dynamics = SubElement(axis, "dynamics")
    SubElement(dynamics, "damping").text = numbers(HINGE_DAMPING * leaf.door.mass * leaf.width**2 / 3)
    SubElement(dynamics, "spring_reference").text = numbers(math.radians(-leaf.door.angle_deg))
    SubElement(dynamics, "spring_stiffness").text = numbers(leaf.door.spring)


def _add_beacon(place: Element, item: Hung, shown: BeaconFace, file: str) -> None:
    """Add a plane with x to the viewer's right, y up, and z towards the viewer."""
    tilt, heading = math.radians(item.beacon.tilt_deg), item.place.heading
    out = np.array([math.cos(tilt) * math.cos(heading), math.cos(tilt) * math.sin(heading), math.sin(tilt)])
    right = np.array([-math.sin(heading), math.cos(heading), 0.0])
    frame = np.column_stack([right, np.cross(out, right), out])
    at = pose_of(np.array([item.place.x, item.place.y, item.center]), frame)
    link = add_link(place, f"beacon_{item.beacon.name}", at=at)
    plane = [("normal", numbers(0, 0, 1)), ("size", numbers(*shown.size))]
    add_geometry(link, "picture", "plane", plane, appearance=Appearance("#ffffff", picture=file), collides=False)
