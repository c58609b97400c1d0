"""Values to JSON messages and back, exactly; the schemas of the messages stand in `schemas`.

What makes a message copies every number out of its arrays, so that a module that changes its arrays later does not
change what was recorded.
"""

import json
import math
import sys
from collections.abc import Hashable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from pydantic import TypeAdapter

from mjsim.geometry import Array, Pose
from mjsim.interface import Command, Estimate, Observation, Odometry, Sighting, WheelCommand
from mjsim.readings import message_text
from mjsim.record.readings import (
    heard_messages,
    heard_of,
    imu_messages,
    imu_of,
    packed,
    scan_messages,
    scans_of,
    unpacked,
)
from mjsim.record.tick import Event, Order, Tick
from mjsim.world.events import Event as WorldEvent
from mjsim.world.events import said_of

Message = dict[str, Any]

_WORLD_EVENT: TypeAdapter[WorldEvent] = TypeAdapter(WorldEvent)

_ENCODER = json.JSONEncoder(separators=(",", ":"), allow_nan=False, check_circular=False)
_LEVELS = {"changed": 2, "blocked": 2, "bump": 3, "fault": 4}
"""Information, warning and error, as Foxglove counts them."""


def encode(message: Message) -> bytes:
    """Return the JSON text of a message.

    Raises:
        ValueError: It holds NaN or -infinity, which no sensor and no module may give.
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


def _flat(values: ArrayLike) -> list[float]:
    flat: list[float] = np.asarray(values, dtype=float).ravel().tolist()
    return flat


def numbers(values: Sequence[float | None], *shape: int) -> Array:
    """Return an array of numbers read from JSON, in which None stands for +infinity."""
    array = np.array(values, dtype=float).reshape(shape or -1)
    array[np.isnan(array)] = np.inf
    return array


def nanoseconds(time: float) -> int:
    """Return a time as files carry it, rounded [ns]."""
    return round(time * 1e9)


def _stamp(time: float) -> Message:
    sec, nsec = divmod(nanoseconds(time), 1_000_000_000)
    return {"sec": sec, "nsec": nsec}


def pose_message(time: float, pose: Pose, covariance: ArrayLike | None = None) -> Message:
    """Return a pose in the world frame, as Foxglove draws it and exactly."""
    half = pose.heading / 2
    message: Message = {
        "timestamp": _stamp(time),
        "frame_id": "world",
        "pose": {
            "position": {"x": float(pose.x), "y": float(pose.y), "z": 0.0},
            "orientation": {"x": 0.0, "y": 0.0, "z": math.sin(half), "w": math.cos(half)},
        },
        "time": time,
        "heading": float(pose.heading),
    }
    if covariance is not None:
        message["covariance"] = _flat(covariance)
    return message


def pose_row(message: Message) -> tuple[float, float, float]:
    """Return (x, y, heading) of a pose message."""
    position = message["pose"]["position"]
    return position["x"], position["y"], message["heading"]


def _sighting_message(sighting: Sighting) -> Message:
    message = {
        "stamp": float(sighting.stamp),
        "range": float(sighting.range),
        "bearing": float(sighting.bearing),
        "covariance": _flat(sighting.covariance),
    }
    if sighting.name is not None:
        message["name"] = sighting.name
    if sighting.corners is not None:
        message["corners"] = _flat(sighting.corners)
    return message


def sightings_message(time: float, sightings: Sequence[Sighting]) -> Message:
    """Return all sightings of a tick."""
    return {"time": time, "sightings": [_sighting_message(sighting) for sighting in sightings]}


def sightings_of(message: Message) -> tuple[Sighting, ...]:
    """Return the sightings of a message that holds some."""
    return tuple(
        Sighting(
            stamp=item["stamp"],
            name=sys.intern(item["name"]) if item.get("name") is not None else None,
            range=_number(item["range"]),
            bearing=item["bearing"],
            covariance=numbers(item["covariance"], 2, 2),
            corners=numbers(item["corners"], -1, 2) if "corners" in item else None,
        )
        for item in message["sightings"]
    )


def _number(value: float | None) -> float:
    return math.inf if value is None else value


def observation_message(seen: Observation) -> Message:
    """Return every number of an observation, and which pictures came with it."""
    odometry = seen.odometry
    return {
        "time": float(seen.time),
        "dt": float(seen.dt),
        "odometry": {
            "forward": float(odometry.forward),
            "left": float(odometry.left),
            "turn": float(odometry.turn),
            "covariance": _flat(odometry.covariance),
        },
        "sightings": [_sighting_message(sighting) for sighting in seen.sightings],
        # Most rays meet nothing: writing None here spares `encode` a second pass.
        "proximity": [None if distance == math.inf else distance for distance in _flat(seen.proximity)],
        "bump": _flat(seen.bump),
        "cameras": [{"name": name, "stamp": float(frame.stamp)} for name, frame in seen.cameras.items()],
        "scans": scan_messages(seen.scans),
        "imu": imu_messages(seen.imu),
        "messages": heard_messages(seen.messages),
    }


def observation_of(message: Message) -> Observation:
    """Return the observation of a message, without its pictures."""
    odometry = message["odometry"]
    return Observation(
        time=message["time"],
        dt=message["dt"],
        odometry=Odometry(
            odometry["forward"], odometry["left"], odometry["turn"], numbers(odometry["covariance"], 3, 3)
        ),
        sightings=sightings_of(message),
        proximity=numbers(message["proximity"]),
        bump=tuple(message["bump"]),
        scans=scans_of(message.get("scans", ())),
        imu=imu_of(message.get("imu", ())),
        messages=heard_of(message.get("messages", ())),
    )


def _label(name: Hashable) -> tuple[str, bool]:
    """Return how a landmark's name is written, and whether it is a whole number."""
    return str(name), isinstance(name, int | np.integer) and not isinstance(name, bool)


def _labels(names: Sequence[Hashable]) -> Message:
    labels = [_label(name) for name in names]
    return {"names": [text for text, _ in labels], "numbered": [numbered for _, numbered in labels]}


def names_of(message: Message) -> tuple[Hashable, ...]:
    """Return the names of the landmarks that a message lists; any but whole numbers are text."""
    return tuple(
        _name(name, numbered=numbered) for name, numbered in zip(message["names"], message["numbered"], strict=True)
    )


def _name(text: str, *, numbered: bool) -> Hashable:
    """Return a landmark's name; a text is held once, however often it is read."""
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
        "timestamp": _stamp(time),
        "frame_id": "world",
        "time": time,
        "poses": [{"position": {"x": x, "y": y, "z": 0.0}, "orientation": upright} for x, y in means.tolist()],
        **_labels(names),
        "covariances": _flat(covariances),
    }


def landmarks_of(message: Message) -> tuple[tuple[Hashable, ...], Array, Array]:
    """Return names, means (k, 2) [m] and covariances (k, 2, 2) [m^2] of the map in a message."""
    names = names_of(message)
    means = [(pose["position"]["x"], pose["position"]["y"]) for pose in message["poses"]]
    covariances = np.reshape(numbers(message["covariances"]), (len(names), 2, 2))
    return names, np.array(means, dtype=float).reshape(-1, 2), covariances


def innovations_message(time: float, innovations: Sequence[tuple[Hashable, ArrayLike, ArrayLike]]) -> Message:
    """Return the innovations of a tick."""
    items = []
    for name, nu, S in innovations:
        text, numbered = _label(name)
        items.append({"name": text, "numbered": numbered, "nu": _flat(nu), "S": _flat(S)})
    return {"time": time, "innovations": items}


def innovations_of(message: Message) -> tuple[tuple[Hashable, Array, Array], ...]:
    """Return name, nu (2,) and S (2, 2) of each innovation of a message."""
    return tuple(
        (_name(item["name"], numbered=item["numbered"]), numbers(item["nu"]), numbers(item["S"], 2, 2))
        for item in message["innovations"]
    )


def covariance_message(time: float, estimate: Estimate, joint: Array) -> Message:
    """Return the joint covariance of an estimate, of which half is enough."""
    return {
        "time": time,
        **_labels(list(estimate.landmarks)),
        "size": len(joint),
        "lower": packed(joint[np.tril_indices(len(joint))]),
    }


def covariance_of(message: Message) -> Array:
    """Return the joint covariance of a message, shape (3 + 2 n, 3 + 2 n)."""
    size = message["size"]
    P = np.zeros((size, size))
    P[np.tril_indices(size)] = unpacked(message["lower"])
    return P + np.tril(P, -1).T


def command_message(time: float, order: Order) -> Message:
    """Return what the drive is told and what was wanted."""
    return {"time": time, "command": _command(order.command), "wanted": _command(order.wanted)}


def _command(command: Command | WheelCommand) -> Message:
    if isinstance(command, WheelCommand):
        return {"wheels": _flat(command.speeds)}
    told: Message = {"forward": float(command.forward), "left": float(command.left), "turn": float(command.turn)}
    if command.messages:
        told["messages"] = [message_text(message) for message in command.messages]
    return told


def command_row(message: Message) -> tuple[float, float, float]:
    """Return (forward, left, turn) told to the drive; NaN for wheel speeds."""
    command = message["command"]
    return command.get("forward", math.nan), command.get("left", math.nan), command.get("turn", math.nan)


def event_message(robot: str, event: Event) -> Message:
    """Return an event as a line of a log."""
    message = {
        "timestamp": _stamp(event.time),
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


def event_of(message: Message) -> Event:
    """Return the event of a message."""
    return Event(message["time"], message["kind"], message["message"], message.get("bearing"))


def world_event_message(time: float, event: WorldEvent) -> Message:
    """Return what happened to the world as a line of a log, and exactly."""
    return {
        "timestamp": _stamp(time),
        "level": 2,
        "message": said_of(event),
        "name": "world",
        "file": "",
        "line": 0,
        "time": float(time),
        "event": event.model_dump(mode="json", exclude_none=True) | {"time": float(time)},
    }


def world_event_of(message: Message) -> WorldEvent:
    """Return the event of a message."""
    event: WorldEvent = _WORLD_EVENT.validate_python(message["event"])
    return event


def things_message(time: float, things: Mapping[str, Pose]) -> Message:
    """Return where everything is that can move but robots."""
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
    return {"time": float(tick.time), "qpos": _flat(tick.qpos), "qvel": _flat(tick.qvel)}


def timing_message(tick: Tick, clock: float) -> Message:
    """Return what each part of the loop cost on the clock."""
    costs = [(f"loop/{part}", seconds) for part, seconds in tick.timing.items()]
    costs += [
        (f"{name}/{part}", seconds) for name, order in tick.orders.items() for part, seconds in order.timing.items()
    ]
    return {
        "time": float(tick.time),
        "clock": clock,
        "parts": [{"part": part, "seconds": float(seconds)} for part, seconds in costs],
    }
