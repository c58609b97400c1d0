"""Checks of the results of user modules; Unfit says what is wrong."""

import inspect
import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np

from mjsim.errors import did_you_mean
from mjsim.geometry import Array, Pose
from mjsim.interface import (
    Command,
    Estimate,
    JointGoal,
    RobotInfo,
    Shown,
    ShownGrid,
    ShownLines,
    ShownPoints,
    ShownText,
    Sighting,
    WheelCommand,
    message_text,
    require_bounds,
)
from mjsim.modules.covariances import Unfit, covariance, has_good_diagonal, is_plainly_good, real_array
from mjsim.sentences import Sentence

SHOWN = (ShownPoints, ShownLines, ShownGrid, ShownText)
SHOWN_KINDS = ", ".join(kind.__name__ for kind in SHOWN)
MAX_REASON_LENGTH = 200
"""Maximum length of the reason why a robot is blocked [characters]."""


def checked_command(command: object, robot: RobotInfo) -> Command | WheelCommand:
    """Check that a command is finite and fits the robot; return it with floats."""
    if isinstance(command, WheelCommand):
        return WheelCommand(checked_wheel_speeds(command.speeds, robot.wheels))
    if not isinstance(command, Command):
        raise Unfit(Sentence("returned {command}; it must be a Command or a WheelCommand", kind_of(command)))
    forward, left, turn = command.forward, command.left, command.turn
    messages, joints = command.messages, command.joints
    plain = type(command) is Command and type(forward) is type(left) is type(turn) is float and type(joints) is dict
    if plain and type(messages) is tuple and not (messages or joints) and math.isfinite(forward + left + turn):
        return command
    forward, left, turn = _finite("a command", (forward, left, turn))
    return Command(forward, left, turn, _checked_messages(messages), _checked_goals(joints, robot))


def checked_estimate(belief: object, *, whole: bool = True) -> Estimate:
    """Check that an estimate is finite, has arrays of the right shapes, and valid covariances; return it.

    Args:
        belief: Result of the estimator; a subclass of Estimate is kept.
        whole: Whether to check the whole joint covariance instead of its shape and diagonal.
    """
    if not isinstance(belief, Estimate):
        raise Unfit(Sentence("returned {belief}; it must be an Estimate", kind_of(belief)))
    fit: dict[str, Any] = {}
    pose = checked_pose(belief.pose)
    if pose is not belief.pose:
        fit["pose"] = pose
    P = covariance("the covariance of the pose", belief.covariance, 3)
    if P is not belief.covariance:
        fit["covariance"] = P
    landmarks = belief.landmarks
    if not isinstance(landmarks, Mapping):
        raise Unfit(
            Sentence(
                "returned landmarks that are {landmarks}; they must be a dict: name -> (mean, covariance)",
                kind_of(landmarks),
            )
        )
    if not all(map(_is_plain_landmark, landmarks.values())):
        fit["landmarks"] = _checked_landmarks(landmarks)
    innovations = belief.innovations
    if type(innovations) is not tuple or not all(map(_is_plain_innovation, innovations)):
        fit["innovations"] = _checked_innovations(innovations)
    joint = belief.joint_covariance
    if joint is not None:
        checked = _checked_joint(joint, 3 + 2 * len(landmarks), whole=whole)
        if checked is not joint:
            fit["joint_covariance"] = checked
    if type(belief.show) is not tuple or belief.show:
        fit["show"] = checked_show(belief.show)
    return replace(belief, **fit) if fit else belief


def checked_sightings(sightings: object) -> Sequence[Sighting]:
    """Check that sightings are finite and have valid covariances; return them."""
    if not isinstance(sightings, Sequence) or isinstance(sightings, (str, bytes)):
        raise Unfit(Sentence("returned {sightings}; it must be a list of Sighting", kind_of(sightings)))
    return [_checked_sighting(seen) for seen in sightings]


def checked_show(show: object) -> tuple[Shown, ...]:
    """Check the items that a module shows, and return them; raises Unfit with the problem."""
    if not isinstance(show, (tuple, list)):
        raise Unfit(
            Sentence("returned a show that is {show}; it must be a tuple of {shown_kinds}", kind_of(show), SHOWN_KINDS)
        )
    for item in show:
        if not isinstance(item, SHOWN):
            raise Unfit(
                Sentence("returned {item} in its show; each must be one of {shown_kinds}", kind_of(item), SHOWN_KINDS)
            )
    try:
        require_bounds(show)
    except ValueError as error:
        raise Unfit(Sentence("returned a show in which {error}", error)) from None
    return tuple(show)


def checked_reason(reason: object) -> str | None:
    """Check and return the reason why a navigator reports its robot as blocked; None if it is not."""
    if reason is None:
        return None
    if not isinstance(reason, str) or not reason.isprintable() or not 0 < len(reason) <= MAX_REASON_LENGTH:
        raise Unfit(
            Sentence(
                "returned {reason}; it must be None or 1 to {max_reason_length} printable characters",
                kind_of(reason),
                MAX_REASON_LENGTH,
            )
        )
    return reason


def checked_lost(lost: object) -> bool:
    """Check and return whether an estimator reports its robot as lost."""
    if not isinstance(lost, (bool, np.bool_)):
        raise Unfit(Sentence("returned {lost}; it must be True or False", kind_of(lost)))
    return bool(lost)


def checked_path(path: object) -> Array:
    """Check a trajectory; return rows of time [s], x, y [m] and heading [rad], shape (M, 4)."""
    if not isinstance(path, Sequence) or isinstance(path, (str, bytes)):
        raise Unfit(Sentence("returned {path}; it must be a list of (time, Pose)", kind_of(path)))
    rows = []
    for item in path:
        time, pose = _parts("a point of the path", item, ("time", "pose"))
        place = checked_pose(pose)
        rows.append((*_finite("a time", (time,)), place.x, place.y, place.heading))
    found = np.array(rows, dtype=float).reshape(-1, 4)
    if (np.diff(found[:, 0]) <= 0.0).any():
        raise Unfit("returned a path whose times do not ascend; each must be later than the one before")
    return found


def checked_pose(pose: object) -> Pose:
    """Check that a pose is finite; return it with floats."""
    if not isinstance(pose, Pose):
        raise Unfit(Sentence("returned a pose that is {pose}; it must be a Pose", kind_of(pose)))
    x, y, heading = pose.x, pose.y, pose.heading
    if type(x) is type(y) is type(heading) is float and math.isfinite(x + y + heading):
        return pose
    return Pose(*_finite("a pose", (x, y, heading)))


def kind_of(value: object) -> str:
    """Return the kind of a value for a message; a coroutine is closed."""
    if inspect.iscoroutine(value):
        value.close()
        return "a coroutine, which `async def` makes"
    if isinstance(value, type):
        return Sentence("the class {name}", value.__name__)
    return "None" if value is None else Sentence("a value of type {type}", type(value).__name__)


def checked_wheel_speeds(speeds: Any, wheels: Sequence[str]) -> tuple[float, ...]:
    """Check the speeds of the wheels; return them as floats [rad/s]."""
    return _finite(
        "a list of wheel speeds",
        _several("wheel speeds", speeds, len(wheels), Sentence("the wheels are {wheels}", ", ".join(wheels))),
    )


def checked_torques(torques: Any, motors: Sequence[str]) -> tuple[float, ...]:
    """Check the torques of the motors; return them as floats [N m]."""
    right = Sentence("the motors are {motors}", ", ".join(motors))
    return _finite("a list of torques", _several("torques", torques, len(motors), right))


def checked_twist(twist: Any) -> tuple[float, float, float]:
    """Check that a twist (forward, left, turn) is finite; return it as floats."""
    forward, left, turn = _finite("a twist", _several("numbers of a twist", twist, 3, "they are forward, left, turn"))
    return forward, left, turn


def checked_wheel_names(names: Any) -> tuple[str, ...]:
    """Check the names of a drive's wheels; return them."""
    if isinstance(names, (tuple, list)) and names and all(isinstance(name, str) for name in names):
        return tuple(map(str, names))
    raise Unfit(
        Sentence("has wheels that are {names}; they must be a tuple of the names of its hinges", kind_of(names))
    )


def _several(label: str, values: Any, count: int, right: str) -> Any:
    """Check that a value is a sequence of a given length; return it."""
    if not hasattr(type(values), "__len__") or isinstance(values, (str, bytes)):
        raise Unfit(Sentence("returned {label} that are {values}; {right}", label, kind_of(values), right))
    if len(values) != count:
        raise Unfit(Sentence("returned {count} {label}; {right}", len(values), label, right))
    return values


def _checked_goals(joints: object, robot: RobotInfo) -> dict[str, JointGoal]:
    """Check that goals are finite, for existing arms, with one number per joint; return them."""
    if not isinstance(joints, Mapping):
        raise Unfit(
            Sentence("returned joints that are {joints}; they must be a dict: arm -> JointGoal", kind_of(joints))
        )
    goals = {}
    for arm, goal in joints.items():
        if arm not in robot.arms:
            raise Unfit(Sentence("returned a goal for arm '{arm}'{meant}", arm, did_you_mean(str(arm), robot.arms)))
        if not isinstance(goal, JointGoal):
            raise Unfit(
                Sentence("returned a goal of arm '{arm}' that is {goal}; it must be a JointGoal", arm, kind_of(goal))
            )
        goals[arm] = _checked_goal(goal, arm, robot.arms[arm].joints)
    return goals


def _checked_goal(goal: JointGoal, arm: str, joints: Sequence[str]) -> JointGoal:
    right, parts = Sentence("arm '{arm}' has the joints {joints}", arm, ", ".join(joints)), {}
    for part in fields(JointGoal):
        values = getattr(goal, part.name)
        if values is not None or part.name == "positions":
            parts[part.name] = _finite(
                Sentence("a goal with {name}", part.name), _several(part.name, values, len(joints), right)
            )
    return JointGoal(**parts)


def _checked_messages(messages: object) -> tuple[Any, ...]:
    if not isinstance(messages, (tuple, list)):
        raise Unfit(
            Sentence(
                "returned messages that are {messages}; they must be a tuple, one item a message", kind_of(messages)
            )
        )
    for message in messages:
        try:
            message_text(message)
        except ValueError as error:
            raise Unfit(Sentence("returned {error}", error)) from None
    return tuple(messages)


def _checked_sighting(seen: object) -> Sighting:
    if not isinstance(seen, Sighting):
        raise Unfit(Sentence("returned {seen} in its list; each must be a Sighting", kind_of(seen)))
    if seen.name is not None and not isinstance(seen.name, str):
        raise Unfit(Sentence("returned a sighting whose name is {name}; it must be a str, or None", kind_of(seen.name)))
    R = covariance("the covariance of a sighting", seen.covariance, 2)
    stamp, distance, bearing = _finite("a sighting", (seen.stamp, seen.range, seen.bearing))
    if distance < 0.0:
        raise Unfit(Sentence("returned a sighting at range {distance:g} m; it must not be negative", distance))
    corners = seen.corners
    if corners is not None:
        corners = real_array("the corners of a sighting", corners, (4, 2))
    if R is seen.covariance and corners is seen.corners and type(seen.range) is type(seen.bearing) is float:
        return seen
    return Sighting(stamp, seen.name, distance, bearing, R, corners)


def _is_plain_landmark(pair: Any) -> bool:
    """Return whether mean and covariance are valid arrays of doubles; False means that they need a full check."""
    return type(pair) is tuple and len(pair) == 2 and _is_plain_gaussian(*pair)


def _is_plain_innovation(item: Any) -> bool:
    """The same for (name, nu, S)."""
    return type(item) is tuple and len(item) == 3 and isinstance(item[0], (str, int)) and _is_plain_gaussian(*item[1:])


def _is_plain_gaussian(mean: Any, P: Any) -> bool:
    """The same for a mean (2,) and its covariance (2, 2)."""
    if not (type(mean) is np.ndarray and mean.shape == (2,) and mean.dtype == np.float64):
        return False
    x, y = mean.tolist()
    return math.isfinite(x + y) and is_plainly_good(P, 2)


def _checked_landmarks(landmarks: Mapping[Hashable, tuple[Array, Array]]) -> dict[Hashable, tuple[Array, Array]]:
    fit = {}
    for name, pair in landmarks.items():
        mean, P = _parts(Sentence("landmark {name}", _short(name)), pair, ("mean", "covariance"))
        fit[name] = (
            real_array(Sentence("the mean of landmark {name}", _short(name)), mean, (2,)),
            covariance(Sentence("the covariance of landmark {name}", _short(name)), P, 2),
        )
    return fit


def _checked_innovations(innovations: object) -> tuple[tuple[Hashable, Array, Array], ...]:
    if not isinstance(innovations, (tuple, list)):
        raise Unfit(
            Sentence(
                "returned innovations that are {innovations}; they must be a tuple of (name, nu, S)",
                kind_of(innovations),
            )
        )
    fit = []
    for item in innovations:
        name, nu, S = _parts("an innovation", item, ("name", "nu", "S"))
        if not isinstance(name, Hashable):
            raise Unfit(
                Sentence(
                    "returned an innovation whose name is {name}; it must be hashable, such as a str", kind_of(name)
                )
            )
        hash(name)
        about = Sentence("the innovation of {name}", _short(name))
        fit.append((name, real_array(about, nu, (2,)), covariance(Sentence("the covariance of {about}", about), S, 2)))
    return tuple(fit)


def _checked_joint(joint: Any, size: int, *, whole: bool) -> Array:
    if not whole and has_good_diagonal(joint, size):
        return np.asarray(joint)
    return covariance("the joint covariance", joint, size)


def _parts(label: str, item: object, names: Sequence[str]) -> Sequence[Any]:
    """Check that a value is a tuple of the right length; return its parts."""
    if not isinstance(item, (tuple, list)) or len(item) != len(names):
        count = Sentence(" of {count}", len(item)) if isinstance(item, (tuple, list)) else ""
        raise Unfit(
            Sentence(
                "returned {label} that is {kind}{count}; it must be ({names})",
                *(label, kind_of(item), count, ", ".join(names)),
            )
        )
    return item


def _finite(label: str, values: Sequence[Any]) -> tuple[float, ...]:
    """Check that numbers are finite; return them as floats."""
    numbers = tuple(_number(label, value) for value in values)
    if not all(map(math.isfinite, numbers)):
        raise Unfit(Sentence("returned {label} that is not finite: {numbers}", label, list(numbers)))
    return numbers


def _number(label: str, value: Any) -> float:
    if isinstance(value, (float, int)):
        return float(value)
    array = np.asarray(value)
    if array.ndim != 0:
        raise Unfit(
            Sentence(
                "returned {label} that holds an array of shape {shape}; it must hold plain numbers", label, array.shape
            )
        )
    if array.dtype.kind == "c":
        raise Unfit(Sentence("returned {label} that is complex; it must be real", label))
    if array.dtype.kind not in "biuf":
        raise Unfit(
            Sentence("returned {label} that holds something other than numbers: {sample}", label, _short(value))
        )
    return float(array)


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
