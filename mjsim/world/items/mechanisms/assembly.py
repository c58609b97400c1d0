"""How a mechanism hangs together: its bodies by number, its values, and where its loops are cut."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from mjsim.errors import did_you_mean
from mjsim.geometry import Array
from mjsim.mechanics import BodyPoint, Coincide, Linkage, Meet, Rows, TimeSignal, followed, jacobian
from mjsim.world.items.mechanisms.points import Place

TURNED = 0.05
"""Angles below this are not told of a loop that does not close [deg]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Motion:
    """A motion that a joint or a distance follows."""

    number: int
    """Among the actuators."""
    kind: str
    """'angle', 'position', 'velocity' or 'distance'."""
    column: int
    """Of the value; -1 for a distance."""
    ends: tuple[BodyPoint, BodyPoint] | None
    """Of a distance."""
    signal: TimeSignal
    """[rad, m]"""
    name: str = ""
    """Of a distance."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Coupling:
    """A value that goes with another one from where both start: first = ratio times second."""

    name: str
    first: int
    """Column."""
    second: int
    ratio: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rod:
    """Two points that stay as far apart as they start."""

    name: str
    ends: tuple[BodyPoint, BodyPoint]
    length: float | None
    """As at the start unless given [m]."""


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
    """As at the start unless given [m]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CurvePoint:
    """A point that slides along a curve."""

    name: str
    """Of its value, the length along the curve."""
    column: int
    ghost: int
    """Number of the body that stands on the curve where the point is, for the sake of the linkage alone."""
    spot: BodyPoint
    """The point."""
    number: int
    """Among the constraints."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Assembly:
    """A mechanism as `mjsim.mechanics` has it, and how it starts."""

    bodies: tuple[str, ...]
    """By number; the ground first; of ghosts beyond cuts `JOINT.ghost`, or '' where the physics needs none."""
    linkage: Linkage
    rows: tuple[Rows, ...]
    """What holds at all times: closed loops and constraints."""
    cuts: Mapping[str, tuple[int, int]]
    """By joint at which a loop is cut: the ghost and the body that it stands for."""
    places: Mapping[str, tuple[Place, Place]]
    """By joint: the points that meet."""
    names: tuple[str, ...]
    """Of the values."""
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
    """Of the values, shape (values,) [rad, m]."""
    speeds: Array
    """At the start, shape (values,) [1/s]."""
    found: Mapping[int, float] = field(default_factory=dict)
    """Torques and forces that trimming found, by the number of their actuator [N m, N]."""

    @property
    def closures(self) -> tuple[Rows, ...]:
        """Loops that close, and points that are on their curves."""
        loops = (Coincide(*pair) for pair in self.cuts.values())
        return (*loops, *(Meet(each.ghost, each.spot) for each in self.tracks))

    def number(self, body: str) -> int:
        """Return the number of a body."""
        return self.bodies.index(body)

    def gap(self, values: Array) -> tuple[str, str]:
        """Return the loop or curve that is missed by most, by name, and by how much, in words; '' where there is none.

        Args:
            values: Shape (values,) [rad, m].
        """
        placement, worst, far, how = self.linkage.place(values), "", 0.0, ""
        for name, (ghost, body) in self.cuts.items():
            missed = Coincide(ghost, body).residual(self.linkage, placement, values)
            if np.abs(missed).max() >= far:
                worst, far = name, float(np.abs(missed).max())
                turned = math.degrees(float(np.linalg.norm(missed[3:])))
                how = f"{np.linalg.norm(missed[:3]):.4g} m" + (f" and {turned:.4g} degrees" if turned > TURNED else "")
        for track in self.tracks:
            missed = Meet(track.ghost, track.spot).residual(self.linkage, placement, values)
            if np.abs(missed).max() >= far:
                worst, far, how = track.name, float(np.abs(missed).max()), f"{np.linalg.norm(missed):.4g} m"
        return worst, how

    def needs_axis(self, name: str) -> bool:
        """Return whether a cut joint must be held at a second point of its axis, beside the one where its bodies meet.

        In a plane mechanism all other joints keep the axes parallel already, and a second point would only share the
        forces in a way that is left to chance.
        """
        others = [row for row in self.rows if row != Coincide(*self.cuts[name])]
        for values in self._postures():
            whole = jacobian(self.linkage, self.rows, values)
            placement = self.linkage.place(values)
            ghost, body = self.cuts[name]
            at = Coincide(ghost, body).jacobian(self.linkage, placement, values)
            point = np.concatenate([jacobian(self.linkage, others, values), at[:3]])
            own = list(self.columns[name])
            kept = np.setdiff1d(np.arange(self.linkage.size), own)
            # The joint's own turn is free in any case.
            if rank_of(point[:, kept]) + len(own) < rank_of(whole):
                return True
        return False

    def across(self, track: CurvePoint) -> tuple[int, ...]:
        """Return which of the two directions across a curve the physics must hold its point in: 0, 1 or both.

        In a plane mechanism one does, and the other would only be a demand for what holds anyhow.
        """
        joint = self.linkage.joints[track.ghost - 1]
        curve = joint.primitives[0].curve
        assert curve is not None, "made for it"
        others = [row for row in self.rows if not (isinstance(row, Meet) and row.ghost == track.ghost)]
        needed = {0, 1}
        for values in self._postures():
            whole, placement = jacobian(self.linkage, self.rows, values), self.linkage.place(values)
            turned = placement.poses[joint.parent, :3, :3] @ joint.before[:3, :3]
            along = float(values[track.column])
            ways = np.concatenate([curve.normals(along), curve.at(along)[1][None]]) @ turned.T
            own = ways @ Meet(track.ghost, track.spot).jacobian(self.linkage, placement, values)
            apart = jacobian(self.linkage, others, values)
            rank = rank_of(whole)
            enough = {way for way in (0, 1) if rank_of(np.concatenate([apart, own[[way, 2]]])) == rank}
            needed &= enough
        return (min(needed),) if needed else (0, 1)

    def _postures(self) -> Iterator[Array]:
        """Yield the values at the start, and some that hold as well near them."""
        rng, values = np.random.default_rng(0), self.start
        for _ in range(3):
            yield values
            closed = followed(self.linkage, self.rows, values + 0.2 * rng.uniform(-1.0, 1.0, self.linkage.size))
            values = closed.values if closed.good else self.start

    def column(self, name: str) -> int:
        """Return the column of a value, named as a joint of one value or as `JOINT.VALUE`.

        Raises:
            ValueError: There is none, or the joint has several.
        """
        if name in self.names:
            return self.names.index(name)
        if name in self.columns:
            own = [self.names[column] for column in self.columns[name]]
            found = f"has {len(own)} values; name one of {', '.join(own)}" if own else "is a weld, which does not move"
            raise ValueError(f"joint '{name}' {found}")
        raise ValueError(
            f"no joint '{name}' in this mechanism{did_you_mean(name, dict.fromkeys([*self.columns, *self.names]))}"
        )

    def moved_column(self, name: str) -> int:
        """Return the column of a value that an actuator or a gear may act on, named as `column` has it.

        Raises:
            ValueError: There is none, or it is how far a point is along a curve.
        """
        column = self.column(name)
        if column in [track.column for track in self.tracks]:
            raise ValueError(
                f"'{name}' is how far a point is along a curve; name a joint, or push the point with force: BODY.POINT"
            )
        return column


def rank_of(matrix: Array) -> int:
    """Return the rank of a matrix, 0 of an empty one."""
    return int(np.linalg.matrix_rank(matrix, rtol=1e-8)) if matrix.size else 0
