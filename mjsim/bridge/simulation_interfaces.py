"""The services of the ROS package `simulation_interfaces` 2.1: robots, obstacles, beacons and time of a running world.

References:
    https://github.com/ros-simulation/simulation_interfaces, tag 2.1.0, for result codes and their meaning.
"""

import math
import re
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from mjsim.bridge.bus import Bus
from mjsim.bridge.services import offer
from mjsim.errors import UsageError, did_you_mean
from mjsim.geometry import Array, Pose, Pose3, wrap_angle
from mjsim.record import Tick
from mjsim.ros import (
    BOUNDS,
    FEATURES,
    MAP_FRAME,
    RESOURCE,
    RESULT,
    SPAWNABLE,
    STATE,
    entity_state,
    typestore,
)
from mjsim.session import Session, State
from mjsim.world import MoveEvent, first_looks

UNSUPPORTED, OK, NOT_FOUND, INCORRECT_STATE, FAILED = range(5)
"""Results of every service."""
INVALID_POSE, ALREADY, INCORRECT_TRANSITION = 101, 101, 103
"""Results of SetEntityState, and of SetSimulationState."""
NOT_UNIQUE, NAME_INVALID, UNSUPPORTED_FORMAT, NO_RESOURCE, NAMESPACE_INVALID, INVALID_PLACE = (
    101,
    102,
    103,
    104,
    105,
    109,
)
"""Results of SpawnEntity."""
STOPPED, PLAYING, PAUSED, QUITTING, NO_WORLD, LOADING = range(6)
"""States of a simulation."""
FEATURES_HAD = {
    **{"SPAWNING": 0, "DELETING": 1, "ENTITY_STATE_GETTING": 10, "ENTITY_STATE_SETTING": 11, "SPAWNABLES": 14},
    **{"SIMULATION_RESET": 20, "SIMULATION_STATE_GETTING": 24, "SIMULATION_STATE_SETTING": 25},
    **{"SIMULATION_STATE_PAUSE": 26, "STEP_SIMULATION_SINGLE": 31, "STEP_SIMULATION_MULTIPLE": 32},
}
"""Features that the bridge supports."""
RESET_ALL = 0b111
"""Time, state and spawned entities, as bits of the scope of a reset."""
MAX_STEPS = 100_000
"""Maximum number of ticks per call."""
WORLD_FRAMES = ("", "world", MAP_FRAME)
MAX_TILT, NORM_TOLERANCE = 1e-3, 1e-2
"""Maximum tilt of a level pose [rad], and maximum deviation of a quaternion's length from 1."""
SAME_HEIGHT = SAME_PLACE = 0.01
"""Maximum difference between a requested height, or place of a fixed entity, and the entity's own [m]."""
SAME_HEADING = 0.01
"""Maximum difference between a requested heading and that of a fixed entity [rad]."""
TIME_TOLERANCE = 1e-9
"""Maximum time by which an event of a tick may be later than the tick [s]."""
SPAWNING = (
    "a running world takes no new entities; SpawnEntity brings back obstacles and beacons that were removed, by"
    " DeleteEntity or by an event at 0 s, with their names as uri"
)
INFO = "mjsim: a step is a tick of the world (run.rate_hz); entities are its robots, obstacles and beacons; " + SPAWNING
Coded = tuple[int, str]
"""Result code, and one line, or '' if there is nothing to say."""
FINE: Coded = (OK, "")


class SimulationInterfaces:
    """Answers the services below `/mjsim`; each wrong request gets a result and one line."""

    def __init__(self, bus: Bus, session: Session, *, patience: float) -> None:
        """Offer the services; to be used before the bus is started.

        Args:
            bus: The bus.
            session: The run.
            patience: Time limit for the run to take a tick or to return to its start [s].
        """
        self._session, self._patience, self._stopped = session, patience, False
        self._entities = Entities(session)
        answers: dict[str, Callable[[Any], tuple[Any, ...]]] = {
            "GetSimulatorFeatures": self._features,
            "GetSpawnables": self._spawnables,
            "SpawnEntity": self._spawned,
            "DeleteEntity": lambda request: (_result(self._delete(request)),),
            "GetEntities": self._list,
            "GetEntityState": self._state_of,
            "SetEntityState": lambda request: (_result(self._set(request)),),
            "StepSimulation": lambda request: (_result(self._step(int(request.steps))),),
            "ResetSimulation": lambda request: (_result(self._reset(int(request.scope))),),
            "GetSimulationState": lambda request: (_of(STATE, self._now()), _result(FINE)),
            "SetSimulationState": lambda request: (_result(self._go_to(int(request.state.state))),),
        }
        for name, answer in answers.items():
            words = re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()
            offer(bus, f"/mjsim/{words}", f"simulation_interfaces/srv/{name}", answer)

    def see(self, tick: Tick) -> None:
        """Take the newest tick; called in the session's thread."""
        self._entities.see(tick)

    def _features(self, request: Any) -> tuple[Any, ...]:
        return (_of(FEATURES, np.array([*FEATURES_HAD.values()], dtype=np.uint16), [], INFO),)

    def _spawnables(self, request: Any) -> tuple[Any, ...]:
        unknown = ", ".join(f"'{each[:60]}'" for each in request.sources[:9])
        remark = f"no source {unknown}; only what the run holds can be spawned" if unknown else ""
        return _result((OK, remark)), [spawnable(*each) for each in self._entities.absent().items()]

    def _spawned(self, request: Any) -> tuple[Any, ...]:
        uri = request.entity_resource.uri
        coded = self._spawn(request, uri)
        return _result(coded), uri if coded[0] == OK else ""

    def _spawn(self, request: Any, uri: str) -> Coded:
        """Bring back an entity that was removed."""
        absent = self._entities.absent()
        if not uri:
            text = bool(request.entity_resource.resource_string)
            return (UNSUPPORTED_FORMAT if text else NO_RESOURCE), f"give a uri{_that_is(absent)}; {SPAWNING}"
        if uri not in absent:
            taken = uri in self._entities.names()
            problem = f"'{uri[:60]}' is there already" if taken else f"no uri '{uri[:60]}'"
            return (NOT_UNIQUE if taken else NOT_FOUND), f"{problem}{_that_is(absent)}; {SPAWNING}"
        if request.name not in ("", uri) and not request.allow_renaming:
            return NAME_INVALID, f"'{uri}' keeps its name; leave name empty, or allow renaming"
        if request.entity_namespace:
            return NAMESPACE_INVALID, "obstacles and beacons have no topics; leave entity_namespace empty"
        stands, movable = self._entities.place(uri)
        coded, to = _wanted_pose(request.initial_pose.header, request.initial_pose.pose, uri, stands.z)
        if to is None:
            return (INVALID_PLACE if coded[0] == INVALID_POSE else coded[0]), coded[1]
        if movable:
            return self._put({"restore": uri}, to)
        there = stands.planar()
        turn = abs(wrap_angle(to.heading - there.heading))
        if math.dist((to.x, to.y), (there.x, there.y)) > SAME_PLACE or turn > SAME_HEADING:
            place = f"x = {there.x:g}, y = {there.y:g}, heading {math.degrees(there.heading):g} degrees"
            return INVALID_PLACE, f"'{uri}' is fixed and comes back where it stood: {place}"
        return self._touch({"restore": uri})

    def _delete(self, request: Any) -> Coded:
        if unknown := self._unknown(request.entity):
            return unknown
        return self._touch({"remove": request.entity})

    def _list(self, request: Any) -> tuple[Any, ...]:
        filters = request.filters
        if len(filters.categories) or len(filters.tags.tags) or filters.bounds.type:
            return _result((UNSUPPORTED, "entities are filtered only by name; leave categories, tags and bounds")), []
        try:
            wanted = re.compile(filters.filter)
        except re.error as error:
            return _result((FAILED, f"filter '{filters.filter[:60]}' is not a regular expression: {error}")), []
        return _result(FINE), [name for name in self._entities.names() if wanted.search(name)]

    def _state_of(self, request: Any) -> tuple[Any, ...]:
        if unknown := self._unknown(request.entity):
            return _result(unknown), entity_state(0.0, MAP_FRAME, Pose3.from_planar(Pose(0, 0, 0)), np.zeros(3))
        time, pose, velocity = self._entities.state(request.entity)
        return _result(FINE), entity_state(time, MAP_FRAME, pose, velocity)

    def _set(self, request: Any) -> Coded:
        """Move an entity, or stop it where it is; it is at rest afterwards."""
        if unknown := self._unknown(request.entity):
            return unknown
        if _moves(request):
            return (
                UNSUPPORTED,
                "an entity is put at rest; leave twist and acceleration at zero, drive robots by cmd_vel",
            )
        if not (request.set_pose or request.set_twist):
            return FINE
        _, now, _ = self._entities.state(request.entity)
        if not request.set_pose:
            return self._put({"move": request.entity}, now.planar())
        coded, to = _wanted_pose(request.state.header, request.state.pose, request.entity, now.z)
        return coded if to is None else self._put({"move": request.entity}, to)

    def _put(self, event: dict[str, Any], to: Pose) -> Coded:
        """Make an event that puts an entity at a pose."""
        heading = math.remainder(math.degrees(to.heading), 360.0)
        return self._touch({**event, "to": [to.x, to.y], "heading_deg": heading})

    def _step(self, steps: int) -> Coded:
        if (state := self._reach("paused", "running")) in ("ended", "failed"):  # A world that is loading is neither.
            return INCORRECT_STATE, f"the run has {state}; reset it first"
        if state != "paused":
            return FAILED, f"the simulation is {state}; pause it first"
        if not 1 <= steps <= MAX_STEPS:
            return FAILED, f"steps is {steps}; it must be from 1 to {MAX_STEPS:,}"
        for number in range(steps):
            self._session.tick()
            if (found := self._reach("paused")) != "paused":
                return FAILED, f"the run is {found} after {number + 1} of {steps} steps"
        self._stopped = False
        return FINE

    def _reset(self, scope: int) -> Coded:
        if scope and scope & RESET_ALL != RESET_ALL:
            return UNSUPPORTED, f"scope is {scope}; only the whole simulation can be reset, with scope 0 or 255"
        self._stopped = False
        self._session.restart()
        found = self._reach("paused", "running")
        return FINE if found in ("paused", "running") else (FAILED, f"the run is {found} after a reset")

    def _now(self) -> int:
        if self._stopped:
            return STOPPED
        known: dict[State, int] = {"loading": LOADING, "running": PLAYING, "paused": PAUSED}
        return known.get(self._session.state, STOPPED)

    def _go_to(self, wanted: int) -> Coded:
        now = self._now()
        if wanted not in (STOPPED, PLAYING, PAUSED):
            what = "ended where it was started" if wanted == QUITTING else "of one world, which stays loaded"
            return (UNSUPPORTED if wanted == QUITTING else INCORRECT_TRANSITION), f"the simulation is {what}"
        if wanted == now:
            return ALREADY, "the simulation is in this state already"
        if wanted == PLAYING:
            self._session.go()
        else:
            self._session.pause()
        if wanted == STOPPED or self._session.state in ("ended", "failed"):
            self._session.restart()
        self._stopped = wanted == STOPPED
        aim: State = "running" if wanted == PLAYING else "paused"
        found = self._reach(aim)
        return FINE if found == aim else (FAILED, f"the run is {found}")

    def _reach(self, *states: State) -> State:
        """Wait until the run is in one of these states, or over."""
        return self._session.wait(*states, "ended", "failed", timeout=self._patience)

    def _unknown(self, name: str) -> Coded | None:
        names = self._entities.names()
        return None if name in names else (NOT_FOUND, f"no entity '{name[:60]}'{did_you_mean(name[:60], names)}")

    def _touch(self, keys: dict[str, Any]) -> Coded:
        try:
            self._session.touch(keys)
        except UsageError as error:
            return FAILED, str(error)
        return FINE


def _moves(request: Any) -> bool:
    """Return whether a request to set a state contains a speed or an acceleration."""
    state = request.state
    asked = (state.twist, request.set_twist), (state.acceleration, request.set_acceleration)
    parts = [part for each, wanted in asked if wanted for part in (each.linear, each.angular)]
    return any(getattr(part, axis) for part in parts for axis in "xyz")


def _wanted_pose(header: Any, pose: Any, entity: str, height: float) -> tuple[Coded, Pose | None]:
    """Return the requested pose of an entity at a height [m], or what is wrong with the request."""
    if (frame := header.frame_id) not in WORLD_FRAMES:
        return (INVALID_POSE, f"the pose is in the frame '{frame[:60]}'; give it in '{MAP_FRAME}' or 'world'"), None
    place, q = pose.position, pose.orientation
    if wrong := _wrong_pose([place.x, place.y, place.z], [q.x, q.y, q.z, q.w]):
        return (INVALID_POSE, wrong), None
    if abs(place.z - height) > SAME_HEIGHT:
        return (INVALID_POSE, f"z is {place.z:g} m; '{entity}' keeps its height, z = {height:.3f} m"), None
    return FINE, Pose(place.x, place.y, 2.0 * math.atan2(q.z, q.w))


def spawnable(uri: str, description: str) -> Any:
    """Return the message that describes something that can be spawned."""
    return _of(SPAWNABLE, _of(RESOURCE, uri, ""), description, _of(BOUNDS, 0, []))


def _that_is(absent: Mapping[str, str]) -> str:
    """Return which URIs can be spawned, as the end of a message."""
    return f"; there are {', '.join(absent)}" if absent else "; nothing is removed now"


def _wrong_pose(place: list[float], turned: list[float]) -> str | None:
    """Return why a position [m] and a quaternion (x, y, z, w) are not a pose on the floor; None if they are."""
    if not all(map(math.isfinite, [*place, *turned])):
        return "the pose is not finite"
    if abs(math.hypot(*turned) - 1.0) > NORM_TOLERANCE:
        return f"the quaternion has length {math.hypot(*turned):.3g}; it must be 1"
    if 2.0 * math.hypot(*turned[:2]) > MAX_TILT:
        return "the pose is tilted; entities stand upright, turned about z alone"
    return None


def _of(kind: str, *values: Any) -> Any:
    return typestore().types[kind](*values)


def _result(coded: Coded) -> Any:
    return _of(RESULT, *coded)


class Entities:
    """Names and states of the entities at the newest tick of a session."""

    def __init__(self, session: Session) -> None:
        """Take the entities of the session's world.

        Args:
            session: The run.
        """
        self._session, world = session, session.world
        self._before: Tick | None = None
        self._newest: Tick | None = None
        self._robots = [robot.name for robot in world.robots]
        named = [each for each in world.obstacles if each.name is not None]
        fixed = [str(each.name) for each in named if not each.movable]
        self._fixed = {*fixed, *(each.name for each in world.beacons)}
        self._standing = {
            **{str(each.name): _at(each.at, 0.0, math.radians(each.heading_deg)) for each in named},
            **{each.name: _at(each.at, each.center, math.radians(each.heading_deg)) for each in world.beacons},
        }
        """Start poses of all entities except robots."""

    def see(self, tick: Tick) -> None:
        """Take the newest tick."""
        self._before, self._newest = self._newest, tick

    def names(self) -> list[str]:
        """Return the names of all entities that exist after the next tick."""
        removed = self._removed()
        return [name for name in (*self._robots, *self._standing) if name not in removed]

    def absent(self) -> dict[str, str]:
        """Return the removed entities that can come back: name -> where they can be, in words."""
        removed, carriers = self._removed(), {each.name: each.on for each in self._session.world.beacons}
        back = [name for name in self._standing if name in removed and carriers.get(name) not in removed]
        return {name: "where it stood" if name in self._fixed else "anywhere on the floor" for name in back}

    def place(self, name: str) -> tuple[Pose3, bool]:
        """Return the start pose of an entity other than a robot, and whether it can be elsewhere."""
        return self._standing[name], name not in self._fixed

    def _removed(self) -> frozenset[str]:
        newest, world = self._newest, self._session.world
        looks = None if newest is None else newest.looks
        since = -1.0 if newest is None or looks is None else newest.time
        looks = first_looks(world) if looks is None else looks
        for event in self._session.touched:
            looks = looks.after(event, world) if event.time > since + TIME_TOLERANCE else looks
        return looks.removed

    def state(self, name: str) -> tuple[float, Pose3, Array]:
        """Return time [s], world_from_entity, and (x, y, turn) velocity in the world frame [m/s, m/s, rad/s].

        The velocity of a robot is its mean over the newest tick; that of other entities is 0.
        """
        newest = self._newest
        if newest is None or name not in newest.poses:
            moved = None if newest is None else newest.things.get(f"obstacle/{name}")
            pose = self._standing.get(name, _ORIGIN) if moved is None else Pose3.from_planar(moved)
            return 0.0 if newest is None else newest.time, pose, np.zeros(3)
        return newest.time, newest.poses[name], self._velocity(newest, name)

    def _velocity(self, newest: Tick, name: str) -> Array:
        before = self._before
        jumped = any(isinstance(event, MoveEvent) and event.move == name for event in newest.events)
        if jumped or before is None or not before.time < newest.time or name not in before.truth:
            return np.zeros(3)
        step = newest.truth[name].as_array() - before.truth[name].as_array()
        step[2] = wrap_angle(float(step[2]))
        return np.asarray(step / (newest.time - before.time))


def _at(place: tuple[float, ...], z: float, heading: float) -> Pose3:
    """Return the pose of an upright thing at a height."""
    level = Pose3.from_planar(Pose(place[0], place[1], heading))
    return Pose3(level.x, level.y, z, level.qx, level.qy, level.qz, level.qw)


_ORIGIN = _at((0.0, 0.0), 0.0, 0.0)
