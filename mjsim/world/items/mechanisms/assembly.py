"""How a mechanism hangs together: its bodies by number, its values, and where its loops are cut."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from mjsim.errors import did_you_mean
from mjsim.geometry import Array
from mjsim.mechanics import BodyPoint, Coincide, Linkage, Rows, TimeSignal, followed, jacobian
from mjsim.world.items.mechanisms.points import Place


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
    start: Array
    """Of the values, shape (values,) [rad, m]."""
    speeds: Array
    """At the start, shape (values,) [1/s]."""
    found: Mapping[int, float] = field(default_factory=dict)
    """Torques and forces that trimming found, by the number of their actuator [N m, N]."""

    def number(self, body: str) -> int:
        """Return the number of a body."""
        return self.bodies.index(body)

    def needs_axis(self, name: str) -> bool:
        """Return whether a cut joint must be held at a second point of its axis, beside the one where its bodies meet.

        In a plane mechanism all other joints keep the axes parallel already, and a second point would only share the
        forces in a way that is left to chance.
        """
        others = [row for row in self.rows if row != Coincide(*self.cuts[name])]
        rng, values = np.random.default_rng(0), self.start
        for _ in range(3):
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
            tried = values + 0.2 * rng.uniform(-1.0, 1.0, self.linkage.size)
            closed = followed(self.linkage, self.rows, tried)
            values = closed.values if closed.good else self.start
        return False

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


def rank_of(matrix: Array) -> int:
    """Return the rank of a matrix, 0 of an empty one."""
    return int(np.linalg.matrix_rank(matrix, rtol=1e-8)) if matrix.size else 0
