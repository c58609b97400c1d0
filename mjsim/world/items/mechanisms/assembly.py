"""Assembly of a mechanism: its bodies by number, its values, and where its loops are cut."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from mjsim.errors import did_you_mean
from mjsim.geometry import Array
from mjsim.mechanics import (
    Apart,
    BodyPoint,
    Coincide,
    Linear,
    Linkage,
    Meet,
    Rows,
    TimeSignal,
    followed,
    jacobian,
)
from mjsim.sentences import Sentence
from mjsim.world.items.mechanisms.points import Place

if TYPE_CHECKING:  # Imported where it is used: it needs scipy.
    from mjsim.mechanics import SpaceCurve

TURNED = 0.05
"""Smaller angles are not reported for a loop that does not close [deg]."""
NO_RANK = 1e-8
"""Singular values, and components of a motion, below this fraction count as zero."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Motion:
    """A prescribed motion of a joint or a distance."""

    number: int
    """Index of its actuator."""
    kind: str
    """'angle', 'position', 'velocity' or 'distance'."""
    column: int
    """Column of the value; -1 for a distance."""
    ends: tuple[BodyPoint, BodyPoint] | None
    """Ends of a distance."""
    signal: TimeSignal
    """[rad, m]"""
    name: str = ""
    """Name of a distance."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Coupling:
    """A value coupled to another one, relative to their start: first = ratio times second."""

    name: str
    first: int
    """Column."""
    second: int
    ratio: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rod:
    """Two points at a constant distance."""

    name: str
    ends: tuple[BodyPoint, BodyPoint]
    length: float | None
    """By default the distance at the start [m]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Spring:
    """A spring with a damper between two points."""

    name: str
    ends: tuple[BodyPoint, BodyPoint]
    stiffness: float
    """[N/m]"""
    damping: float
    """[N s/m]"""
    rest: float | None
    """By default the distance at the start [m]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CurvePoint:
    """A point that slides along a curve."""

    name: str
    """Column of its value, the length along the curve."""
    column: int
    ghost: int
    """Number of the auxiliary body on the curve at the point, which only the linkage needs."""
    spot: BodyPoint
    """The point."""
    number: int
    """Index of its constraint."""

    def curve(self, linkage: Linkage) -> "SpaceCurve":
        """Return its curve."""
        found = linkage.joints[self.ghost - 1].primitives[0].curve
        assert found is not None, "made for it"
        return found


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Assembly:
    """A mechanism in the form of `mjsim.mechanics`, and how it starts."""

    bodies: tuple[str, ...]
    """Names by number, the ground first; for ghosts beyond cuts `JOINT.ghost`, or '' if the physics does not need
    one."""
    linkage: Linkage
    rows: tuple[Rows, ...]
    """Equations that always hold: closed loops and constraints."""
    cuts: Mapping[str, tuple[int, int]]
    """By joint where a loop is cut: the ghost and the body that it represents."""
    places: Mapping[str, tuple[Place, Place]]
    """By joint: the points that coincide."""
    names: tuple[str, ...]
    """Names of the values."""
    columns: Mapping[str, range]
    """By joint."""
    slides: tuple[bool, ...]
    """Whether a value is a length."""
    drives: tuple[Motion, ...]
    couplings: tuple[Coupling, ...] = ()
    rods: tuple[Rod, ...] = ()
    springs: tuple[Spring, ...] = ()
    tracks: tuple[CurvePoint, ...] = ()
    start: Array
    """Start of the values, shape (values,) [rad, m]."""
    speeds: Array
    """Speeds at the start, shape (values,) [1/s]."""
    found: Mapping[int, float] = field(default_factory=dict)
    """Torques and forces found by trimming, by the number of their actuator [N m, N]."""

    @property
    def closures(self) -> tuple[Rows, ...]:
        """Closed loops, and points that lie on their curves."""
        loops = (Coincide(*pair) for pair in self.cuts.values())
        return (*loops, *(Meet(each.ghost, each.spot) for each in self.tracks))

    def free(self, rows: Sequence[Rows]) -> frozenset[int]:
        """Return the columns of values that can move at the start while equations hold."""
        return self._free_at(self.start, rows)

    def _free_at(self, values: Array, rows: Sequence[Rows]) -> frozenset[int]:
        matrix = jacobian(self.linkage, rows, values)
        *_, singular, directions = np.linalg.svd(np.concatenate([matrix, np.zeros((1, self.linkage.size))]))
        rank = int((singular > NO_RANK * singular.max(initial=1.0)).sum())
        return frozenset(np.flatnonzero(np.abs(directions[rank:]).max(axis=0, initial=0.0) > NO_RANK).tolist())

    def movable(self) -> tuple[frozenset[int], frozenset[int]]:
        """Return the columns of values that can move.

        Some cannot move only at the start, such as the second angle of a universal joint: other postures count too.

        Returns:
            undriven: Those that forces can move: no motion prescribes them, directly or through loops.
            driven: The others that move, with a motion.
        """
        driven = [Linear({each.column: 1.0}) if each.ends is None else Apart(each.ends, 0.0) for each in self.drives]
        undriven, movable = frozenset[int](), frozenset[int]()
        for values in self._postures():
            undriven |= self._free_at(values, [*self.rows, *driven])
            movable |= self._free_at(values, self.rows)
        return undriven, movable - undriven

    def number(self, body: str) -> int:
        """Return the number of a body."""
        return self.bodies.index(body)

    def moved_body(self, joint: str) -> int:
        """Return the number of the body that a joint moves: of its two, the one farther from the ground, or the second.

        Unlike `carried_body`, it gives the real body also where a loop is cut.
        """
        number = next(place for place, each in enumerate(self.linkage.joints, start=1) if each.name == joint)
        return self.cuts[joint][1] if joint in self.cuts else number

    def gap(self, values: Array) -> tuple[str, str]:
        """Return the loop or curve with the largest error, and that error, in words; '' if there is none.

        Args:
            values: Shape (values,) [rad, m].
        """
        placement, worst, far, how = self.linkage.place(values), "", 0.0, ""
        for name, (ghost, body) in self.cuts.items():
            missed = Coincide(ghost, body).residual(self.linkage, placement, values)
            if np.abs(missed).max() >= far:
                worst, far = name, float(np.abs(missed).max())
                turned = math.degrees(float(np.linalg.norm(missed[3:])))
                how = f"{np.linalg.norm(missed[:3]):.4g} m" + (
                    Sentence(" and {degrees:.4g} degrees", turned) if turned > TURNED else ""
                )
        for track in self.tracks:
            missed = Meet(track.ghost, track.spot).residual(self.linkage, placement, values)
            if np.abs(missed).max() >= far:
                worst, far, how = track.name, float(np.abs(missed).max()), f"{np.linalg.norm(missed):.4g} m"
        return worst, how

    def needs_axis(self, name: str) -> bool:
        """Return whether a cut joint needs a second point on its axis held, besides the one where its bodies meet.

        In a planar mechanism all other joints already keep the axes parallel, and a second point would make the
        distribution of the forces indeterminate.
        """
        others = [row for row in self.rows if row != Coincide(*self.cuts[name])]
        for values in self._postures():
            whole = jacobian(self.linkage, self.rows, values)
            placement = self.linkage.place(values)
            ghost, body = self.cuts[name]
            at = Coincide(ghost, body).jacobian(self.linkage, placement, values)
            point = np.concatenate([jacobian(self.linkage, others, values), at[:3]])
            own = list(self.columns[name])
            others_columns = np.setdiff1d(np.arange(self.linkage.size), own)
            # The rotation of the joint itself is free in any case.
            if rank_of(point[:, others_columns]) + len(own) < rank_of(whole):
                return True
        return False

    def across(self, track: CurvePoint) -> tuple[int, ...]:
        """Return the directions across a curve in which the physics must constrain its point: 0, 1 or both.

        In a planar mechanism one is enough; the other would be redundant.
        """
        joint, curve = self.linkage.joints[track.ghost - 1], track.curve(self.linkage)
        others = [row for row in self.rows if not (isinstance(row, Meet) and row.ghost == track.ghost)]
        needed = {0, 1}
        for values in self._postures():
            whole, placement = jacobian(self.linkage, self.rows, values), self.linkage.place(values)
            turned = placement.poses[joint.parent, :3, :3] @ joint.before[:3, :3]
            along = float(values[track.column])
            directions = np.concatenate([curve.normals(along), curve.at(along)[1][None]]) @ turned.T
            own = directions @ Meet(track.ghost, track.spot).jacobian(self.linkage, placement, values)
            others_jacobian = jacobian(self.linkage, others, values)
            rank = rank_of(whole)
            enough = {axis for axis in (0, 1) if rank_of(np.concatenate([others_jacobian, own[[axis, 2]]])) == rank}
            needed &= enough
        return (min(needed),) if needed else (0, 1)

    def _postures(self) -> Iterator[Array]:
        """Yield the values at the start, and some valid values near them."""
        rng, values = np.random.default_rng(0), self.start
        for _ in range(3):
            yield values
            closed = followed(self.linkage, self.rows, values + 0.2 * rng.uniform(-1.0, 1.0, self.linkage.size))
            values = closed.values if closed.good else self.start

    def column(self, name: str) -> int:
        """Return the column of a value, named by a joint of one value or as `JOINT.VALUE`.

        Raises:
            ValueError: It does not exist, or the joint has several.
        """
        if name in self.names:
            return self.names.index(name)
        if name in self.columns:
            own = [self.names[column] for column in self.columns[name]]
            found = (
                Sentence("has {count} values; name one of {values}", len(own), ", ".join(own))
                if own
                else "is a weld, which does not move"
            )
            raise ValueError(Sentence("joint '{name}' {found}", name, found))
        raise ValueError(
            Sentence(
                "no joint '{name}' in this mechanism{meant}",
                name,
                did_you_mean(name, dict.fromkeys([*self.columns, *self.names])),
            )
        )

    def moved_column(self, name: str) -> int:
        """Return the column of a value that an actuator or a gear may act on, named as for `column`.

        Raises:
            ValueError: It does not exist, or it is the position of a point along a curve.
        """
        column = self.column(name)
        if column in [track.column for track in self.tracks]:
            raise ValueError(
                Sentence(
                    "'{name}' is the position of a point along a curve; name a joint, or push the point with"
                    " force: BODY.POINT",
                    name,
                )
            )
        return column


def rank_of(matrix: Array) -> int:
    """Return the rank of a matrix, 0 for an empty one."""
    return int(np.linalg.matrix_rank(matrix, rtol=1e-8)) if matrix.size else 0
