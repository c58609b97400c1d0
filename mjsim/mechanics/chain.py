"""Frames, axes and Jacobians along a chain of links, vectorised over leading axes.

References:
    Spong, Hutchinson, Vidyasagar (2006), section 4.6; Lynch and Park (2017), chapters 4 and 5.
"""

from dataclasses import dataclass

import numpy as np

from mjsim.geometry import Array
from mjsim.mechanics.links import Link
from mjsim.mechanics.transforms import about_z, cross, inverted


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """The links of an arm as arrays, in the order from the base."""

    first: Array
    """world_from_base, shape (4, 4)."""
    last: Array
    """flange_from_tool, shape (4, 4)."""
    before: Array
    """Of each link, shape (n, 4, 4)."""
    after: Array
    """Of each link, shape (n, 4, 4)."""
    slides: Array
    """1.0 where a joint slides, else 0.0, shape (n,)."""
    turns: Array
    """1.0 where a joint revolves, else 0.0, shape (n,)."""


@dataclass(frozen=True, slots=True, eq=False)
class Posture:
    """Where all parts of an arm are at some values of its joints, world frame."""

    joints: Array
    """world_from_joint, each with its own motion, shape (..., n, 4, 4)."""
    links: Array
    """world_from_link, shape (..., n, 4, 4)."""
    tool: Array
    """world_from_tool, shape (..., 4, 4)."""

    @property
    def axes(self) -> Array:
        """Direction of each joint's axis, shape (..., n, 3)."""
        return self.joints[..., :3, 2]

    @property
    def points(self) -> Array:
        """A point on each joint's axis, shape (..., n, 3) [m]."""
        return self.joints[..., :3, 3]


def chain_of(links: tuple[Link, ...], base: Array, tool: Array) -> Chain:
    """Return links as arrays."""
    return Chain(
        first=base,
        last=tool,
        before=np.array([link.before for link in links]),
        after=np.array([link.after for link in links]),
        slides=np.array([float(link.slide) for link in links]),
        turns=np.array([float(not link.slide) for link in links]),
    )


def posture_at(chain: Chain, q: Array) -> Posture:
    """Return where all parts are.

    Args:
        chain: The arm.
        q: Values of its joints, shape (..., n) [rad, m].
    """
    moved = chain.before @ about_z(q * chain.turns, q * chain.slides)
    steps = moved @ chain.after
    count = q.shape[-1]
    links = np.empty_like(steps)
    reached = chain.first
    for number in range(count):
        links[..., number, :, :] = reached = reached @ steps[..., number, :, :]
    joints = np.empty_like(moved)
    joints[..., 0, :, :] = chain.first @ moved[..., 0, :, :]
    joints[..., 1:, :, :] = links[..., :-1, :, :] @ moved[..., 1:, :, :]
    return Posture(joints, links, reached @ chain.last)


def jacobian(chain: Chain, posture: Posture, points: Array) -> tuple[Array, Array]:
    """Return how points at the end of the arm move with its joints, world frame.

    Args:
        chain: The arm.
        posture: Where it is.
        points: Shape (..., 3) [m].

    Returns:
        linear: Derivatives of the points by the joints, shape (..., 3, n) [m/rad, 1].
        angular: Of their frames' rotation, shape (..., 3, n) [1, rad/m].
    """
    axes = posture.axes
    angular = chain.turns[:, None] * axes
    linear = chain.slides[:, None] * axes + cross(angular, points[..., None, :] - posture.points)
    return np.swapaxes(linear, -1, -2), np.swapaxes(angular, -1, -2)


def tool_jacobian(chain: Chain, q: Array, *, in_tool: bool) -> Array:
    """Return the Jacobian of the tool, linear rows above angular, shape (..., 6, n).

    Args:
        chain: The arm.
        q: Values of its joints, shape (..., n) [rad, m].
        in_tool: Whether velocities are along the axes of the tool, else of the world.
    """
    posture = posture_at(chain, q)
    linear, angular = jacobian(chain, posture, posture.tool[..., :3, 3])
    if in_tool:
        tool_from_world = inverted(posture.tool)[..., :3, :3]
        linear, angular = tool_from_world @ linear, tool_from_world @ angular
    return np.concatenate([linear, angular], axis=-2)
