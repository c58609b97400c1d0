"""Joints for the page: their motion, the outlines of their bodies from above, and the points by which to drag them."""

import math
from collections.abc import Iterator, Mapping
from typing import cast

import numpy as np

from mjsim.geometry import Array, Pose, Pose3
from mjsim.mechanics import JointMotion, inverted, jacobian
from mjsim.plan import arm_outlines
from mjsim.video import body_outlines, posed
from mjsim.web.run.history import plain
from mjsim.web.run.joint_news import BallFrame, CurveFrame, JointFacts, JointGrip, JointRow
from mjsim.world import BalancingDrive, Mechanism, Robot, RobotArm, World, led_joints

START_TOLERANCE = 1e-4
"""A mechanism whose joints are within this of their start values counts as at the start [rad, m]."""
MIN_HANDLE_DISTANCE, MAX_HANDLE_DISTANCE = 0.1, 0.3
"""Distance from an arm joint to its handle: half the distance to what it moves, within these limits [m]."""
SAME_LEVER = 1e-6
"""Points whose distances from an axis differ by less are equally far from it [m]."""
NO_LEVER = 0.02
"""Points closer to an axis than this do not show the direction of rotation [m]."""
LOOP_SHARE, CUT_SHARE = 0.5, 0.25
"""Distance from a loop's joint to its handle, as a fraction of that to the farthest point; the second where it is
cut."""
STILL_RATIO = 1e-6
"""Relative motion of a value below which it stands still while others move."""
DERIVATIVE_STEP = 1e-5
"""Change of a value for the derivative of a handle's position [rad, m]."""
CURVE_PIECES = 72
"""Number of pieces of a curve along which a point is dragged."""
Values = Mapping[str, Array]
"""Joint values by `ROBOT/ARM` or mechanism, shape (n,) each [rad, m]."""


def joints_json(world: World) -> dict[str, list[JointFacts]]:
    """Return the joints of arms by `ROBOT/ARM`, of balancing bases by `ROBOT/drive`, and of mechanisms by name."""
    facts: dict[str, list[JointFacts]] = {}
    for robot in world.robots:
        facts |= {f"{robot.name}/{item.name}": arm_facts(item) for item in robot.arms}
        if isinstance(robot.drive, BalancingDrive):
            wheels = robot.drive.driven_wheels
            facts[f"{robot.name}/drive"] = [_facts(name, False, -math.inf, math.inf) for name in wheels]
    for mechanism in world.mechanisms:
        found, led = mechanism.assembly, {each["name"]: each for each in led_facts(mechanism)}
        facts[mechanism.name] = [
            led.get(name) or _facts(name, bool(slides), -math.inf, math.inf)
            for name, slides in zip(found.names, found.slides, strict=True)
        ]
    return facts


def arm_facts(item: RobotArm) -> list[JointFacts]:
    """Return the joints of an arm."""
    links = enumerate(item.arm.links, start=1)
    return [_facts(f"joint{number}", link.slide, link.lower, link.upper) for number, link in links]


def led_facts(mechanism: Mechanism) -> list[JointFacts]:
    """Return the joints of a mechanism that can be led."""
    facts = {name: _facts(name, *each) for name, each in led_joints(mechanism).items()}
    for name in mechanism.held & facts.keys():
        facts[name]["held"] = True
    for track in mechanism.assembly.tracks:
        curve = track.curve(mechanism.assembly.linkage)
        if curve.closed and track.name in facts:
            facts[track.name]["period"] = curve.length
    return list(facts.values())


def _facts(name: str, slides: bool, lower: float, upper: float) -> JointFacts:
    bounds = (bound if math.isfinite(bound) else None for bound in (lower, upper))
    return {"name": name, "slides": slides, "lower": next(bounds), "upper": next(bounds)}


def joint_rows_json(motions: Mapping[str, JointMotion]) -> dict[str, dict[str, JointRow]]:
    """Return the motion of joints in JSON form."""
    return {
        name: joint_rows(motion.names, motion.positions, motion.velocities, motion.torques)
        for name, motion in motions.items()
    }


def joint_rows(names: tuple[str, ...], positions: Array, velocities: Array, torques: Array) -> dict[str, JointRow]:
    """Return the motion of some joints in JSON form; each array has shape (n,)."""
    rows = plain(np.column_stack([positions, velocities, torques]), 5)
    return {name: cast(JointRow, tuple(row)) for name, row in zip(names, rows, strict=True)}


def drawn_bodies(world: World, values: Values, places: Mapping[str, Pose]) -> dict[str, list[Array]]:
    """Return outlines from above of arms, and of mechanisms away from their start values, the lowest part first.

    Args:
        world: The world that contains them.
        values: Joint values; bodies with unknown ones are left out.
        places: Poses of the robots.

    Returns:
        Outlines by `ROBOT/ARM` or mechanism, world frame, shape (n, 2) each [m].
    """
    known = {name: each for name, each in values.items() if np.isfinite(each).all()}
    outlines: dict[str, list[Array]] = {}
    for mechanism in world.mechanisms:
        now, start = known.get(mechanism.name), mechanism.assembly.start
        if now is not None and np.abs(now - start).max(initial=0.0) > START_TOLERANCE:
            outlines[mechanism.name] = [outline for _, outline in body_outlines(posed(mechanism, now))]
    for key, robot, item in _arms(world):
        if key in known and robot.name in places:
            outlines[key] = [places[robot.name].transform(outline) for outline in arm_outlines(item, known[key])]
    return outlines


def grips_json(world: World, values: Values, poses: Mapping[str, Pose3]) -> list[JointGrip]:
    """Return the points by which to drag joints of arms, and joints of mechanisms that can be led."""
    grips = [
        grip
        for mechanism in world.mechanisms
        if mechanism.name in values
        for grips_of in (_mechanism_grips, _curve_grips)
        for grip in grips_of(mechanism, values[mechanism.name])
    ]
    loops = {mechanism.name for mechanism in world.mechanisms if mechanism.assembly.cuts}
    for grip in grips:
        if grip["of"] in loops:
            grip["loop"] = True
    for key, robot, item in _arms(world):
        if key in values and robot.name in poses:
            grips += _arm_grips(key, item, values[key], poses[robot.name].matrix())
    return grips


def _arms(world: World) -> Iterator[tuple[str, Robot, RobotArm]]:
    return ((f"{robot.name}/{item.name}", robot, item) for robot in world.robots for item in robot.arms)


def _mechanism_grips(mechanism: Mechanism, values: Array) -> Iterator[JointGrip]:
    found, ground = mechanism.assembly, mechanism.world_from_ground
    placed = found.linkage.place(values)
    trees = {each.name: each for each in found.linkage.joints}
    led, motion = led_joints(mechanism), _single_motion(mechanism, values)
    for joint in mechanism.joints:
        if joint.name not in trees:
            continue
        body = found.moved_body(joint.name)
        points = _moved(ground @ placed.poses[body], _hull(mechanism, found.bodies[body]))
        # Joints of a loop move the same bodies: handles at their ends would lie on each other.
        share = 1.0 if not found.cuts else CUT_SHARE if joint.name in found.cuts else LOOP_SHARE
        ball = mechanism.balls.get(joint.name, ())
        for column in found.columns[joint.name]:
            name = found.names[column]
            at = _moved(ground, placed.anchors[column])
            if name in ball[:1]:
                tree = trees[joint.name]
                axes = ground[:3, :3] @ placed.poses[tree.parent, :3, :3] @ tree.before[:3, :3]
                grip = at + share * (_most_distant(points, at, axes[:, 0]) - at)
                frame: BallFrame = {"axes": plain(axes.T.ravel(), 6), "way": int(tree.sign)}
                yield {**_grip(mechanism.name, joint.name, False, at=at, axis=axes[:, 2], grip=grip), "ball": frame}
            elif name in led and name not in ball:
                axis = ground[:3, :3] @ placed.axes[column]
                slides = bool(found.slides[column])
                grip = points.mean(axis=0) if slides else at + share * (_farthest(points, at, axis) - at)
                made = _grip(mechanism.name, name, slides, at=at, axis=axis, grip=grip)
                if motion is not None and abs(motion[column]) > STILL_RATIO:
                    change = values + DERIVATIVE_STEP / motion[column] * motion
                    ahead = ground @ found.linkage.place(change).poses[body]
                    moved = _moved(ahead @ inverted(ground @ placed.poses[body]), grip)
                    made["toward"] = plain((moved - grip) / DERIVATIVE_STEP, 4)
                yield made


def _single_motion(mechanism: Mechanism, values: Array) -> Array | None:
    """Return the direction in which the values of a mechanism with loops move together, shape (values,).

    None without loops, or if there are several directions.
    """
    found = mechanism.assembly
    if not found.cuts:
        return None
    _, singular, directions = np.linalg.svd(jacobian(found.linkage, found.rows, values))
    rank = int((singular > STILL_RATIO * singular.max(initial=1.0)).sum())
    return np.asarray(directions[-1]) if found.linkage.size - rank == 1 else None


def _curve_grips(mechanism: Mechanism, values: Array) -> Iterator[JointGrip]:
    """Yield the points on curves of a mechanism."""
    found, ground, led = mechanism.assembly, mechanism.world_from_ground, led_joints(mechanism)
    placed = found.linkage.place(values)
    for track in found.tracks:
        if track.name in led:
            curve, joint = track.curve(found.linkage), found.linkage.joints[track.ghost - 1]
            pose = ground @ placed.poses[joint.parent] @ joint.before
            tangent = pose[:3, :3] @ curve.at(float(values[track.column]))[1]
            at = _moved(ground, track.spot.place(placed))
            frame: CurveFrame = {
                "points": plain(_moved(pose, curve.sampled(CURVE_PIECES)).ravel(), 3),
                "length": curve.length,
                "closed": curve.closed,
                "along": round(float(values[track.column]), 5),
            }
            grip = _grip(mechanism.name, track.name, True, at=at, axis=tangent / np.linalg.norm(tangent), grip=at)
            yield {**grip, "curve": frame}


def _most_distant(points: Array, at: Array, direction: Array) -> Array:
    """Return the point farthest from a place, the first of equals; one along `direction` if all are near."""
    away = np.linalg.norm(points - at, axis=1)
    far = int(np.flatnonzero(away > away.max() - SAME_LEVER)[0])
    return np.asarray(points[far] if away[far] > NO_LEVER else at + MIN_HANDLE_DISTANCE * direction)


def _hull(mechanism: Mechanism, name: str) -> Array:
    """Return points that span a body, in its own frame, shape (n, 3) [m]; its origin if it has no shape."""
    own = next((body for body in mechanism.bodies if body.name == name), None)
    return np.zeros((1, 3)) if own is None else own.hull()[0]


def _farthest(points: Array, at: Array, axis: Array) -> Array:
    """Return the point farthest from an axis, the first of equally far ones; one beside the axis if all are near."""
    away = np.linalg.norm(_levers(points, at, axis), axis=1)
    # Rounding must not choose: the handle would jump between the corners of a box while the joint stands still.
    far = int(np.flatnonzero(away > away.max() - SAME_LEVER)[0])
    if away[far] > NO_LEVER:
        return np.asarray(points[far])
    return np.asarray(at + MIN_HANDLE_DISTANCE * _any_normal(axis))


def _arm_grips(key: str, item: RobotArm, values: Array, world_from_robot: Array) -> Iterator[JointGrip]:
    posture = item.arm.posture(values)
    points = _moved(world_from_robot, posture.points)
    axes = posture.axes @ world_from_robot[:3, :3].T
    beyond = np.vstack([points, _moved(world_from_robot, posture.tool[:3, 3])])
    for number, link in enumerate(item.arm.links):
        at, axis = points[number], axes[number]
        if link.slide:
            grip = at + MIN_HANDLE_DISTANCE * axis
        else:
            levers = _levers(beyond[number + 1 :], at, axis)
            lengths = np.linalg.norm(levers, axis=1)
            far = next((k for k, length in enumerate(lengths) if length > NO_LEVER), None)
            # What turns with the joint, if nothing beyond it is off the axis.
            own = world_from_robot[:3, :3] @ posture.joints[number, :3, 0]
            direction, length = (own, 0.0) if far is None else (levers[far] / lengths[far], float(lengths[far]))
            grip = at + min(max(length / 2.0, MIN_HANDLE_DISTANCE), MAX_HANDLE_DISTANCE) * direction
        yield _grip(key, f"joint{number + 1}", link.slide, at=at, axis=axis, grip=grip)


def _levers(points: Array, at: Array, axis: Array) -> Array:
    """Return the vectors from an axis to points, shape (n, 3) [m]."""
    offsets = points - at
    return np.asarray(offsets - np.outer(offsets @ axis, axis))


def _any_normal(axis: Array) -> Array:
    """Return a unit vector perpendicular to an axis, shape (3,)."""
    normal = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    return np.asarray(normal / np.linalg.norm(normal))


def _moved(pose: Array, points: Array) -> Array:
    return np.asarray(points @ pose[:3, :3].T + pose[:3, 3])


def _grip(key: str, joint: str, slides: bool, *, at: Array, axis: Array, grip: Array) -> JointGrip:
    return {
        "of": key,
        "joint": joint,
        "slides": slides,
        "at": plain(at, 4),
        "axis": plain(axis, 5),
        "grip": plain(grip, 4),
    }
