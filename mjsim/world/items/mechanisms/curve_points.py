"""Points of mechanisms that slide along curves of bodies."""

import math

import numpy as np

from mjsim.errors import did_you_mean
from mjsim.geometry import Array
from mjsim.mechanics import BodyPoint, Primitive, SpaceCurve, TreeJoint, placed
from mjsim.world.ground import fault
from mjsim.world.items.mechanisms.assembly import Assembly, CurvePoint
from mjsim.world.items.mechanisms.constraints import CurveConstraint
from mjsim.world.items.mechanisms.mechanism_items import MechanismParts
from mjsim.world.items.mechanisms.points import place_of
from mjsim.world.items.mechanisms.tree import Points


def tracks_of(
    mechanism: MechanismParts, bodies: tuple[str, ...], points: Points, axis: tuple[float, ...], *, column: int
) -> list[tuple[CurvePoint, TreeJoint]]:
    """Return the points on curves, each with the joint that positions its ghost on the curve.

    Args:
        mechanism: As written.
        bodies: By number, as in an `Assembly`; those of the ghosts follow.
        points: By body, its named points.
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
        raise fault(f"no body '{item.on}' in this mechanism{did_you_mean(item.on, points)}", *path, "on")
    if place.body == item.on:
        raise fault(f"the point and the curve are both on '{item.on}'; name two bodies", *path, "curve")
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
        mechanism: As written.
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
