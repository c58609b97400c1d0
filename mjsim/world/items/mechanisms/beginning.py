"""Assembling a mechanism, with its values and speeds at the start, and its points that slide along curves."""

import dataclasses
import math

import numpy as np
from pydantic_core import PydanticCustomError

from mjsim.errors import did_you_mean
from mjsim.geometry import Array
from mjsim.mechanics import (
    Apart,
    BodyPoint,
    Linear,
    Linkage,
    Primitive,
    Rows,
    SpaceCurve,
    TreeJoint,
    close,
    jacobian,
    placed,
    rates,
    tracked,
)
from mjsim.sentences import Sentence
from mjsim.world.ground import fault
from mjsim.world.items.mechanisms.assembly import Assembly, CurvePoint, Motion, rank_of
from mjsim.world.items.mechanisms.constraints import CurveConstraint
from mjsim.world.items.mechanisms.mass_checks import check_inertias
from mjsim.world.items.mechanisms.mechanism_items import MechanismParts
from mjsim.world.items.mechanisms.motions import Read, motions_of
from mjsim.world.items.mechanisms.points import GROUND, place_of
from mjsim.world.items.mechanisms.rest import trimmed
from mjsim.world.items.mechanisms.sensor_checks import check_sensors
from mjsim.world.items.mechanisms.ties import couplings_of, rods_of, springs_of, tied_rows
from mjsim.world.items.mechanisms.tree import Points, linkage_of, places_of, tree_of, values_of

SAME = 1e-6
"""Start values that differ by less are equal [rad, m]."""


def assemble(mechanism: MechanismParts, read: Read) -> Assembly:
    """Return the assembly of a mechanism.

    Args:
        mechanism: Mechanism as written.
        read: Returns the file of a table of a signal.

    Raises:
        PydanticCustomError: Something does not fit; its path is given.
    """
    points: Points = {GROUND: {}, **{body.name: body.points() for body in mechanism.bodies}}
    places = places_of(mechanism, points)
    axis = next((each for joint in mechanism.all_joints if (each := getattr(joint, "axis", None))), (0.0, 0.0, 1.0))
    linkage, bodies, cuts = linkage_of(mechanism, places, tree_of(mechanism, places), axis)
    names, columns, slides = values_of(mechanism)
    made = tracks_of(mechanism, bodies, points, axis, column=len(names))
    tracks = tuple(track for track, _ in made)
    linkage = Linkage([*linkage.joints, *(joint for _, joint in made)])
    own = tuple(track.name for track in tracks)
    found = Assembly(
        bodies=(*bodies, *("" for _ in tracks)),
        linkage=linkage,
        rows=(),
        cuts=cuts,
        places=places,
        names=(*names, *own),
        columns={**columns, **{each.name: range(each.column, each.column + 1) for each in tracks}},
        slides=(*slides, *(True for _ in tracks)),
        tracks=tracks,
        drives=(),
        start=np.zeros(linkage.size),
        speeds=np.zeros(linkage.size),
    )
    couplings, rods = couplings_of(mechanism, found), rods_of(mechanism, found, points)
    springs = springs_of(mechanism, found, points)
    found = dataclasses.replace(found, rows=found.closures, couplings=couplings, rods=rods, springs=springs)
    found = dataclasses.replace(found, drives=motions_of(mechanism, found, points, read))
    check_sensors(mechanism, found, points)
    return _started(mechanism, found)


def _started(mechanism: MechanismParts, found: Assembly) -> Assembly:
    """Return the assembly with its values and speeds at the start."""
    begin, held = _given(mechanism, found)
    begin_tracks(mechanism, found, begin, held)
    rows = first_rows(found)
    # Where a loop is cut, the joint follows from the other values.
    begin = tracked(found.linkage, rows, begin, columns=_unset_at_cuts(mechanism, found, held))
    closed = close(found.linkage, rows, begin, held=sorted(held))
    if not closed.good:
        raise _open(mechanism, found, closed.values, closed.miss)
    found = dataclasses.replace(found, rows=(*found.rows, *tied_rows(found, closed.values)))
    if mechanism.mode == "trim":
        return trimmed(mechanism, found, closed.values, held)
    check_inertias(mechanism, found, closed.values)
    _within(mechanism, found, closed.values)
    _check_drives(mechanism, found, closed.values)
    speeds = _speeds(mechanism, found, closed.values)
    return dataclasses.replace(found, start=closed.values, speeds=speeds)


def _unset_at_cuts(mechanism: MechanismParts, found: Assembly, held: set[int]) -> list[int]:
    """Return the columns of joints at cuts whose values are neither given nor given approximately."""
    columns = list[int]()
    for joint in mechanism.all_joints:
        if joint.name in found.cuts and not any(joint.spread("near")):
            columns += [column for column in found.columns[joint.name] if column not in held]
    return columns


def first_rows(found: Assembly) -> list[Rows]:
    """Return the constraints at the start that hold for all values."""
    return [*found.closures, *tied_rows(found, None), *driver_rows(found, 0.0)]


def driver_rows(found: Assembly, time: float) -> list[Rows]:
    """Return the prescribed angles, positions and distances at a time [s]."""
    rows = list[Rows]()
    for drive in found.drives:
        if drive.kind == "distance":
            assert drive.ends is not None, "found when it was read"
            rows.append(Apart(drive.ends, float(drive.signal.value(time))))
        elif drive.kind != "velocity":
            rows.append(Linear({drive.column: 1.0}, float(drive.signal.value(time))))
    return rows


def _given(mechanism: MechanismParts, found: Assembly) -> tuple[Array, set[int]]:
    """Return the initial guess of the start values, shape (values,), and the columns that are given."""
    begin, held = np.zeros(found.linkage.size), set[int]()
    led = {
        drive.column: float(drive.signal.value(0.0)) for drive in found.drives if drive.kind in ("angle", "position")
    }
    for number, joint in enumerate(mechanism.all_joints):
        for column, start, near in zip(
            found.columns[joint.name], joint.spread("start"), joint.spread("near"), strict=True
        ):
            key = "start" if found.slides[column] else "start_deg"
            if start is not None and column in led and abs(start - led[column]) > SAME:
                raise fault(
                    Sentence(
                        "{key} is {start}, and the joint's actuator begins at {led}; leave out {key}, or"
                        " make them agree",
                        *(key, _shown(start, found, column), _shown(led[column], found, column)),
                    ),
                    *("joints", number, key),
                )
            if start is not None:
                held.add(column)
            begin[column] = next((value for value in (start, led.get(column), near) if value is not None), 0.0)
    held |= led.keys()
    return begin, held


def _shown(value: float, found: Assembly, column: int) -> str:
    return f"{value:.6g} m" if found.slides[column] else Sentence("{degrees:.6g} degrees", math.degrees(value))


def _open(mechanism: MechanismParts, found: Assembly, values: Array, miss: float) -> PydanticCustomError:
    worst, how = found.gap(values)
    if not worst:
        return fault(
            Sentence("the start values violate the constraints by {miss:.4g}; leave some of them out", miss), "joints"
        )
    number = next((place for place, joint in enumerate(mechanism.all_joints) if joint.name == worst), -1)
    if number < 0:
        track = next(track for track in found.tracks if track.name == worst)
        return fault(
            Sentence(
                "the point does not reach its curve with these lengths and start values: it misses by {how};"
                " change them, or leave out the start of a joint",
                how,
            ),
            *("constraints", track.number, "curve"),
        )
    return fault(
        Sentence(
            "the loop at joint '{worst}' does not close with these lengths and start values: it misses by"
            " {how}; change them, or leave out the start of a joint in it",
            worst,
            how,
        ),
        *("joints", number),
    )


def _within(mechanism: MechanismParts, found: Assembly, values: Array) -> None:
    for number, joint in enumerate(mechanism.all_joints):
        for column in found.columns[joint.name]:
            key = "range" if found.slides[column] else "range_deg"
            pair = getattr(joint, key)
            if pair is None:
                continue
            lower, upper = pair if found.slides[column] else map(math.radians, pair)
            if not lower - SAME <= values[column] <= upper + SAME:
                shown = _shown(float(values[column]), found, column)
                raise fault(
                    Sentence(
                        "joint '{name}' starts at {shown}; its {key} is [{low:g}, {high:g}]",
                        *(joint.name, shown, key, pair[0], pair[1]),
                    ),
                    "joints",
                    number,
                    key,
                )


def _check_drives(mechanism: MechanismParts, found: Assembly, values: Array) -> None:
    """Check that each prescribed motion has a degree of freedom of its own."""
    matrix = jacobian(found.linkage, found.rows, values)
    rank = rank_of(matrix)
    free = found.linkage.size - rank
    for drive in found.drives:
        matrix = np.concatenate(
            [matrix, _drive_row(found, drive).jacobian(found.linkage, found.linkage.place(values), values)]
        )
        grown = rank_of(matrix)
        if grown == rank:
            raise fault(
                Sentence(
                    "'{target}' cannot be driven independently: the mechanism has {free} {freedoms}, which"
                    " other motions already drive; give a torque or a force, or leave it out",
                    *(mechanism.actuators[drive.number].target, free, "freedom" if free == 1 else "freedoms"),
                ),
                *("actuators", drive.number),
            )
        rank = grown
    if mechanism.mode != "forward" and rank < found.linkage.size:
        raise fault(
            Sentence(
                "mode {mode} needs a motion for each degree of freedom: {drives} of {free} have one; add an"
                " angle, position, velocity or distance, or use mode: forward",
                *(mechanism.mode, len(found.drives), free),
            ),
            "mode",
        )


def _drive_row(found: Assembly, drive: Motion) -> Rows:
    if drive.ends is not None:
        return Apart(drive.ends, 0.0)
    return Linear({drive.column: 1.0})


def _speeds(mechanism: MechanismParts, found: Assembly, values: Array) -> Array:
    """Return the speeds at the start: given ones, prescribed ones, and those that follow from loops."""
    held: dict[int, float] = {}
    for joint in mechanism.all_joints:
        for column, speed in zip(found.columns[joint.name], joint.spread("speed"), strict=True):
            if speed is not None:
                held[column] = speed
    held |= track_speeds(mechanism, found)
    for drive in found.drives:
        if drive.column >= 0:
            rate = drive.signal.value(0.0) if drive.kind == "velocity" else drive.signal.rate(0.0)
            if drive.column in held and abs(held[drive.column] - rate) > SAME:
                owners = [n for n, each in enumerate(mechanism.all_joints) if drive.column in found.columns[each.name]]
                raise fault("the speed at the start contradicts the joint's actuator; leave it out", "joints", *owners)
            held[drive.column] = float(rate)
    rows, targets = list(found.rows), [np.zeros(len(jacobian(found.linkage, found.rows, values)))]
    for drive in found.drives:
        if drive.ends is not None:
            rows.append(_drive_row(found, drive))
            targets.append(np.atleast_1d(drive.signal.rate(0.0)))
    speeds, missed = rates(found.linkage, rows, values, held=held, targets=np.concatenate(targets))
    if missed > SAME:
        raise fault(
            Sentence("the initial speeds violate the constraints by {missed:.4g} m/s; leave some of them out", missed),
            "joints",
        )
    return speeds


def tracks_of(
    mechanism: MechanismParts, bodies: tuple[str, ...], points: Points, axis: tuple[float, ...], *, column: int
) -> list[tuple[CurvePoint, TreeJoint]]:
    """Return the points on curves, each with the joint that positions its ghost on the curve.

    Args:
        mechanism: Mechanism as written.
        bodies: Bodies by number, as in an `Assembly`; those of the ghosts follow.
        points: Named points by body.
        axis: Default normal of circles and ellipses.
        column: Column of the first of their values.
    """
    made = list[tuple[CurvePoint, TreeJoint]]()
    for number, item in enumerate(mechanism.constraints):
        if not isinstance(item, CurveConstraint):
            continue
        spot = _spot(item, bodies, points, ("constraints", number))
        curve = _curve(item, axis, ("constraints", number))
        name, parent, place = item.called(number), bodies.index(item.on), column + len(made)
        joint = TreeJoint(
            name=name,
            parent=parent,
            before=placed(item.at, [math.radians(angle) for angle in item.rpy_deg]),
            primitives=(Primitive(kind="curve", curve=curve),),
            after=np.eye(4),
            first=place,
        )
        ghost = len(bodies) + len(made)
        made.append((CurvePoint(name=name, column=place, ghost=ghost, spot=spot, number=number), joint))
    return made


def _spot(item: CurveConstraint, bodies: tuple[str, ...], points: Points, path: tuple[str | int, ...]) -> BodyPoint:
    try:
        place = place_of(item.curve, points)
    except ValueError as error:
        raise fault(str(error), *path, "curve") from None
    if item.on not in points:
        raise fault(
            Sentence("no body '{name}' in this mechanism{meant}", item.on, did_you_mean(item.on, points)), *path, "on"
        )
    if place.body == item.on:
        raise fault(Sentence("the point and the curve are both on '{on}'; name two bodies", item.on), *path, "curve")
    return BodyPoint(bodies.index(place.body), np.array(place.at))


def _curve(item: CurveConstraint, axis: tuple[float, ...], path: tuple[str | int, ...]) -> SpaceCurve:
    normal = np.array(axis if item.axis is None else item.axis, dtype=float)
    if item.circle is not None:
        return SpaceCurve.ellipse(item.circle, item.circle, normal)
    if item.ellipse is not None:
        across, up = item.ellipse
        return SpaceCurve.ellipse(across, up, normal)
    assert item.points is not None, "checked when it was read"
    return SpaceCurve(np.array(item.points, dtype=float), closed=item.closed, axis=normal)


def begin_tracks(mechanism: MechanismParts, found: Assembly, begin: Array, held: set[int]) -> None:
    """Write the initial guess of the positions along curves: as given, or nearest to their points.

    Args:
        mechanism: Mechanism as written.
        found: Its assembly.
        begin: Initial guess, shape (values,); modified.
        held: Columns that are given; modified.
    """
    placement = found.linkage.place(begin)
    for track in found.tracks:
        item, joint = _written(mechanism, track), found.linkage.joints[track.ghost - 1]
        curve = joint.primitives[0].curve
        assert curve is not None, "made for it"
        pose = placement.poses[joint.parent] @ joint.before
        given = item.near if item.start is None else item.start
        point = pose[:3, :3].T @ (track.spot.place(placement) - pose[:3, 3])
        begin[track.column] = curve.nearest(point) if given is None else given
        if item.start is not None:
            held.add(track.column)


def track_speeds(mechanism: MechanismParts, found: Assembly) -> dict[int, float]:
    """Return the given speeds along curves, by column [m/s]."""
    speeds = {track.column: _written(mechanism, track).speed for track in found.tracks}
    return {column: speed for column, speed in speeds.items() if speed is not None}


def _written(mechanism: MechanismParts, track: CurvePoint) -> CurveConstraint:
    item = mechanism.constraints[track.number]
    assert isinstance(item, CurveConstraint), "it was made from one"
    return item
