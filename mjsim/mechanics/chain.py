"""Frames, axes and Jacobians along a chain of links, vectorised over leading axes.

References:
    Spong, Hutchinson, Vidyasagar (2006), section 4.6; Lynch and Park (2017), chapters 4 and 5.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.mechanics.arm_links import Link
from mjsim.mechanics.transforms import about_z, cross, inverted
from mjsim.sentences import Sentence


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """The links of an arm as arrays, each after the one that carries it."""

    first: Array
    """world_from_base, shape (4, 4)."""
    last: Array
    """flange_from_tool, shape (4, 4)."""
    before: Array
    """Fixed transform before the joint of each link, shape (n, 4, 4)."""
    after: Array
    """Fixed transform after the joint of each link, shape (n, 4, 4)."""
    slides: Array
    """1.0 for prismatic joints, else 0.0, shape (n,)."""
    turns: Array
    """1.0 for revolute joints, else 0.0, shape (n,)."""
    parents: tuple[int, ...]
    """Number of the link that carries each, -1 for the base."""
    carried: Array
    """1.0 where a joint (column) moves a link (row), else 0.0, shape (n, n)."""
    end: int
    """Number of the link that carries the tool."""
    serial: bool
    """Whether each link is carried by the one before it."""
    jointed: NDArray[np.intp]
    """Numbers of the links that another one carries, shape (m,)."""
    carriers: NDArray[np.intp]
    """Numbers of the links that carry those, shape (m,)."""

    def outwards(self, values: Array) -> Array:
        """Return sums over the links from the base to each, shape (..., n, 3)."""
        if self.serial:
            return np.asarray(np.add.accumulate(values, axis=-2))
        return self.carried @ values

    def inwards(self, values: Array) -> Array:
        """Return sums over each link and all that it carries, shape (..., n, 3)."""
        if self.serial:
            return np.asarray(np.add.accumulate(values[..., ::-1, :], axis=-2))[..., ::-1, :]
        return self.carried.T @ values


@dataclass(frozen=True, slots=True, eq=False)
class Posture:
    """Poses of all parts of an arm for values of its joints, world frame."""

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


def parents_of(links: tuple[Link, ...]) -> tuple[int, ...]:
    """Return the number of the link that carries each, -1 for the base.

    Raises:
        ValueError: A link comes before the one that carries it.
    """
    parents = tuple(number - 1 if link.parent is None else link.parent for number, link in enumerate(links))
    for number, parent in enumerate(parents):
        if not -1 <= parent < number:
            raise ValueError(
                Sentence(
                    "link {number} is carried by link {parent}; it must be an earlier link, or -1", number + 1, parent
                )
            )
    return parents


def chain_of(links: tuple[Link, ...], base: Array, tool: Array, end: int) -> Chain:
    """Return links as arrays; `end` is the number of the link that carries the tool."""
    parents = parents_of(links)
    carried = np.eye(len(links))
    for number, parent in enumerate(parents):
        if parent >= 0:
            carried[number] += carried[parent]
    jointed = np.array([number for number, parent in enumerate(parents) if parent >= 0], dtype=np.intp)
    return Chain(
        parents=parents,
        carried=carried,
        end=end,
        serial=parents == tuple(range(-1, len(links) - 1)),
        jointed=jointed,
        carriers=np.array(parents, dtype=np.intp)[jointed],
        first=base,
        last=tool,
        before=np.array([link.before for link in links]),
        after=np.array([link.after for link in links]),
        slides=np.array([float(link.slide) for link in links]),
        turns=np.array([float(not link.slide) for link in links]),
    )


def posture_at(chain: Chain, q: Array) -> Posture:
    """Return the poses of all parts.

    Args:
        chain: The arm.
        q: Values of its joints, shape (..., n) [rad, m].
    """
    moved = chain.before @ about_z(q * chain.turns, q * chain.slides)
    steps = moved @ chain.after
    links, carriers = np.empty_like(steps), np.empty_like(steps)
    for number, parent in enumerate(chain.parents):
        carriers[..., number, :, :] = chain.first if parent < 0 else links[..., parent, :, :]
        links[..., number, :, :] = carriers[..., number, :, :] @ steps[..., number, :, :]
    return Posture(carriers @ moved, links, links[..., chain.end, :, :] @ chain.last)


def jacobian(chain: Chain, posture: Posture, points: Array) -> tuple[Array, Array]:
    """Return the Jacobian of points at the end of the arm, world frame.

    Args:
        chain: The arm.
        posture: Its poses.
        points: Shape (..., 3) [m].

    Returns:
        linear: Derivatives of the points by the joints, shape (..., 3, n) [m/rad, 1].
        angular: Derivatives of their frames' rotation, shape (..., 3, n) [1, rad/m].
    """
    axes = posture.axes * chain.carried[chain.end][:, None]
    angular = chain.turns[:, None] * axes
    linear = chain.slides[:, None] * axes + cross(angular, points[..., None, :] - posture.points)
    return np.swapaxes(linear, -1, -2), np.swapaxes(angular, -1, -2)


def tool_jacobian(chain: Chain, q: Array, *, in_tool: bool) -> Array:
    """Return the Jacobian of the tool, linear rows above angular, shape (..., 6, n).

    Args:
        chain: The arm.
        q: Values of its joints, shape (..., n) [rad, m].
        in_tool: Whether velocities are along the axes of the tool instead of the world.
    """
    posture = posture_at(chain, q)
    linear, angular = jacobian(chain, posture, posture.tool[..., :3, 3])
    if in_tool:
        tool_from_world = inverted(posture.tool)[..., :3, :3]
        linear, angular = tool_from_world @ linear, tool_from_world @ angular
    return np.concatenate([linear, angular], axis=-2)
