"""Values as trees of named numbers, strings and arrays, for modules in other languages.

A tree contains dicts, lists, texts, numbers, None and arrays. A one-dimensional array is a vector. `Stack` and `Named`
mark what languages represent differently: several items of one shape, and names chosen by the user.
"""

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.interface.forms import Form, FormField, ReadingType, batch_rows, form_fields
from mjsim.interface.readings import (
    AnchorRanges,
    CameraFrame,
    FastReading,
    ImuReading,
    Intrinsics,
    JointState,
    Observation,
    Picture,
    Scan,
    Sighting,
)
from mjsim.interface.values import (
    ArmInfo,
    BeaconInfo,
    Command,
    Estimate,
    JointGoal,
    RobotInfo,
    WheelCommand,
    WorldMap,
)

if TYPE_CHECKING:
    from mjsim.mechanics import Arm

Tree = Any
"""A dict, list, text, number, None, array, `Stack`, `Named` or `RecordList`."""


@dataclass(frozen=True, slots=True, eq=False)
class Stack:
    """Several numbers, vectors or matrices of one shape; the item index is the first in JSON, the last in Octave."""

    items: Array
    """Shape (n, ...)."""


class Named(dict[str, Tree]):
    """A dict whose keys are names chosen by the user; languages with stricter rules change them."""


@dataclass(frozen=True, slots=True, eq=False)
class RecordList:
    """A list of dicts that all have the same keys, also when it is empty."""

    keys: Sequence[str]
    rows: Sequence[Mapping[str, Tree]]


@dataclass(frozen=True, slots=True, eq=False)
class Text:
    """A string that differs from tick to tick, such as a message."""

    text: str


@dataclass(slots=True)
class Numbers:
    """Numbers for names of beacons, from 1: first the catalogue, then others as they appear; 0 means unnamed."""

    names: list[str] = field(default_factory=list)

    def of(self, name: Hashable) -> int:
        """Return the number of a name; an integer above those of all names is kept, any other non-text gives 0."""
        if isinstance(name, int) and not isinstance(name, bool):
            return name if name > len(self.names) else 0
        if not isinstance(name, str):
            return 0
        if name not in self.names:
            self.names.append(name)
        return self.names.index(name) + 1


def observation_tree(seen: Observation, numbers: Numbers, *, pictures: bool) -> dict[str, Tree]:
    """Return the tree of an observation; pictures, which take time to render, only on request."""
    return {
        "time": seen.time,
        "dt": seen.dt,
        **_sightings(seen.sightings, numbers),
        **{
            part.name: _field(part, form, getattr(seen, part.name))
            for part, form in form_fields(Observation)
            if part.name not in OWN_FORM
        },
        "scans": Named({name: _scan(scan) for name, scan in seen.scans.items()}),
        "cameras": Named({name: _camera(frame) for name, frame in seen.cameras.items()} if pictures else {}),
        "ranges": Named({name: _ranges(tag, numbers) for name, tag in seen.ranges.items()}),
        "joints": Named({name: joint_tree(state) for name, state in seen.joints.items()}),
    }


OWN_FORM = {"sightings", "scans", "cameras", "ranges", "joints"}
"""Readings that programs get in a form of their own; all others have the fields that they declare."""


def _field(part: FormField, form: Form, value: Any) -> Tree:
    """Return the readings in a field of an observation."""
    if part.is_batch:
        return Stack(batch_rows(part.item, value))
    if not part.has_readings:
        return _stack(value)
    if part.is_mapping:
        return Named({name: _reading(reading) for name, reading in value.items()})
    if part.is_tuple:
        return RecordList([each.name for each, _ in form_fields(part.item)], [_reading(reading) for reading in value])
    return _reading(value)


def _reading(reading: Any) -> dict[str, Tree]:
    """Return the declared fields of a reading; those that are None are left out."""
    kind: ReadingType = type(reading)
    return {
        part.name: _value(part, value)
        for part, _ in form_fields(kind)
        if (value := getattr(reading, part.name)) is not None
    }


def _value(part: FormField, value: Any) -> Tree:
    """Return a number, a text, an array of fixed shape, or a list, with the item index first."""
    if isinstance(value, str):
        return Text(value)
    is_fixed = part.form is not None and -1 not in part.form.shape
    return value if is_fixed or not isinstance(value, tuple | np.ndarray) else _stack(value, np.shape(value)[1:])


def _sightings(sightings: Sequence[Sighting], numbers: Numbers) -> dict[str, Tree]:
    return {
        "z": _stack([(each.range, each.bearing) for each in sightings], (2,)),
        "id": _stack([numbers.of(each.name) for each in sightings]),
        "R": _stack([each.covariance for each in sightings], (2, 2)),
        "stamp": _stack([each.stamp for each in sightings]),
    }


def _ranges(tag: AnchorRanges, numbers: Numbers) -> dict[str, Tree]:
    heard = {"id": _stack([numbers.of(anchor) for anchor in tag.ranges]), "range": _stack([*tag.ranges.values()])}
    return {"stamp": tag.stamp, **heard, "variance": tag.variance}


def estimate_tree(belief: Estimate, numbers: Numbers) -> dict[str, Tree]:
    """Return an estimate; a landmark number that belongs to no beacon is kept as its name."""
    return {
        "pose": belief.pose.as_array(),
        "covariance": belief.covariance,
        "landmarks": _stack([mean for mean, _ in belief.landmarks.values()], (2,)),
        "landmark_covariance": _stack([P for _, P in belief.landmarks.values()], (2, 2)),
        "ids": _stack([numbers.of(name) for name in belief.landmarks]),
    }


def command_tree(command: Command | WheelCommand) -> dict[str, Tree]:
    """Return the tree of a command, without its messages."""
    if isinstance(command, WheelCommand):
        return {"wheels": _stack(command.speeds)}
    goals = Named({name: _goal(goal) for name, goal in command.joints.items()})
    return {"forward": command.forward, "left": command.left, "turn": command.turn, "joints": goals}


def _goal(goal: JointGoal) -> dict[str, Tree]:
    parts = {"q": goal.positions, "qd": goal.velocities, "qdd": goal.accelerations, "tau": goal.torques}
    return {key: None if part is None else np.array(part) for key, part in parts.items()}


def fast_tree(sensed: FastReading) -> dict[str, Tree]:
    """Return the tree of a controller's inputs."""
    return {
        "time": sensed.time,
        "dt": sensed.dt,
        "joints": Named({name: joint_tree(state) for name, state in sensed.joints.items()}),
        "wheels": joint_tree(sensed.wheels),
        "imu": Stack(batch_rows(ImuReading, sensed.imu)),
    }


def joint_tree(state: JointState) -> dict[str, Tree]:
    """Return the state of joints, or of wheels."""
    return {"stamp": state.stamp, "q": state.positions, "qd": state.velocities, "tau": state.torques}


def robot_tree(
    robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], map: WorldMap | None, *, pictures: bool
) -> dict[str, Tree]:
    """Return the inputs of a module before the first tick: robot, catalogue, and the map if known."""
    return {
        **_sheet(robot),
        "outline": None if robot.outline is None else Stack(robot.outline),
        "catalogue": RecordList(
            ("name", "width", "height", "pose", "center", "marker", "anchor", "image"),
            [_sheet(beacon) | {"image": _image(beacon) if pictures else None} for beacon in catalogue.values()],
        ),
        "map": None if map is None else _map(map),
    }


def _image(beacon: BeaconInfo) -> Picture | None:
    return None if beacon.picture is None else np.asarray(beacon.picture)


_NO_DATA = {"picture", "model"}
"""Fields of data sheets that are more than numbers and texts."""


def _sheet(value: Any) -> Tree:
    """Return a data sheet, or a value in it."""
    if isinstance(value, Pose):
        return value.as_array()
    if isinstance(value, Intrinsics):
        size = {"width": value.width, "height": value.height, "matrix": value.matrix()}
        return {**size, "lens": value.lens, "distortion": _stack(value.distortion)}
    if isinstance(value, ArmInfo):
        told = {name: getattr(value, name) for name in ("joints", "lower", "upper", "max_velocity", "max_torque")}
        return {**told, "joints": [*value.joints], **_arm(value.model)}
    if is_dataclass(value):
        return {part.name: _sheet(getattr(value, part.name)) for part in fields(value) if part.name not in _NO_DATA}
    if isinstance(value, Mapping):
        return Named({name: _sheet(each) for name, each in value.items()})
    if isinstance(value, tuple):
        return [*value] if all(isinstance(each, str) for each in value) else np.array(value)
    return value


def _arm(arm: "Arm") -> dict[str, Tree]:
    """Return geometry, masses and motors of an arm: what its kinematics and dynamics need."""
    links = arm.links
    return {
        "base": arm.base,
        "tool": arm.flange @ arm.tool,
        "gravity": np.array(arm.gravity),
        "carrier": arm.carrier,
        "parents": np.array(arm.parents, dtype=float),
        "slide": np.array([float(link.slide) for link in links]),
        "before": Stack(np.array([link.before for link in links])),
        "after": Stack(np.array([link.after for link in links])),
        "mass": np.array([link.mass for link in links]),
        "center": Stack(np.array([link.center for link in links])),
        "inertia": Stack(np.array([link.inertia for link in links])),
        "gear": np.array([link.gear for link in links]),
        "rotor_inertia": np.array([link.rotor_inertia for link in links]),
        "viscous": np.array([link.viscous for link in links]),
        "coulomb": Stack(np.array([link.coulomb for link in links])),
    }


def _map(map: WorldMap) -> dict[str, Tree]:
    beacons = [{"name": name, "pose": pose.as_array()} for name, pose in map.beacons.items()]
    return {"segments": Stack(map.segments), "beacons": RecordList(("name", "pose"), beacons)}


def _scan(scan: Scan) -> dict[str, Tree]:
    beams = {"stamp": scan.stamp, "ranges": Stack(scan.ranges), "angles": Stack(scan.angles())}
    bounds = {"range_min": scan.range_min, "range_max": scan.range_max}
    if scan.time_increment is not None:
        bounds["time_increment"] = scan.time_increment
    return {**beams, **bounds} | ({} if scan.intensities is None else {"intensities": Stack(scan.intensities)})


def _camera(frame: CameraFrame) -> dict[str, Tree]:
    tree: dict[str, Tree] = {"stamp": frame.stamp, "image": np.asarray(frame.image)}
    if frame.depth is not None:
        tree["depth"] = frame.depth
    if frame.segmentation is not None:
        tree |= {"segmentation": frame.segmentation, "instances": list(frame.instances)}
    return tree


def _stack(items: Any, shape: tuple[int, ...] = ()) -> Stack:
    return Stack(np.array(items, dtype=float).reshape(-1, *shape))
