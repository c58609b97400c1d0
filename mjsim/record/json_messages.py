"""Converts values to JSON messages and back, exactly; `schemas` has the schemas of the messages.

Encoders copy every number out of the arrays, so that a module that changes its arrays later does not change the
recording.
"""

import functools
import json
import math
import sys
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import TypeAdapter

from mjsim.geometry import Array, Pose, Pose3
from mjsim.interface import Command, Estimate, JointGoal, Observation, Sighting, WheelCommand, message_text
from mjsim.record.numbers import Message, flat, numbers, packed, stamp_json, unpacked
from mjsim.record.readings import CODECS, SIGHTINGS
from mjsim.record.tick import Order, RobotEvent, Tick
from mjsim.sentences import Sentence
from mjsim.world import ReachEvent, WorldEvent, event_text

_WORLD_EVENT: TypeAdapter[WorldEvent] = TypeAdapter(WorldEvent)

_FIELDS = tuple((codec.field, codec.encode, codec.sparse) for codec in CODECS)
_ENCODER = json.JSONEncoder(separators=(",", ":"), allow_nan=False, check_circular=False)
ROUGHLY_UNIT = 1e-6
"""Tolerance of the norm of a quaternion; MuJoCo keeps it at 1 within rounding."""
_LEVELS = {"changed": 2, "found": 2, "blocked": 2, "lost": 3, "bump": 3, "fall": 4, "fault": 4}
"""Foxglove's log levels for information, warning and error."""


def encode(message: Message) -> bytes:
    """Return the JSON text of a message.

    Raises:
        ValueError: It contains NaN or -infinity, which are invalid as results of sensors and modules.
    """
    try:
        return _ENCODER.encode(message).encode()
    except ValueError:
        return _ENCODER.encode(_without_infinity(message)).encode()


def _without_infinity(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _without_infinity(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_without_infinity(item) for item in value]
    return None if isinstance(value, float) and value == math.inf else value


def pose_message(
    time: float, pose: Pose, covariance: ArrayLike | None = None, *, moment: float | None = None
) -> Message:
    """Return a pose in the world frame, both in Foxglove's format and exactly.

    Args:
        time: Time of the tick [s].
        pose: The pose.
        covariance: Covariance of it, shape (3, 3).
        moment: Time of the pose [s]; by default that of the tick.
    """
    half = pose.heading / 2
    message: Message = {
        "timestamp": stamp_json(time if moment is None else moment),
        "frame_id": "world",
        "pose": {
            "position": {"x": float(pose.x), "y": float(pose.y), "z": 0.0},
            "orientation": {"x": 0.0, "y": 0.0, "z": math.sin(half), "w": math.cos(half)},
        },
        "time": time,
        "heading": float(pose.heading),
    }
    if covariance is not None:
        message["covariance"] = flat(covariance)
    return message


def truth_message(time: float, planar: Pose, pose: Pose3, *, moment: float | None = None) -> Message:
    """Return the exact 3-D pose of a base in the world frame, and its heading seen from above.

    Args:
        time: Time of the tick [s].
        planar: The pose seen from above.
        pose: The pose.
        moment: Time of the pose [s]; by default that of the tick.
    """
    return {
        "timestamp": stamp_json(time if moment is None else moment),
        "frame_id": "world",
        "pose": {
            "position": {"x": pose.x, "y": pose.y, "z": pose.z},
            "orientation": {"x": pose.qx, "y": pose.qy, "z": pose.qz, "w": pose.qw},
        },
        "time": time,
        "heading": float(planar.heading),
    }


def moment_of(message: Message) -> float:
    """Return when a robot is at the pose of a message, rounded to 1 ns [s]."""
    return float(message["timestamp"]["sec"]) + 1e-9 * float(message["timestamp"]["nsec"])


def pose_row(message: Message) -> tuple[float, float, float]:
    """Return (x, y, heading) of a pose message."""
    position = message["pose"]["position"]
    return position["x"], position["y"], message["heading"]


def pose3_row(message: Message) -> tuple[float, ...]:
    """Return (x, y, z, qx, qy, qz, qw) of a pose message; raises ValueError unless the quaternion has norm 1."""
    position, orientation = message["pose"]["position"], message["pose"]["orientation"]
    quaternion = [orientation[axis] for axis in "xyzw"]
    if not abs(math.hypot(*quaternion) - 1.0) < ROUGHLY_UNIT:
        raise ValueError(Sentence("the quaternion {quaternion} is not a rotation", quaternion))
    return (*(position[axis] for axis in "xyz"), *quaternion)


def path_message(time: float, path: Array) -> Message:
    """Return a final trajectory; rows of time [s], x, y [m] and heading [rad], shape (M, 4)."""
    columns = zip(("times", "x", "y", "heading"), path.T.tolist(), strict=True)
    return {"time": time, **dict(columns)}


def path_rows(message: Message) -> Array:
    """Return the rows of a final trajectory, shape (M, 4); raises ValueError unless its times ascend."""
    rows = np.column_stack([np.array(message[key], dtype=float) for key in ("times", "x", "y", "heading")])
    if not np.isfinite(rows).all() or (np.diff(rows[:, 0]) <= 0.0).any():
        raise ValueError("a path with numbers that are not finite, or with times that do not ascend")
    return rows.reshape(-1, 4)


def sightings_message(time: float, sightings: Sequence[Sighting]) -> Message:
    """Return all sightings of a tick."""
    return {"time": time, "sightings": SIGHTINGS.encode(sightings)}


def observation_message(seen: Observation) -> Message:
    """Return all numbers of an observation, and the stamps of its pictures."""
    message: Message = {"time": float(seen.time), "dt": float(seen.dt)}
    for field, encode_value, sparse in _FIELDS:
        value = getattr(seen, field)
        if not sparse or value:
            message[field] = encode_value(value)
    return message


def observation_of(message: Message) -> Observation:
    """Return the observation of a message, without its pictures."""
    fields = {
        codec.field: codec.decode(message[codec.field]) for codec in CODECS if codec.is_read and codec.field in message
    }
    return Observation(time=message["time"], dt=message["dt"], **fields)


def _label(name: Hashable) -> tuple[str, bool]:
    """Return a landmark's name as text, and whether it is an integer."""
    return str(name), isinstance(name, int | np.integer) and not isinstance(name, bool)


def _labels(names: Sequence[Hashable]) -> Message:
    labels = [_label(name) for name in names]
    return {"names": [text for text, _ in labels], "numbered": [numbered for _, numbered in labels]}


def names_of(message: Message) -> tuple[Hashable, ...]:
    """Return the names of the landmarks in a message: integers, or text."""
    return tuple(
        _name(name, numbered=numbered) for name, numbered in zip(message["names"], message["numbered"], strict=True)
    )


def _name(text: str, *, numbered: bool) -> Hashable:
    """Return a landmark's name; equal texts share one object."""
    return int(text) if numbered else sys.intern(text)


def map_arrays(
    landmarks: Mapping[Hashable, tuple[ArrayLike, ArrayLike]],
) -> tuple[tuple[Hashable, ...], Array, Array]:
    """Return copies of an estimated map: names, means (n, 2) [m] and covariances (n, 2, 2) [m^2]."""
    means = np.array([mean for mean, _ in landmarks.values()], dtype=float).reshape(-1, 2)
    covariances = np.array([covariance for _, covariance in landmarks.values()], dtype=float).reshape(-1, 2, 2)
    return tuple(landmarks), means, covariances


def landmarks_message(time: float, names: Sequence[Hashable], means: Array, covariances: Array) -> Message:
    """Return an estimated map, as `map_arrays` gives it."""
    upright = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
    return {
        "timestamp": stamp_json(time),
        "frame_id": "world",
        "time": time,
        "poses": [{"position": {"x": x, "y": y, "z": 0.0}, "orientation": upright} for x, y in means.tolist()],
        **_labels(names),
        "covariances": flat(covariances),
    }


def landmarks_of(message: Message) -> tuple[tuple[Hashable, ...], Array, Array]:
    """Return names, means (k, 2) [m] and covariances (k, 2, 2) [m^2] of the map in a message."""
    names = names_of(message)
    means = [(pose["position"]["x"], pose["position"]["y"]) for pose in message["poses"]]
    covariances = np.reshape(numbers(message["covariances"]), (len(names), 2, 2))
    return names, np.array(means, dtype=float).reshape(len(names), 2), covariances


def innovations_message(time: float, innovations: Sequence[tuple[Hashable, ArrayLike, ArrayLike]]) -> Message:
    """Return the innovations of a tick."""
    items = []
    for name, nu, S in innovations:
        text, numbered = _label(name)
        items.append({"name": text, "numbered": numbered, "nu": flat(nu), "S": flat(S)})
    return {"time": time, "innovations": items}


def innovations_of(message: Message) -> tuple[tuple[Hashable, Array, Array], ...]:
    """Return name, nu (2,) and S (2, 2) of each innovation of a message."""
    return tuple(
        (_name(item["name"], numbered=item["numbered"]), numbers(item["nu"]), numbers(item["S"], 2, 2))
        for item in message["innovations"]
    )


@functools.lru_cache(maxsize=16)  # A map grows, then keeps its size for most of a run.
def _lower_triangle(size: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the rows and columns of the entries on and below the diagonal of a matrix."""
    rows, columns = np.tril_indices(size)
    return rows, columns


def covariance_message(time: float, estimate: Estimate, joint: Array) -> Message:
    """Return the joint covariance of an estimate: its lower triangle."""
    return {
        "time": time,
        **_labels(list(estimate.landmarks)),
        "size": len(joint),
        "lower": packed(joint[_lower_triangle(len(joint))]),
    }


def covariance_of(message: Message) -> Array:
    """Return the joint covariance of a message, shape (3 + 2 n, 3 + 2 n)."""
    size = message["size"]
    P = np.zeros((size, size))
    P[_lower_triangle(size)] = unpacked(message["lower"])
    return P + np.tril(P, -1).T


def command_message(time: float, order: Order) -> Message:
    """Return the command given to the drive and that of the navigator."""
    return {"time": time, "command": _command(order.command), "wanted": _command(order.wanted)}


def _command(command: Command | WheelCommand) -> Message:
    if isinstance(command, WheelCommand):
        return {"wheels": flat(command.speeds)}
    content: Message = {"forward": float(command.forward), "left": float(command.left), "turn": float(command.turn)}
    if command.messages:
        content["messages"] = [message_text(message) for message in command.messages]
    if command.joints:
        content["joints"] = [_goal_message(arm, goal) for arm, goal in command.joints.items()]
    return content


def _goal_message(arm: str, goal: JointGoal) -> Message:
    parts = {part.name: getattr(goal, part.name) for part in fields(goal)}
    return {"arm": arm} | {name: flat(values) for name, values in parts.items() if values is not None}


def command_row(message: Message) -> tuple[float, float, float]:
    """Return (forward, left, turn) given to the drive; NaN for wheel speeds."""
    command = message["command"]
    return command.get("forward", math.nan), command.get("left", math.nan), command.get("turn", math.nan)


def event_message(robot: str, event: RobotEvent) -> Message:
    """Return an event as a log message."""
    message = {
        "timestamp": stamp_json(event.time),
        "level": _LEVELS[event.kind],
        "message": event.text,
        "name": robot,
        "file": "",
        "line": 0,
        "time": float(event.time),
        "kind": event.kind,
    }
    if event.bearing is not None:
        message["bearing"] = float(event.bearing)
    return message


def event_of(message: Message) -> RobotEvent:
    """Return the event of a message."""
    return RobotEvent(message["time"], message["kind"], message["message"], message.get("bearing"))


def world_event_message(time: float, event: WorldEvent) -> Message:
    """Return an event of the world as a log message and exactly."""
    short = {"short": event.short} if isinstance(event, ReachEvent) and event.short else {}
    return {
        "timestamp": stamp_json(time),
        "level": 2,
        "message": event_text(event),
        "name": "world",
        "file": "",
        "line": 0,
        "time": float(time),
        "event": _event_keys(event) | {"time": float(time)},
        **short,
    }


def world_event_of(message: Message) -> WorldEvent:
    """Return the event of a message."""
    keys = dict(message["event"])
    if isinstance(signal := keys.get("signal"), str):
        keys["signal"] = json.loads(signal)
    event: WorldEvent = _WORLD_EVENT.validate_python(keys)
    return event.stays_away(message["short"]) if isinstance(event, ReachEvent) and "short" in message else event


def _event_keys(event: WorldEvent) -> dict[str, Any]:
    """Return the keys of an event; a signal, whose keys depend on its kind, as JSON text."""
    keys = event.model_dump(mode="json", exclude_none=True)
    if "signal" in keys:
        keys["signal"] = json.dumps(keys["signal"])
    if "hand" in keys:
        del keys["arm"]
    return keys


def things_message(time: float, things: Mapping[str, Pose]) -> Message:
    """Return the poses of all movable things except robots."""
    places = [
        {"name": name, "x": float(pose.x), "y": float(pose.y), "heading": float(pose.heading)}
        for name, pose in things.items()
    ]
    return {"time": float(time), "things": places}


def things_rows(message: Message) -> dict[str, tuple[float, float, float]]:
    """Return name -> (x, y, heading) of a message."""
    return {item["name"]: (item["x"], item["y"], item["heading"]) for item in message["things"]}


def state_message(tick: Tick) -> Message:
    """Return the state of MuJoCo."""
    return {"time": float(tick.time), "qpos": flat(tick.qpos), "qvel": flat(tick.qvel)}


def timing_message(tick: Tick, clock: float) -> Message:
    """Return the wall-clock time of each part of the loop."""
    costs = [(f"loop/{part}", seconds) for part, seconds in tick.timing.items()]
    costs += [
        (f"{name}/{part}", seconds) for name, order in tick.orders.items() for part, seconds in order.timing.items()
    ]
    return {
        "time": float(tick.time),
        "clock": clock,
        "parts": [{"part": part, "seconds": float(seconds)} for part, seconds in costs],
    }
