"""Contacts of a posture: errors that must be zero, and their Jacobians; MuJoCo provides both."""

from dataclasses import dataclass
from typing import Protocol

import mujoco
import numpy as np

from mjsim.geometry import Array

BACK, FEET, HANDS, GAZE = 0, 1, 2, 3
"""Order in which contacts are relaxed if not all can hold: the gaze first, then hands, then feet, then the back."""
State = tuple[mujoco.MjModel, mujoco.MjData]


class Contact(Protocol):
    """A condition that a posture must meet."""

    @property
    def name(self) -> str:
        """Name of the contact."""

    @property
    def rank(self) -> int:
        """Contacts of higher ranks are relaxed before this one."""

    @property
    def size(self) -> int:
        """Number of error components."""

    def error(self, state: State) -> Array:
        """Return the error, shape (size,) [m, or rad for a direction]."""

    def jacobian(self, state: State) -> Array:
        """Return the derivative of the error by the velocities of the model, shape (size, nv)."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _SiteContact:
    """A condition on one site."""

    name: str
    """Name of the contact."""
    site: str
    """Name of the site in the model."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PointContact(_SiteContact):
    """A site coincides with a point."""

    target: Array
    """World frame, shape (3,) [m]."""
    rank: int = HANDS
    size: int = 3

    def error(self, state: State) -> Array:
        """Return the vector from target to site, world frame, shape (3,) [m]."""
        return site_place(state, self.site) - self.target

    def jacobian(self, state: State) -> Array:
        """Return the Jacobian of the site's position, shape (3, nv) [m/rad, m/m]."""
        return site_jacobians(state, self.site)[0]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlaneContact(_SiteContact):
    """A site lies in a plane: fixed in the world, or attached to another site, as the back on a backrest."""

    normal: Array
    """Normal of the plane, world frame, shape (3,)."""
    base: str | None = None
    """A site in the plane; by default the origin of the world."""
    offset: float = 0.0
    """Distance of the plane from its base, along its normal [m]."""
    rank: int = BACK
    size: int = 1

    def error(self, state: State) -> Array:
        """Return the distance from the plane, shape (1,) [m]."""
        base = np.zeros(3) if self.base is None else site_place(state, self.base)
        return np.array([self.normal @ (site_place(state, self.site) - base) - self.offset])

    def jacobian(self, state: State) -> Array:
        """Return the Jacobian of the distance, shape (1, nv)."""
        moved = site_jacobians(state, self.site)[0]
        if self.base is not None:
            moved = moved - site_jacobians(state, self.base)[0]
        return np.asarray(self.normal @ moved)[None]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LineContact(_SiteContact):
    """A site lies on a line through a point, at any distance."""

    point: Array
    """World frame, shape (3,) [m]."""
    direction: Array
    """Unit vector, world frame, shape (3,)."""
    rank: int = HANDS
    size: int = 3

    def error(self, state: State) -> Array:
        """Return the vector from the line to the site, world frame, shape (3,) [m]."""
        return self._across() @ (site_place(state, self.site) - self.point)

    def jacobian(self, state: State) -> Array:
        """Return the Jacobian of this vector, shape (3, nv)."""
        return np.asarray(self._across() @ site_jacobians(state, self.site)[0])

    def _across(self) -> Array:
        return np.eye(3) - np.outer(self.direction, self.direction)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GazeContact(_SiteContact):
    """The line of sight of a head passes through a point; the site is between the eyes, in the frame of the head."""

    target: Array
    """World frame, shape (3,) [m]."""
    sight: Array
    """Unit vector of the line of sight, frame of the head, shape (3,)."""
    rank: int = GAZE
    size: int = 3

    def error(self, state: State) -> Array:
        """Return the line of sight minus the direction of the target, world frame, shape (3,) [rad if small]."""
        ahead, _ = self._directions(state)
        return site_axes(state, self.site) @ self.sight - ahead

    def jacobian(self, state: State) -> Array:
        """Return the Jacobian of this difference, shape (3, nv)."""
        move, turn = site_jacobians(state, self.site)
        ahead, distance = self._directions(state)
        sight = site_axes(state, self.site) @ self.sight
        # The line of sight turns with the head: d sight = omega x sight; the direction changes as the eye moves.
        turned = -_cross_matrix(sight) @ turn
        return np.asarray(turned + (np.eye(3) - np.outer(ahead, ahead)) @ move / distance)

    def _directions(self, state: State) -> tuple[Array, float]:
        between = self.target - site_place(state, self.site)
        distance = max(float(np.linalg.norm(between)), 1e-6)
        return between / distance, distance


def site_place(state: State, site: str) -> Array:
    """Return the position of a site, world frame, shape (3,) [m]."""
    model, data = state
    return np.array(data.site_xpos[model.site(site).id])


def site_axes(state: State, site: str) -> Array:
    """Return world_from_site, the axes of a site, shape (3, 3)."""
    model, data = state
    return np.array(data.site_xmat[model.site(site).id]).reshape(3, 3)


def site_jacobians(state: State, site: str) -> tuple[Array, Array]:
    """Return the translational and rotational Jacobians of a site, world frame, shape (3, nv) each."""
    model, data = state
    move, turn = np.zeros((3, model.nv)), np.zeros((3, model.nv))
    mujoco.mj_jacSite(model, data, move, turn, model.site(site).id)
    return move, turn


def _cross_matrix(vector: Array) -> Array:
    """Return the matrix of the cross product with `vector` on the left, shape (3, 3)."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
