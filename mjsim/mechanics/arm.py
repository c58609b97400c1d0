"""An arm: a chain of links with one joint each, from its Denavit-Hartenberg table to poses and torques."""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import ArrayLike

from mjsim.geometry import Array
from mjsim.mechanics import dynamics
from mjsim.mechanics.arm_links import Link
from mjsim.mechanics.chain import Chain, Posture, chain_of, posture_at, tool_jacobian
from mjsim.mechanics.dh import Row, links_of
from mjsim.mechanics.inverse import PoseGoals, Reached, solve
from mjsim.mechanics.transforms import IDENTITY, is_rigid
from mjsim.sentences import Sentence

if TYPE_CHECKING:
    from matplotlib.figure import Figure

GRAVITY = (0.0, 0.0, -9.81)
"""World frame, z up [m/s^2]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Arm:
    """A chain of n links; those beyond its end are fingers.

    All methods take arrays of any leading shape and return them with that shape. q is the value of each joint [rad, m
    for prismatic joints]; the world is the frame in which `base` is given.
    """

    links: tuple[Link, ...]
    """Links from the base outwards."""
    name: str = "arm"
    convention: str | None = None
    """Convention of the table that it comes from: 'standard' or 'modified'."""
    base: Array = field(default_factory=lambda: IDENTITY)
    """world_from_base, shape (4, 4) [m]."""
    tool: Array = field(default_factory=lambda: IDENTITY)
    """flange_from_tool, shape (4, 4) [m]."""
    flange: Array = field(default_factory=lambda: IDENTITY)
    """Frame of the flange in that of the link that carries it, link_from_flange, shape (4, 4) [m]."""
    end: int | None = None
    """Number of the link that carries the flange, counted from 0; by default the last one. Links that it carries are
    fingers: they have mass and move, but do not affect the pose of the tool."""
    gravity: tuple[float, float, float] = GRAVITY
    """World frame [m/s^2]."""
    _chain: Chain = field(init=False, repr=False)
    _masses: dynamics.Masses = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Check poses, and keep the links as arrays."""
        if not self.links:
            raise ValueError("the arm has no links; give at least one row")
        for name in ("base", "tool", "flange"):
            pose = np.array(getattr(self, name), dtype=float)
            if pose.shape != (4, 4) or not np.isfinite(pose).all() or not is_rigid(pose):
                raise ValueError(Sentence("{name} is not a pose; give a homogeneous transform of shape (4, 4)", name))
            pose.flags.writeable = False
            object.__setattr__(self, name, pose)
        if self.end is not None and not 0 <= self.end < self.n:
            raise ValueError(Sentence("end is {end}; links are numbered from 0 to {n}", self.end, self.n - 1))
        end = self.n - 1 if self.end is None else self.end
        object.__setattr__(self, "_chain", chain_of(self.links, self.base, self.flange @ self.tool, end))
        object.__setattr__(self, "_masses", dynamics.masses_of(self.links))

    @classmethod
    def from_dh(
        cls,
        rows: Sequence[Row],
        convention: str = "standard",
        unit: str = "m",
        *,
        name: str = "arm",
        base: Array = IDENTITY,
        tool: Array = IDENTITY,
    ) -> Self:
        """Return the arm of a Denavit-Hartenberg table.

        Args:
            rows: One for each joint, with the keys that a row has in a world file: `theta_deg` or `theta` [rad], `d`,
                `a`, `alpha_deg` or `alpha` [rad]; the joint's value is added to theta, or to d where `slide` is true;
                `range_deg` or `range` [rad], `mass`, `center`, `inertia` and so on. Or four numbers: theta [rad], d, a,
                alpha [rad]. Missing numbers are 0; without `mass` a link has that of a capsule of 1000 kg/m^3.
            convention: 'standard' (A = Rz Tz Tx Rx) or 'modified' (A = Rx Tx Rz Tz).
            unit: Unit of lengths in the rows, 'm' or 'mm'. Poses of the arm are always in metres.
            name: Its name.
            base: world_from_base, shape (4, 4) [m].
            tool: flange_from_tool, shape (4, 4) [m].

        Raises:
            ValueError: A row is wrong; the message says which and why.

        References:
            Spong, Hutchinson, Vidyasagar, Robot Modeling and Control (2006), section 3.2; Craig, Introduction to
            Robotics (1989), section 3.4.
        """
        links = links_of(rows, convention=convention, unit=unit)
        return cls(links=links, name=name, convention=convention, base=base, tool=tool)

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.links)

    @property
    def parents(self) -> tuple[int, ...]:
        """Number of the link that carries each, counted from 0, -1 for the base."""
        return self._chain.parents

    @property
    def carrier(self) -> int:
        """Number of the link that carries the flange and the tool, counted from 0."""
        return self._chain.end

    @property
    def limits(self) -> tuple[Array, Array]:
        """Lower and upper limits of the joints, infinite without limits, shape (n,) each [rad, m]."""
        return np.array([link.lower for link in self.links]), np.array([link.upper for link in self.links])

    def fkine(self, q: ArrayLike) -> Array:
        """Return world_from_tool, shape (..., 4, 4) [m], at q of shape (..., n).

        References:
            Spong, Hutchinson, Vidyasagar (2006), section 3.2.
        """
        return self.posture(q).tool

    def posture(self, q: ArrayLike) -> Posture:
        """Return the poses of all joints, links and the tool at q, shape (..., n)."""
        return posture_at(self._chain, self._values("q", q))

    def jacob0(self, q: ArrayLike) -> Array:
        """Return the Jacobian of the tool in the world frame.

        Args:
            q: Shape (..., n).

        Returns:
            Shape (..., 6, n): linear velocity of the tool's origin above angular velocity [m/rad, 1; 1, rad/m].

        References:
            Spong, Hutchinson, Vidyasagar (2006), section 4.6; Corke (2017), section 8.1.
        """
        return tool_jacobian(self._chain, self._values("q", q), in_tool=False)

    def jacobe(self, q: ArrayLike) -> Array:
        """Return the Jacobian like `jacob0`, with velocities along the axes of the tool, shape (..., 6, n)."""
        return tool_jacobian(self._chain, self._values("q", q), in_tool=True)

    def ikine(self, T: ArrayLike, q0: ArrayLike | None = None, *, mask: Sequence[float] = (1.0,) * 6) -> Reached:
        """Return joint values that bring the tool to poses.

        Values are within the joints' limits, shifted by whole turns if necessary. Damped least squares search for the
        nearest solution from `q0`, and if they fail, from seeded random starts.

        Args:
            T: world_from_tool, shape (..., 4, 4) [m].
            q0: Initial values, shape (..., n) or (n,); by default the middle of the limits, or 0.
            mask: Weights of x, y, z and of the rotation about them; 0 for free coordinates, as for an arm with fewer
                than six joints.

        Returns:
            Values, and for each pose whether it was reached: within 1e-10 m and 1e-10 rad.

        Raises:
            ValueError: T is not a pose, or shapes do not match.

        References:
            Sugihara, IEEE Trans. Robotics 27(5), 2011; Corke (2017), section 7.2.2.
        """
        goals = np.asarray(T, dtype=float)
        if goals.shape[-2:] != (4, 4) or not all(map(is_rigid, goals.reshape(-1, 4, 4))):
            raise ValueError("T holds no poses; give homogeneous transforms of shape (..., 4, 4)")
        lower, upper = self.limits
        start = self._values("q0", self._middle() if q0 is None else q0)
        start = np.broadcast_to(start, (*goals.shape[:-2], self.n)).reshape(-1, self.n)
        weights = np.asarray(mask, dtype=float)
        found = solve(PoseGoals(self._chain, lower, upper, goals.reshape(-1, 4, 4), weights), start)
        shape = goals.shape[:-2]
        return Reached(
            found.q.reshape(*shape, self.n),
            found.converged.reshape(shape),
            found.distance.reshape(shape),
            found.angle.reshape(shape),
        )

    def rne(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> Array:
        """Return the torques for a motion, including those for rotors and friction.

        Args:
            q: Values of the joints, shape (..., n) [rad, m].
            qd: Their rates, shape (..., n) [rad/s, m/s].
            qdd: Their accelerations, shape (..., n) [rad/s^2, m/s^2].

        Returns:
            Torques at the joints, shape (..., n) [N m, N].

        References:
            Featherstone, Rigid Body Dynamics Algorithms (2008), section 5.3; Corke (2017), sections 9.1 and 9.2.
        """
        q, qd, qdd = self._several(q=q, qd=qd, qdd=qdd)
        rigid = self._rigid(posture_at(self._chain, q), qd, qdd, np.array(self.gravity))
        return rigid + self._masses.armature * qdd + dynamics.friction(self._masses, qd)

    def rne_nofriction(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> Array:
        """Return the torques of `rne` without friction, shape (..., n) [N m, N]."""
        q, qd, qdd = self._several(q=q, qd=qd, qdd=qdd)
        rigid = self._rigid(posture_at(self._chain, q), qd, qdd, np.array(self.gravity))
        return rigid + self._masses.armature * qdd

    def friction(self, qd: ArrayLike) -> Array:
        """Return the torques of friction, shape (..., n) [N m, N], at rates of that shape.

        Viscous friction of a motor is multiplied by the square of its gear ratio, dry friction by the ratio (Corke
        (2017), section 9.1.1); at rest there is none.
        """
        return dynamics.friction(self._masses, self._values("qd", qd))

    def inertia(self, q: ArrayLike) -> Array:
        """Return the mass matrix, rotors included, shape (..., n, n) [kg m^2, kg m, kg], at q of shape (..., n).

        References:
            Spong, Hutchinson, Vidyasagar (2006), equation 7.50.
        """
        return dynamics.mass_matrix(self._chain, self._masses, self.posture(q))

    def coriolis(self, q: ArrayLike, qd: ArrayLike) -> Array:
        """Return the matrix C such that C @ qd are the torques of Coriolis and centrifugal forces.

        It is the one from the Christoffel symbols: dM/dt - 2 C is skew-symmetric.

        Args:
            q: Shape (..., n) [rad, m].
            qd: Shape (..., n) [rad/s, m/s].

        Returns:
            Shape (..., n, n).

        References:
            Spong, Hutchinson, Vidyasagar (2006), equations 7.62 to 7.65.
        """
        q, qd = self._several(q=q, qd=qd)
        posture = _widened(posture_at(self._chain, q))
        columns = self._bilinear(posture, qd[..., None, :], np.eye(self.n))
        return np.swapaxes(columns, -1, -2)

    def gravload(self, q: ArrayLike) -> Array:
        """Return the torques that hold the arm against gravity, shape (..., n) [N m, N], at q of that shape."""
        return dynamics.gravity_torques(self._chain, self._masses, self.posture(q), np.array(self.gravity))

    def regressor(self, q: ArrayLike, qd: ArrayLike, reference: ArrayLike, qdd: ArrayLike) -> Array:
        """Return the matrix Y of M(q) qdd + C(q, qd) reference + g(q) = Y @ parameters, without motors.

        Args:
            q: Values of the joints, shape (..., n) [rad, m].
            qd: Their rates, shape (..., n).
            reference: The rates by which C is multiplied, shape (..., n); those of the joints for `rne`.
            qdd: Accelerations, shape (..., n).

        Returns:
            Shape (..., n, 10 n); the ten numbers of each link are those of `parameters`.

        References:
            Slotine and Li, Int. J. of Robotics Research 6(3), 1987, section 2; Spong, Hutchinson, Vidyasagar (2006),
            section 7.5.3.
        """
        q, qd, reference, qdd = self._several(q=q, qd=qd, reference=reference, qdd=qdd)
        posture, still, weightless = posture_at(self._chain, q), np.zeros_like(q), np.zeros(3)
        rest = dynamics.regressor(self._chain, posture, still, qdd=qdd, gravity=np.array(self.gravity))
        rates = np.stack([0.5 * (qd + reference), 0.5 * (qd - reference)])
        # C(q, u) v is bilinear and symmetric, so it is the difference of two squares.
        plus, minus = dynamics.regressor(self._chain, posture, rates, qdd=still, gravity=weightless)
        return np.asarray(rest + plus - minus)

    def parameters(self) -> Array:
        """Return the numbers that `regressor` multiplies, shape (10 n,).

        For each link its mass [kg], mass times centre (3) [kg m], and Ixx, Iyy, Izz, Ixy, Iyz, Ixz about the origin of
        its frame [kg m^2].
        """
        return dynamics.parameters(self.links)

    def armature(self) -> Array:
        """Return the inertia of the rotors reflected to the joints, shape (n,) [kg m^2, kg]."""
        return self._masses.armature.copy()

    def plot(self, q: ArrayLike) -> "Figure":
        """Return a picture of the arm at q, shape (n,), or at several, shape (k, n), as a matplotlib figure."""
        from mjsim.mechanics.arm_drawing import drawing

        return drawing(self.name, self.links, self._chain, self.posture(np.atleast_2d(np.asarray(q, dtype=float))))

    def draw(self, axes: object, q: ArrayLike, *, bounds: Array | None = None) -> None:
        """Draw the arm into 3-D axes of matplotlib at q, shape (n,) or (k, n).

        Args:
            axes: The axes.
            q: Values of the joints; the last row is drawn strongest.
            bounds: Points that the view includes, shape (m, 3) [m], such as `extent` gives; by default the arm.
        """
        from mjsim.mechanics.arm_drawing import draw_arm

        posture = self.posture(np.atleast_2d(np.asarray(q, dtype=float)))
        draw_arm(axes, self.links, self._chain, posture, bounds=bounds)

    def extent(self, q: ArrayLike) -> Array:
        """Return the points of the drawn arm at q of shape (k, n), shape (m, 3) [m]."""
        from mjsim.mechanics.arm_drawing import extent_of

        return extent_of(self.links, self._chain, self.posture(np.atleast_2d(np.asarray(q, dtype=float))))

    def moved(self, base: Array, *, tool: Array | None = None) -> "Arm":
        """Return the same arm on another base, world_from_base, and with another tool, shape (4, 4) each [m]."""
        return dataclasses.replace(self, base=base, tool=self.tool if tool is None else tool)

    def _rigid(self, posture: Posture, qd: Array, qdd: Array, gravity: Array) -> Array:
        return dynamics.rigid_torques(self._chain, self._masses, posture, qd, qdd=qdd, gravity=gravity)

    def _bilinear(self, posture: Posture, u: Array, v: Array) -> Array:
        """Return C(q, u) v, shape (..., n): bilinear and symmetric, so the difference of two squares."""
        u, v = np.broadcast_arrays(u, v)
        still, weightless = np.zeros_like(u), np.zeros(3)
        plus = self._rigid(posture, 0.5 * (u + v), still, weightless)
        return plus - self._rigid(posture, 0.5 * (u - v), still, weightless)

    def _middle(self) -> Array:
        lower, upper = self.limits
        both = np.isfinite(lower) & np.isfinite(upper)
        return np.where(
            both, 0.5 * (np.where(both, lower, 0.0) + np.where(both, upper, 0.0)), np.clip(0.0, lower, upper)
        )

    def _values(self, name: str, values: ArrayLike) -> Array:
        array = np.asarray(values, dtype=float)
        if array.ndim == 0 or array.shape[-1] != self.n:
            raise ValueError(
                Sentence(
                    "{name} has shape {shape}; its last axis must have {n}, one for each joint",
                    name,
                    array.shape,
                    self.n,
                )
            )
        return array

    def _several(self, **values: ArrayLike) -> list[Array]:
        return list(np.broadcast_arrays(*(self._values(name, value) for name, value in values.items())))


def _widened(posture: Posture) -> Posture:
    """Return a posture with an axis of length one before that of the joints, for several rates at a time."""
    return Posture(posture.joints[..., None, :, :, :], posture.links[..., None, :, :, :], posture.tool[..., None, :, :])


def with_links(arm: Arm, links: Sequence[Link]) -> Arm:
    """Return the same arm with other links."""
    return dataclasses.replace(arm, links=tuple(links))
