"""Converts responses of modules in other languages to values of the simulator."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mjsim.errors import did_you_mean
from mjsim.geometry import Array, Pose
from mjsim.interface import Command, Estimate, JointGoal, Numbers, Observation, Sighting, WheelCommand
from mjsim.modules.covariances import Unfit
from mjsim.modules.foreign.shown_values import shown_of
from mjsim.sentences import Sentence

Answer = Mapping[str, Any]
"""By field: an array, nested lists, or a text that describes its type."""
FIELDS: Mapping[str, Sequence[str]] = {
    "estimator": (
        *("pose", "covariance", "landmarks", "landmark_covariance", "ids", "joint_covariance"),
        *("innovations", "innovation_covariance", "innovation_ids", "show"),
    ),
    "navigator": ("forward", "left", "turn", "wheels", "joints", "messages", "show"),
    "observer": ("id", "range", "bearing", "R"),
    "avoidance": ("forward", "left", "turn", "wheels", "joints"),
    "controller": ("",),
}
"""Role -> fields of its answer; '' is the whole answer."""

NO_STRUCT = ", not of struct"
"""Suffix that `mjsim_pack.m` adds for a value without fields."""


def estimate_of(answer: Answer, numbers: Numbers, *, counts_last: bool) -> Estimate:
    """Return the estimate of an answer.

    Args:
        answer: Its fields.
        numbers: Numbers of the beacons by name.
        counts_last: Whether the item index of stacks is the last, as in Octave.
    """
    take = _Taker(answer, "est", counts_last)
    pose = Pose(*take.vector("pose", 3).tolist())
    means, covariances = take.stack("landmarks", (2,)), take.stack("landmark_covariance", (2, 2))
    names = _names(take.stack("ids", ()), len(means), numbers, "landmarks")
    if len(covariances) != len(means):
        raise Unfit(
            Sentence(
                "returned {count} landmarks with {other_count} covariances; each needs one",
                len(means),
                len(covariances),
            )
        )
    nu, S = take.stack("innovations", (2,)), take.stack("innovation_covariance", (2, 2))
    if len(nu) != len(S):
        raise Unfit(
            Sentence("returned {count} innovations with {other_count} covariances; each needs one", len(nu), len(S))
        )
    about = _names(take.stack("innovation_ids", ()), len(nu), numbers, "innovations", twice=True)
    joint = take.get("joint_covariance")
    return Estimate(
        pose=pose,
        covariance=take.matrix("covariance"),
        landmarks=dict(zip(names, zip(means, covariances, strict=True), strict=True)),
        innovations=tuple(zip(about, nu, S, strict=True)),
        joint_covariance=None if joint is None else take.matrix("joint_covariance"),
        show=shown_of(take.get("show")),
    )


def command_of(answer: Answer, arms: Mapping[str, str], *, counts_last: bool) -> Command | WheelCommand:
    """Return the command of an answer: for the wheels, or for the robot; missing numbers are 0.

    Args:
        answer: Its fields.
        arms: Name of each arm in the language -> its name.
        counts_last: As for `estimate_of`.
    """
    take = _Taker(answer, "cmd", counts_last)
    if take.get("wheels") is not None:
        return WheelCommand(tuple(take.stack("wheels", ()).tolist()))
    if not any(take.get(name) is not None for name in ("forward", "left", "turn", "joints")):
        raise Unfit("returned a cmd without forward, left, turn, wheels or joints; it must have one of them")
    forward, left, turn = (
        take.number(name) if take.get(name) is not None else 0.0 for name in ("forward", "left", "turn")
    )
    messages = take.get("messages")
    if messages is None or (isinstance(messages, np.ndarray) and not messages.size):
        messages = ()
    messages = tuple(messages) if isinstance(messages, list) else messages
    return Command(forward, left, turn, messages, _goals(take.get("joints"), arms))


def _goals(joints: Any, arms: Mapping[str, str]) -> dict[str, JointGoal]:
    """Return the goals of arms."""
    if joints is None:
        return {}
    if not isinstance(joints, Mapping) or not all(isinstance(goal, Mapping) for goal in joints.values()):
        raise Unfit("returned cmd.joints that is not a struct of structs; write cmd.joints.ARM.q = ...")
    goals = {}
    for name, goal in joints.items():
        if name not in arms:
            raise Unfit(Sentence("returned cmd.joints.{name}{did_you_mean}", name, did_you_mean(name, arms)))
        take = _Taker({key: part for key, part in goal.items() if part is not None}, f"cmd.joints.{name}", False)
        q, qd, qdd, tau = (take.numbers(key) for key in ("q", "qd", "qdd", "tau"))
        if q is None:
            raise Unfit(Sentence("returned no cmd.joints.{name}.q", name))
        goals[arms[name]] = JointGoal(positions=q, velocities=qd, accelerations=qdd, torques=tau)
    return goals


def sightings_of(answer: Answer, numbers: Numbers, seen: Observation, *, counts_last: bool) -> list[Sighting]:
    """Return the sightings of an answer."""
    take = _Taker(answer, "z", counts_last)
    ids, ranges, bearings = (take.stack(name, ()) for name in ("id", "range", "bearing"))
    R = take.stack("R", (2, 2))
    if not len(ids) == len(ranges) == len(bearings) == len(R):
        counts = f"{len(ids)} id, {len(ranges)} range, {len(bearings)} bearing, {len(R)} R"
        raise Unfit(Sentence("returned z with {counts}; it must have as many of each", counts))
    return [
        Sighting(seen.time, _name(number, numbers), distance, bearing, P)
        for number, distance, bearing, P in zip(ids.tolist(), ranges.tolist(), bearings.tolist(), R, strict=True)
    ]


def torques_of(answer: Answer, *, counts_last: bool) -> Sequence[float]:
    """Return the torques of an answer."""
    torques: list[float] = _Taker(answer, "tau", counts_last).stack("", ()).tolist()
    return torques


class _Taker:
    """Extracts fields of an answer, and checks their shapes."""

    def __init__(self, answer: Answer, of: str, counts_last: bool) -> None:
        self._answer, self._of, self._counts_last = answer, of, counts_last

    def get(self, name: str) -> Any:
        return self._answer.get(name)

    def number(self, name: str) -> float:
        array = self._array(name)
        if array.size != 1:
            raise self._wrong(name, array, "one number")
        return float(array.ravel()[0])

    def numbers(self, name: str) -> tuple[float, ...] | None:
        """Return numbers in a row or a column; None if the field is missing or empty."""
        array = np.zeros(0) if self.get(name) is None else self._array(name)
        return tuple(array.ravel().tolist()) if array.size else None

    def vector(self, name: str, size: int) -> Array:
        array = self._array(name)
        if array.size != size or max(array.shape, default=0) != size:
            raise self._wrong(name, array, f"{size} numbers")
        return array.ravel()

    def matrix(self, name: str) -> Array:
        return self._array(name)

    def stack(self, name: str, shape: tuple[int, ...]) -> Array:
        """Return items of a shape with the item index first, shape (n, ...); none if the field is missing or empty."""
        if self.get(name) is None:
            return np.zeros((0, *shape))
        array = self._array(name)
        if not array.size:
            return np.zeros((0, *shape))
        if not shape and array.size == max(array.shape, default=1):
            return array.ravel()
        if self._counts_last:
            # Octave drops a last dimension of 1.
            items = np.moveaxis(array.reshape(*array.shape, *[1] * (len(shape) + 1 - array.ndim)), -1, 0)
        else:
            items = array
        if not shape or items.shape[1:] != shape:
            sides = "1" if not shape else " x ".join(map(str, shape))
            raise self._wrong(name, array, f"{sides} x n" if self._counts_last else f"n x {sides}")
        return np.ascontiguousarray(items)

    def _array(self, name: str) -> Array:
        value, label = self.get(name), self._called(name)
        if value is None:
            raise Unfit(Sentence("returned no {label}", label))
        if isinstance(value, str):
            if value.endswith(NO_STRUCT):
                raise Unfit(
                    Sentence(
                        "returned {of} that is {value}; it must be a struct", self._of, value.removesuffix(NO_STRUCT)
                    )
                )
            raise Unfit(Sentence("returned {label} that is {value}; it must hold real numbers", label, value))
        try:
            made = np.asarray(value)
            numbers = np.asarray(made, dtype=float)
        except (TypeError, ValueError):
            raise Unfit(
                Sentence("returned {label} that holds something other than numbers, or rows that differ", label)
            ) from None
        except OverflowError:
            raise Unfit(Sentence("returned {label} that holds a number beyond 1e308", label)) from None
        if made.dtype.kind in "US":
            # NumPy reads numbers in texts; the schema of programs does not allow them.
            raise Unfit(Sentence("returned {label} that holds text; write numbers without quotes", label))
        return numbers

    def _called(self, name: str) -> str:
        return f"{self._of}.{name}" if name else self._of

    def _wrong(self, name: str, array: Array, right: str) -> Unfit:
        sides = " x ".join(map(str, array.shape)) or "1"
        return Unfit(Sentence("returned {called} of {sides}; it must be {right}", self._called(name), sides, right))


def _names(ids: Array, count: int, numbers: Numbers, label: str, *, twice: bool = False) -> list[str | int]:
    """Return the names of landmarks: of the beacon, or its number, or else the index."""
    if not len(ids):
        return list(range(1, count + 1))
    if len(ids) != count:
        raise Unfit(
            Sentence(
                "returned {count} {label} with {other_count} ids; each needs one, 0 for one without a name",
                count,
                label,
                len(ids),
            )
        )
    names = [_name(number, numbers, otherwise=True) or place for place, number in enumerate(ids.tolist(), start=1)]
    if not twice and len(set(names)) < count:
        again = next(name for name in names if names.count(name) > 1)
        raise Unfit(Sentence("returned two {label} called {again!r}; each id stands for one", label, again))
    return names


def _name(number: float, numbers: Numbers, *, otherwise: bool = False) -> Any:
    """Return the name for a number: None for 0; numbers of no beacon are kept where that is allowed."""
    if not float(number).is_integer() or number < 0:
        raise Unfit(Sentence("returned the id {number:g}; ids are whole numbers, 0 for none", number))
    if number == 0:
        return None
    if number <= len(numbers.names):
        return numbers.names[int(number) - 1]
    if not otherwise:
        raise Unfit(
            Sentence("returned the id {number:g}; the catalogue has {count} beacons", number, len(numbers.names))
        )
    return int(number)
