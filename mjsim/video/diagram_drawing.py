"""Draws mechanisms as kinematic diagrams: bodies, joint symbols, constraints and actuators."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.plan import Words, arc, blend, parse_color
from mjsim.video.ink import ESTIMATE, INK, PAPER
from mjsim.video.joint_symbols import draw_ground, draw_joint, draw_sliding, draw_turning
from mjsim.video.paper import Paper
from mjsim.world import GROUND, ForceActuator, Mechanism, MechanismJoint, TorqueActuator, place_of

ABOVE = np.eye(4)[:3]
"""The view of a plan: x to the right, y up, z towards the viewer."""
END_ON = 0.9
"""The view is along an axis if the cosine of the angle between them is larger."""
CIRCLE_CORNERS = 32
"""Number of corners of a circle."""


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """A mechanism in one posture, seen from a direction."""

    mechanism: Mechanism
    look: Array
    """drawing_from_world: right, up, towards the viewer, shape (3, 4) [m]."""
    poses: dict[str, Array]
    """world_from_body by name, including the ground, shape (4, 4) each [m]."""
    axes: Array
    """Axis of each value, world frame, shape (values, 3)."""

    def points(self, body: str, points: Array) -> Array:
        """Return points of a body, shape (..., 3) [m], in the drawing, shape (..., 3) [m]."""
        pose = self.look @ self.poses[body]
        return np.asarray(np.asarray(points) @ pose[:, :3].T + pose[:, 3])

    def joint(self, joint: MechanismJoint) -> Array:
        """Return the position of a joint in the drawing, on the body that it carries, shape (3,) [m]."""
        second = self.mechanism.assembly.places[joint.name][1]
        return self.points(second.body, np.array(second.at))

    def axis(self, joint: MechanismJoint) -> Array:
        """Return the axis of a joint in the drawing, shape (3,); for a planar joint, the normal of its plane."""
        columns = self.mechanism.assembly.columns[joint.name]
        if not len(columns):
            return np.array([1.0, 0.0, 0.0])
        axis = self.axes[columns.start]
        if joint.kind in ("planar", "in_plane"):
            axis = np.cross(axis, self.axes[columns.start + 1])
        return np.asarray(self.look[:, :3] @ axis)


def posed(mechanism: Mechanism, values: Array, drawing_from_world: Array = ABOVE) -> Drawn:
    """Return a mechanism prepared for drawing.

    Args:
        mechanism: The mechanism.
        values: Joint values, shape (values,) [rad, m].
        drawing_from_world: The view, as `Drawn.look`.
    """
    placed = mechanism.assembly.linkage.place(values)
    ground = mechanism.world_from_ground
    poses = {name: ground @ placed.poses[k] for k, name in enumerate(mechanism.assembly.bodies) if name}
    return Drawn(mechanism, drawing_from_world, poses, placed.axes @ ground[:3, :3].T)


def draw_mechanism(drawing: Paper, drawn: Drawn) -> None:
    """Draw a mechanism: bodies from farthest to nearest, then lines between joints, then symbols."""
    for name, outline in body_outlines(drawn):
        color = parse_color(drawn.mechanism.body(name).color)
        drawing.fill(outline, blend(color, PAPER, 0.6))
        drawing.line(outline, blend(color, INK, 0.25), 0.15, closed=True)
    for link in _links(drawn):
        drawing.line(link, INK, 0.3, closed=len(link) > 2)
    for ends in _ties(drawn):
        drawing.dashes(ends, INK, 0.2, dash=1.0)
    for joint in drawn.mechanism.joints:
        x, y, _ = drawn.joint(joint).tolist()
        if any(place.body == GROUND for place in drawn.mechanism.assembly.places[joint.name]):
            draw_ground(drawing, Pose(x, y, 0.0))
    # Bodies welded at a hinge must not hide it.
    for joint in sorted(drawn.mechanism.joints, key=lambda each: each.kind != "weld"):
        place, along = _placed(drawn, joint)
        draw_joint(drawing, joint.kind, place, along=along)
    _draw_actuators(drawing, drawn)


def body_outlines(drawn: Drawn) -> Iterator[tuple[str, Array]]:
    """Yield the outline of each body in the drawing, shape (n, 2) [m], farthest first."""
    found = []
    ring = np.stack([np.cos(turns := np.arange(CIRCLE_CORNERS) * 2.0 * np.pi / CIRCLE_CORNERS), np.sin(turns)], axis=-1)
    for body in drawn.mechanism.bodies:
        points, radius = body.hull()
        seen = drawn.points(body.name, points)
        flat = (seen[:, None, :2] + radius * ring if radius else seen[:, None, :2]).reshape(-1, 2)
        hull = cv2.convexHull(flat.astype(np.float32))[:, 0].astype(float)
        found.append((float(seen[:, 2].mean()), body.name, hull))
    for _, name, hull in sorted(found, key=lambda each: each[0]):
        yield name, hull


def _placed(drawn: Drawn, joint: MechanismJoint) -> tuple[Pose, bool]:
    """Return position and axis direction of a joint in the drawing, and whether the view is along the axis."""
    x, y, _ = drawn.joint(joint).tolist()
    right, up, toward = drawn.axis(joint).tolist()
    along = abs(toward) > END_ON
    return Pose(x, y, 0.0 if along else math.atan2(up, right)), along


def _links(drawn: Drawn) -> Iterator[Array]:
    """Yield for each body the line between its joints, a polygon for more than two; shape (n, 2) [m]."""
    ends: dict[str, list[Array]] = {body.name: [] for body in drawn.mechanism.bodies}
    for joint in drawn.mechanism.joints:
        for place in drawn.mechanism.assembly.places[joint.name]:
            if place.body != GROUND:
                ends[place.body].append(drawn.points(place.body, np.array(place.at))[:2])
    for name, points in ends.items():
        if len(points) == 1 and (end := drawn.mechanism.body(name).points().get("end")) is not None:
            points.append(drawn.points(name, np.array(end))[:2])
        hull = cv2.convexHull(np.array(points, dtype=np.float32))[:, 0].astype(float)
        if len(hull) > 1:
            yield hull


def _ties(drawn: Drawn) -> Iterator[Array]:
    """Yield lines for constraints: massless rods, pitch circles of gears, lines between other coupled joints."""
    assembly = drawn.mechanism.assembly
    yield from distances(drawn, led=False)
    owners = {column: name for name, columns in assembly.columns.items() for column in columns}
    yield from curves(drawn)
    for each in assembly.couplings:
        first, second = (drawn.mechanism.joint(owners[column]) for column in (each.first, each.second))
        if first is second:
            continue
        places = [_placed(drawn, joint) for joint in (first, second)]
        middles = np.array([[place.x, place.y] for place, _ in places])
        distance = float(np.hypot(*(middles[1] - middles[0])))
        if all(along for _, along in places) and not (assembly.slides[each.first] or assembly.slides[each.second]):
            # Radii are inversely proportional to rotations; wheels that turn in the same direction are inside each
            # other.
            share = 1.0 + abs(each.ratio) if each.ratio < 0 else abs(abs(each.ratio) - 1.0)
            radius = distance / max(share, 1e-9)
            for middle, size in zip(middles, (radius, radius * abs(each.ratio)), strict=True):
                yield arc(middle, size, 0.0, 2.0 * math.pi)
        else:
            yield middles


def curves(drawn: Drawn) -> Iterator[Array]:
    """Yield the curves along which points slide, shape (n, 2) [m]."""
    assembly = drawn.mechanism.assembly
    for track in assembly.tracks:
        joint = assembly.linkage.joints[track.ghost - 1]
        curve = joint.primitives[0].curve
        if curve is not None:
            points = curve.sampled(3 * CIRCLE_CORNERS) @ joint.before[:3, :3].T + joint.before[:3, 3]
            yield drawn.points(assembly.bodies[joint.parent], points)[:, :2]


def distances(drawn: Drawn, *, led: bool) -> Iterator[Array]:
    """Yield the ends of distances, shape (2, 2) [m]: those prescribed by motions, or rods and springs."""
    assembly = drawn.mechanism.assembly
    passive = [rod.ends for rod in assembly.rods] + [spring.ends for spring in assembly.springs]
    moved = [drive.ends for drive in assembly.drives if drive.ends]
    for ends in moved if led else passive:
        yield np.array([drawn.points(assembly.bodies[spot.body], spot.at)[:2] for spot in ends])


def _draw_actuators(drawing: Paper, drawn: Drawn) -> None:
    """Draw an arrow for each actuator: about or along its joint, or along the force on a body."""
    mechanism, assembly = drawn.mechanism, drawn.mechanism.assembly
    for ends in distances(drawn, led=True):
        drawing.line(ends, ESTIMATE, 0.5)
    for actuator in mechanism.actuators:
        name = actuator.target.partition(".")[0]
        if name in assembly.columns:
            place, _ = _placed(drawn, mechanism.joint(name))
            slides = assembly.slides[assembly.column(actuator.target)]
            (draw_sliding if slides else draw_turning)(drawing, place)
        elif isinstance(actuator, TorqueActuator | ForceActuator):
            _draw_push(drawing, drawn, actuator)


def _draw_push(drawing: Paper, drawn: Drawn, actuator: TorqueActuator | ForceActuator) -> None:
    """Draw the arrow of a torque or a force on a body."""
    end = place_of(actuator.target, {body.name: body.points() for body in drawn.mechanism.bodies})
    x, y, _ = drawn.points(end.body, np.array(end.at)).tolist()
    axis = drawn.mechanism.world_from_ground[:3, :3] @ np.array(actuator.axis)
    right, up, _ = (drawn.look[:, :3] @ axis).tolist()
    place = Pose(x, y, math.atan2(up, right))
    drawing.arrow(place.transform([[0.0, 0.0], [drawing.metres(5.0), 0.0]]), ESTIMATE, 0.4)


def joint_words(drawn: Drawn) -> list[Words]:
    """Return the names of joints and bodies, to be written beside them."""
    side = np.array([0.7, 0.7])
    joints = [
        Words(text=joint.name, at=drawn.joint(joint)[:2], side=side, gap=1.6, ink="ink")
        for joint in drawn.mechanism.joints
    ]
    bodies = [
        Words(text=name, at=(hull.min(axis=0) + hull.max(axis=0)) / 2, side=np.array([0.0, -1.0]), gap=1.0)
        for name, hull in body_outlines(drawn)
    ]
    return joints + bodies
