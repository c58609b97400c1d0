"""A run in JSON for the page."""

from collections.abc import Mapping, Sequence

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import Command, Observation, Sighting, WheelCommand
from mjsim.mechanics import inverted, rpy_of
from mjsim.record import Tick
from mjsim.report import metrics
from mjsim.web.run.history import NO_NEES, plain
from mjsim.web.run.joint_news import ArmTick, MechanismFacts, MechanismTick
from mjsim.web.run.jointed import arm_facts, drawn_bodies, grips_json, joint_rows_json, led_facts
from mjsim.web.run.measured import flat_points
from mjsim.web.run.news import Chosen, NoiseFigure, Recognised, RobotFacts, RobotTick, TickNews
from mjsim.web.run.showing import shown_json
from mjsim.world import (
    Camera,
    Looks,
    Modules,
    Robot,
    Use,
    World,
    noise_figures,
    rims,
)

MAX_CORNERS = 16
"""Maximum number of corners of the outline of a moving body's part."""
_RING = np.asarray(np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False), dtype=float)
"""Directions of the proximity rays, left positive [rad]."""


def tick_json(
    tick: Tick,
    *,
    number: int,
    pace: float,
    scans: Mapping[str, Mapping[str, Array]] | None = None,
    led: Mapping[str, Sequence[str]] | None = None,
    hands: Mapping[str, Mapping[str, Array]] | None = None,
    people: Mapping[str, Sequence[tuple[Array, str]]] | None = None,
    world: World | None = None,
) -> TickNews:
    """Return a tick in JSON form.

    Args:
        tick: The tick.
        number: Number of the tick, over all runs.
        pace: Simulated seconds per second.
        scans: Robot -> lidar -> points hit by its beams, world frame, shape (n, 3) [m].
        led: Mechanism -> its joints that motions lead.
        hands: Person -> side -> grip position of that hand, world frame, shape (3,) [m].
        people: Person whose hands were moved -> outlines from above with their colours, world frame, shape (n, 2) [m].
        world: World whose arms and mechanisms are included; by default none.
    """
    found = scans or {}
    news: TickNews = {
        "kind": "tick",
        "number": number,
        "time": round(tick.time, 6),
        "pace": round(pace, 3),
        "robots": {name: _robot_json(tick, name, found.get(name, {})) for name in tick.orders},
        "things": {name: plain(pose.as_array()) for name, pose in tick.things.items()},
    }
    if mechanisms := {name: _led_json(tick, name, joints) for name, joints in (led or {}).items()}:
        news["mechanisms"] = mechanisms
    if hands:
        news["hands"] = {name: {side: _place(at) for side, at in each.items()} for name, each in hands.items()}
    if people:
        news["people"] = people_json(people)
    if world is not None and tick.joints:
        values = {name: motion.positions for name, motion in tick.joints.items()}
        news["joints"] = joint_rows_json(tick.joints)
        news["bodies"] = outlines_json(drawn_bodies(world, values, tick.truth))
        news["grips"] = grips_json(world, values, tick.poses)
    return with_removed(news, tick.looks)


def outlines_json(bodies: Mapping[str, Sequence[Array]]) -> dict[str, list[list[tuple[float, float]]]]:
    """Return outlines with few corners."""
    return {name: [_thinned(outline) for outline in outlines] for name, outlines in bodies.items()}


def people_json(people: Mapping[str, Sequence[tuple[Array, str]]]) -> dict[str, list[list[tuple[float, float]]]]:
    """Return the outlines of people whose hands were moved."""
    return outlines_json({name: [outline for outline, _ in parts] for name, parts in people.items()})


def _thinned(outline: Array) -> list[tuple[float, float]]:
    """Return at most `MAX_CORNERS` corners of an outline [m]."""
    return [(round(x, 3), round(y, 3)) for x, y in outline[:: -(-len(outline) // MAX_CORNERS)].tolist()]


def _place(at: Array) -> tuple[float, float, float]:
    x, y, z = (round(float(value), 4) for value in at)
    return x, y, z


def with_removed(news: TickNews, looks: Looks | None) -> TickNews:
    """Return a tick with the names of the beacons and obstacles removed at that time, if any."""
    return {**news, "removed": sorted(looks.removed)} if looks is not None and looks.removed else news


@np.errstate(over="ignore", invalid="ignore")  # an estimate may be anywhere
def _robot_json(tick: Tick, name: str, scans: Mapping[str, Array]) -> RobotTick:
    seen, order, truth = tick.seen[name], tick.orders[name], tick.truth[name].as_array()
    belief = order.estimate
    estimate, P = belief.pose.as_array(), np.asarray(belief.covariance, dtype=float)
    estimated = "estimator" in order.timing
    nees = metrics.normalised_errors(truth[None], estimate[None], P[None]) if estimated else NO_NEES
    robot_tick: RobotTick = {
        "truth": plain(truth),
        "estimate": plain(estimate),
        "odometry": plain(order.dead_reckoning.as_array()),
        "covariance": plain(P.ravel(), 9),
        "landmarks": {
            str(key): plain([mean[0], mean[1], S[0, 0], S[0, 1], S[1, 1]], 6)
            for key, (mean, S) in belief.landmarks.items()
        },
        "sightings": [(each.name, round(each.range, 4), round(each.bearing, 5)) for each in order.sightings],
        "error": plain(metrics.position_errors(truth[None], estimate[None]), 5)[0],
        "heading_error": plain(metrics.heading_errors(truth[None], estimate[None]), 5)[0],
        "nees": plain(nees, 3)[0],
        "estimated": estimated,
        "timing": {part: round(1e3 * seconds, 3) for part, seconds in {**tick.timing, **order.timing}.items()},
        "command": plain(_twist(order.command, seen)),
        "proximity": plain(seen.proximity, 3),
        "bump": plain(seen.bump, 3),
    }
    if arms := _arms_json(tick, name):
        robot_tick["arms"] = arms
    if scans:
        robot_tick["scans"] = {lidar: flat_points(points) for lidar, points in scans.items()}
    if belief.show:
        robot_tick["show"] = shown_json(belief.show)
    return robot_tick


def _led_json(tick: Tick, name: str, joints: Sequence[str]) -> MechanismTick:
    """Return the positions of a mechanism's joints."""
    motion = tick.joints[name]
    return {"positions": plain(motion.positions[[motion.names.index(joint) for joint in joints]], 6)}


def _arms_json(tick: Tick, name: str) -> dict[str, ArmTick]:
    """Return the arms of a robot by name."""
    found: dict[str, ArmTick] = {}
    for key, motion in tick.joints.items():
        robot, _, arm = key.partition("/")
        if robot != name or motion.tool is None:
            continue
        tool = inverted(tick.poses[name].matrix()) @ motion.tool
        found[arm] = {
            "positions": plain(motion.positions, 6),
            "goal": plain(motion.goal, 6),
            "tool": plain([*tool[:3, 3], *rpy_of(tool)], 6),
        }
    return found


def _twist(command: Command | WheelCommand, seen: Observation) -> tuple[float, float, float]:
    """Return the command to the drive as (forward, left, turn); for wheel speeds, the twist measured by odometry."""
    if isinstance(command, Command):
        return command.forward, command.left, command.turn
    odometry = seen.odometry
    return odometry.forward / seen.dt, odometry.left / seen.dt, odometry.turn / seen.dt


def recognised_json(sightings: Sequence[Sighting]) -> list[Recognised]:
    """Return names and corners [px] of the beacons recognised in a picture."""
    return [(each.name, plain(each.corners, 2)) for each in sightings if each.corners is not None]


def robots_json(world: World, *, first: str | None = None) -> list[RobotFacts]:
    """Return the properties of each robot; the named one comes first."""
    return [_facts(robot) for robot in sorted(world.robots, key=lambda robot: robot.name != first)]


def mechanisms_json(world: World) -> list[MechanismFacts]:
    """Return the mechanisms with a joint that can be dragged."""
    facts = ((mechanism.name, led_facts(mechanism)) for mechanism in world.mechanisms)
    return [{"name": name, "joints": joints} for name, joints in facts if joints]


def drivers_json(world: World) -> dict[str, Chosen]:
    """Return the modules that drive each robot."""
    return {robot.name: _modules_json(world.run.drivers.get(robot.name, Modules())) for robot in world.robots}


def noise_json(world: World, initial: Mapping[str, float]) -> list[NoiseFigure]:
    """Return the noise parameters that may change during the run; `initial` contains their start values."""
    return [
        {
            "key": figure.key,
            "label": figure.key.removeprefix("robots.").replace(".", " "),
            "value": figure.value,
            "initial": initial.get(figure.key, figure.value),
            "unit": figure.unit,
            "description": figure.about,
            "slider": None if figure.slider is None else [figure.slider.low, figure.slider.high],
        }
        for figure in noise_figures(world)
    ]


def _facts(robot: Robot) -> RobotFacts:
    outline = robot.body.outline()
    return {
        "name": robot.name,
        "radius": robot.body.radius,
        "outline": None if outline is None else plain(outline),
        "rims": plain(rims(robot.body, _RING)),
        "color": getattr(robot.body, "color", None),
        "cameras": [
            {"name": sensor.camera, "width": sensor.width, "height": sensor.height}
            for sensor in robot.sensors
            if isinstance(sensor, Camera)
        ],
        "can_drive": robot.base != "fixed",
        "can_strafe": robot.drive.sideways > 0.0,
        "arms": [{"name": item.name, "joints": arm_facts(item)} for item in robot.arms],
    }


def _modules_json(modules: Modules) -> Chosen:
    def named(use: Use | None) -> str | None:
        return None if use is None else use.use

    avoidance = modules.avoidance
    return {
        "observer": named(modules.observer),
        "estimator": named(modules.estimator),
        "navigator": named(modules.navigator),
        "avoidance": avoidance if isinstance(avoidance, bool) else avoidance.use,
    }
