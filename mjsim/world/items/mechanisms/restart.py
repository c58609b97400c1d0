"""Moving the start of a mechanism: joints moved by hand, loops closed again, and the keys to write."""

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from pydantic import ValidationError

from mjsim.geometry import Array
from mjsim.mechanics import BodyPoint, followed
from mjsim.sentences import Sentence
from mjsim.world.items.mechanisms.assembly import Assembly
from mjsim.world.items.mechanisms.beginning import first_rows
from mjsim.world.items.mechanisms.joints import MechanismJoint
from mjsim.world.items.mechanisms.mechanism import Mechanism

PLACES, EXACT = (4, 2), (9, 7)
"""Decimals written for metres and for degrees; and for values that close a loop together."""
MOVED = 1e-7
"""Values that differ by less did not move [rad, m]."""
ASTRAY = 0.02
"""A loop that ends this far from the followed motion has closed in another configuration [rad, m]."""
STILL = 1e-10
"""The search for the position of a point ends with relative steps below this."""
FLAT = 0.05
"""A value that moves a point by less than this fraction of its path in a drawing is not visible there."""

Keys = Mapping[tuple[int, str], float | list[float]]
"""By the number of a joint and its key: the value to write [deg, m]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Restart:
    """A mechanism with other start values."""

    mechanism: Mechanism
    keys: Keys
    """Keys of its text that make it start there."""


def free_columns(mechanism: Mechanism) -> set[int]:
    """Return the columns of values with a free start: not prescribed by actuators, directly or through loops."""
    found = mechanism.assembly
    return set(found.free(first_rows(found)))


def restarted(mechanism: Mechanism, targets: Mapping[int, float]) -> Restart:
    """Return a mechanism with some start values changed; loops follow.

    Args:
        mechanism: As it starts now.
        targets: Values by column [rad, m].

    Raises:
        ValueError: It cannot start there; the message says why, and by how much a loop does not close.
    """
    values = _followed(mechanism, targets)
    changed = _changed(mechanism, values, own=targets)
    keys = dict(_written(mechanism, values, changed, key="start"))
    try:
        begun = _with(mechanism, keys)
    except ValueError:
        # Values coupled by a loop are written with more decimals than that.
        keys = dict(_written(mechanism, values, changed, key="start", places=EXACT))
        begun = _with(mechanism, keys)
    if np.abs(begun.assembly.start - values).max(initial=0.0) > ASTRAY:
        # Write approximate values of the others, so that the loop closes in the same configuration.
        keys = {**keys, **_nearby(mechanism, values, own=targets)}
        begun = _with(mechanism, keys)
    return Restart(mechanism=begun, keys=keys)


def pulled_values(
    mechanism: Mechanism, joint: MechanismJoint, *, look: Array, start: Array, end: Array
) -> dict[int, float]:
    """Return the joint values that bring a point of the carried body nearest to a place in a drawing.

    Args:
        mechanism: As it starts.
        joint: One of its own at which no loop is cut.
        look: drawing_from_world: to the right, up, towards the viewer, shape (3, 4) [m].
        start: The point in the drawing, shape (2,) [m]; its depth is the middle of the body's depth.
        end: Its target, shape (2,) [m].

    Returns:
        By column [rad, m]; values that are not visible in the drawing stay.
    """
    from scipy.optimize import least_squares

    found = mechanism.assembly
    look = look @ mechanism.world_from_ground
    basis, columns = _freedoms(found, joint), list(found.columns[joint.name])
    spot = _grabbed(mechanism, carried_body(found, joint), look, start)

    def missed(freedoms: Array) -> tuple[Array, Array]:
        values = found.start.copy()
        values[columns] += basis @ freedoms
        placed = found.linkage.place(values)
        at = spot.place(placed)
        slopes = look[:2, :3] @ found.linkage.point_jacobian(placed, spot.body, at)[:, columns] @ basis
        return look[:2, :3] @ at + look[:2, 3] - end, slopes

    best = least_squares(
        lambda part: missed(part)[0], np.zeros(basis.shape[1]), jac=lambda part: missed(part)[1], xtol=STILL, ftol=None
    )
    values = found.start[columns] + basis @ best.x
    return {
        column: _clamped(joint, found, column, value) for column, value in zip(columns, values.tolist(), strict=True)
    }


def shows_motion(mechanism: Mechanism, joint: MechanismJoint, look: Array) -> bool:
    """Return whether the motion of a joint is visible in a drawing, `look` as for `pulled_values`."""
    found = mechanism.assembly
    placed = found.linkage.place(found.start)
    axes = placed.axes[list(found.columns[joint.name])] @ mechanism.world_from_ground[:3, :3].T @ look[:, :3].T
    slides = np.array([found.slides[column] for column in found.columns[joint.name]], dtype=bool)
    seen = np.where(slides, np.linalg.norm(axes[:, :2], axis=1), np.abs(axes[:, 2]))
    return bool((seen > FLAT).any())


def carried_body(found: Assembly, joint: MechanismJoint) -> int:
    """Return the number of the body that a joint carries: the one of the two farther from the ground."""
    return next(place for place, each in enumerate(found.linkage.joints, start=1) if each.name == joint.name)


def _freedoms(found: Assembly, joint: MechanismJoint) -> Array:
    """Return the derivative of a joint's values by its freedoms, shape (values, freedoms): a screw has one freedom."""
    first = found.columns[joint.name].start
    for tie in found.couplings:
        if tie.name == f"{joint.name}.thread":
            basis = np.zeros((2, 1))
            basis[tie.second - first], basis[tie.first - first] = 1.0, tie.ratio
            return basis
    return np.eye(len(found.columns[joint.name]))


def _grabbed(mechanism: Mechanism, number: int, look: Array, start: Array) -> BodyPoint:
    """Return the point of a body at a place in a drawing; `look` is drawing_from_ground."""
    found = mechanism.assembly
    pose = found.linkage.place(found.start).poses[number]
    points, _ = mechanism.body(found.bodies[number]).hull()
    depth = float((look[2, :3] @ (points @ pose[:3, :3].T + pose[:3, 3]).T).mean()) + look[2, 3]
    at = look[:, :3].T @ (np.array([*start, depth]) - look[:, 3])
    return BodyPoint(number, pose[:3, :3].T @ (at - pose[:3, 3]))


def _clamped(joint: MechanismJoint, found: Assembly, column: int, value: float) -> float:
    pair = joint.range if found.slides[column] else joint.range_deg
    if pair is None:
        return value
    lower, upper = pair if found.slides[column] else (math.radians(pair[0]), math.radians(pair[1]))
    return min(max(value, lower), upper)


def _followed(mechanism: Mechanism, targets: Mapping[int, float]) -> Array:
    """Return all values after some are changed, shape (values,) [rad, m]; as few others as possible move."""
    found, free = mechanism.assembly, free_columns(mechanism)
    for column in targets:
        if column not in free:
            raise ValueError(
                Sentence("'{name}' has a start prescribed by the actuators; change those", found.names[column])
            )
    begin = found.start.copy()
    begin[list(targets)] = list(targets.values())
    rows = first_rows(found)
    for held in ({*targets, *_given(mechanism)}, set(targets)):
        closed = followed(found.linkage, rows, begin, held=sorted(held))
        if closed.good:
            return closed.values
    worst, how = found.gap(closed.values)
    problem = Sentence("the loop at '{worst}' does not close", worst) if worst else "the constraints do not hold"
    raise ValueError(Sentence("{problem} there: it misses by {miss}", problem, how or f"{closed.miss:.4g}"))


def _given(mechanism: Mechanism) -> Iterator[int]:
    """Yield the columns of values that the text gives."""
    for joint in mechanism.joints:
        for column, start in zip(mechanism.assembly.columns[joint.name], joint.spread("start"), strict=True):
            if start is not None:
                yield column


def _changed(mechanism: Mechanism, values: Array, *, own: Collection[int]) -> set[int]:
    """Return the columns to write: of values that the text gives already, otherwise of those moved by hand."""
    moved = set(np.flatnonzero(np.abs(values - mechanism.assembly.start) > MOVED).tolist())
    return moved & set(_given(mechanism)) or moved & set(own)


def _nearby(mechanism: Mechanism, values: Array, *, own: Collection[int]) -> Keys:
    found = mechanism.assembly
    led = {drive.column for drive in found.drives}
    follow = set(range(found.linkage.size)) - set(_given(mechanism)) - set(own) - led
    return dict(_written(mechanism, values, follow, key="near"))


def _written(
    mechanism: Mechanism, values: Array, columns: Collection[int], *, key: str, places: tuple[int, int] = PLACES
) -> Iterator[tuple[tuple[int, str], float | list[float]]]:
    """Yield the keys of joints with values among these columns, of slides and of rotations [m, deg]."""
    found = mechanism.assembly
    for number, joint in enumerate(mechanism.joints):
        for slides, name, digits in ((True, key, places[0]), (False, f"{key}_deg", places[1])):
            own = [column for column in found.columns[joint.name] if found.slides[column] == slides]
            if not set(own) & set(columns):
                continue
            scale = 1.0 if slides else math.degrees(1.0)
            shown = [round(float(values[column]) * scale, digits) + 0.0 for column in own]
            yield (number, name), shown[0] if len(shown) == 1 else shown


def _with(mechanism: Mechanism, keys: Keys) -> Mechanism:
    """Return the mechanism with other keys of its joints.

    Raises:
        ValueError: It cannot be assembled like this.
    """
    joints = [joint.model_dump(exclude_unset=True) for joint in mechanism.joints]
    for (number, key), value in keys.items():
        joints[number][key] = value
    plain = {**mechanism.model_dump(exclude_unset=True), "joints": joints}
    try:
        return Mechanism.model_validate(plain, context={"source": mechanism._source})
    except ValidationError as error:
        raise ValueError(error.errors(include_url=False)[0]["msg"]) from None
