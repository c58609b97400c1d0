"""Bodies connected by joints to the ground and to each other: poses and Jacobians.

Every joint is a chain of primitives that slide or turn. A loop is cut at one of its joints: behind it is a ghost, a
frame without mass, which coincides with the body behind the joint if the loop is closed.

References:
    Featherstone, Rigid Body Dynamics Algorithms (2008), sections 4.1 to 4.4 and 8.2.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from mjsim.geometry import Array
from mjsim.mechanics.transforms import cross, rotation_of

if TYPE_CHECKING:  # most linkages have no curve
    from mjsim.mechanics.space_curves import SpaceCurve

GROUND = 0
"""Number of the ground among the bodies."""
WIDTH = {"slide": 1, "turn": 1, "ball": 3, "curve": 1}
"""Number of values of a primitive."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Primitive:
    """One elementary motion of a joint; a ball's value is its rotation vector, three numbers [rad]."""

    kind: Literal["slide", "turn", "ball", "curve"]
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    """Unit vector in the frame before it; unused for a ball or a curve."""
    suffix: str = ""
    """Suffix of its name, after that of the joint and a point; empty if it is the whole joint."""
    curve: "SpaceCurve | None" = None
    """The curve along which it slides, in the frame before it, for this kind."""

    @property
    def width(self) -> int:
        """Number of values."""
        return WIDTH[self.kind]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TreeJoint:
    """A joint that places a body: parent_from_body = before, then the primitives, then after."""

    name: str
    parent: int
    before: Array
    """Shape (4, 4)."""
    primitives: tuple[Primitive, ...]
    after: Array
    """Shape (4, 4)."""
    sign: float = 1.0
    """-1 if the joint is traversed from its second body to its first, with inverted motions."""
    first: int
    """Column of the first primitive's value; the same for a joint traversed backwards."""

    def columns(self) -> list[int]:
        """Return the first column of each primitive."""
        starts = np.cumsum([0, *(each.width for each in self._in_order())])[:-1] + self.first
        found = [int(start) for start in starts]
        return found if self.sign > 0 else found[::-1]

    def _in_order(self) -> tuple[Primitive, ...]:
        return self.primitives if self.sign > 0 else self.primitives[::-1]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Placement:
    """Poses of all bodies for values of the joints, frame of the ground."""

    poses: Array
    """ground_from_body, shape (bodies, 4, 4)."""
    slides: Array
    """Whether a column slides, bool, shape (values,)."""
    axes: Array
    """Axes of each column, shape (values, 3)."""
    anchors: Array
    """A point of each column's axis, shape (values, 3)."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Passed:
    """A primitive on the path to a body, with its constant parts."""

    kind: Literal["slide", "turn", "ball", "curve"]
    part: slice
    """Its columns."""
    sign: float
    axis: Array
    """As traversed, shape (3,)."""
    skew: Array
    """Skew-symmetric matrix of the axis, shape (3, 3)."""
    square: Array
    """Square of that matrix, shape (3, 3)."""
    curve: "SpaceCurve | None"
    """Never traversed backwards."""


def _passed(joint: TreeJoint) -> list[_Passed]:
    found = []
    for primitive, column in zip(joint.primitives, joint.columns(), strict=True):
        x, y, z = axis = joint.sign * np.array(primitive.axis)
        skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        part = slice(column, column + primitive.width)
        found.append(
            _Passed(
                kind=primitive.kind,
                part=part,
                sign=joint.sign,
                axis=axis,
                skew=skew,
                square=skew @ skew,
                curve=primitive.curve,
            )
        )
    return found


class Linkage:
    """A tree of bodies; body 0 is the ground, body k + 1 is placed by joint k, and parents come first."""

    def __init__(self, joints: Sequence[TreeJoint]) -> None:
        """Determine which values move which body.

        Args:
            joints: One per body except the ground.
        """
        self.joints = tuple(joints)
        self.size = sum(primitive.width for joint in joints for primitive in joint.primitives)
        """Number of values."""
        self.moves = np.zeros((len(joints) + 1, self.size), dtype=bool)
        """Whether a value moves a body, shape (bodies, values)."""
        for number, joint in enumerate(joints, start=1):
            width = sum(primitive.width for primitive in joint.primitives)
            self.moves[number] = self.moves[joint.parent]
            self.moves[number, joint.first : joint.first + width] = True
        self._chains = [_passed(joint) for joint in joints]
        self._slides = np.zeros(self.size, dtype=bool)
        for each in (each for chain in self._chains for each in chain):
            self._slides[each.part] = each.kind in ("slide", "curve")
        self._last: tuple[bytes, Placement] | None = None

    def place(self, values: Array) -> Placement:
        """Return the poses of all bodies; caches the last result, because residuals and Jacobians use the same one.

        Args:
            values: Joint values, shape (values,) [rad, m].
        """
        last, key = self._last, values.tobytes()
        if last is None or last[0] != key:
            self._last = last = key, self._placed(values)
        return last[1]

    def _placed(self, values: Array) -> Placement:
        poses = np.tile(np.eye(4), (len(self.joints) + 1, 1, 1))
        axes, anchors = np.zeros((self.size, 3)), np.zeros((self.size, 3))
        for number, (joint, chain) in enumerate(zip(self.joints, self._chains, strict=True), start=1):
            pose = poses[joint.parent] @ joint.before
            turned, at = pose[:3, :3], pose[:3, 3]
            for each in chain:
                anchors[each.part] = at
                if each.kind == "ball":
                    vector = each.sign * values[each.part]
                    axes[each.part] = each.sign * left_jacobian(vector).T @ turned.T
                    turned = turned @ rotation_of(vector)
                    continue
                value = float(values[each.part.start])
                if each.curve is not None:
                    place, slope, _ = each.curve.at(value)
                    axes[each.part.start] = turned @ slope
                    at = at + turned @ place
                    continue
                axes[each.part] = turned @ each.axis
                if each.kind == "slide":
                    at = at + axes[each.part.start] * value
                else:
                    # Rodrigues' formula.
                    turned = turned + turned @ (math.sin(value) * each.skew + (1.0 - math.cos(value)) * each.square)
            pose[:3, :3], pose[:3, 3] = turned, at
            poses[number] = pose @ joint.after
        return Placement(poses=poses, slides=self._slides, axes=axes, anchors=anchors)

    def point_jacobian(self, placed: Placement, body: int, point: Array) -> Array:
        """Return the Jacobian of a point of a body, shape (3, values).

        Args:
            placed: Poses of all bodies.
            body: Number of the body.
            point: Point in the frame of the ground, shape (3,) [m].
        """
        turning = cross(placed.axes, point - placed.anchors)
        columns = np.where(placed.slides[:, None], placed.axes, turning)
        return np.asarray((columns * self.moves[body][:, None]).T)

    def turn_jacobian(self, placed: Placement, body: int) -> Array:
        """Return the Jacobian of a body's rotation, in the frame of the ground, shape (3, values)."""
        turning = self.moves[body] & np.logical_not(placed.slides)
        return np.asarray((placed.axes * turning[:, None]).T)


def left_jacobian(vector: Array) -> Array:
    """Return the matrix from the rate of a rotation vector to the angular velocity, shape (3, 3).

    References:
        Lynch and Park (2017), exercise 3.19; Chirikjian, Stochastic Models (2011), equation 10.86.
    """
    angle = float(np.linalg.norm(vector))
    x, y, z = vector
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    if angle < 1e-4:
        return np.asarray(np.eye(3) + 0.5 * skew + skew @ skew / 6.0)
    along = (1.0 - np.cos(angle)) / angle**2
    return np.asarray(np.eye(3) + along * skew + (angle - np.sin(angle)) / angle**3 * skew @ skew)
