"""A compiled world set to given states, without simulation."""

import mujoco
import numpy as np

from mjsim.compile import compile_world, compiled
from mjsim.errors import UsageError
from mjsim.geometry import Array
from mjsim.sentences import Sentence
from mjsim.sim.rendering import UNSEEN, light_source
from mjsim.sim.states.scenery import Scenery
from mjsim.world import Looks, World

MAX_CONTACTS = 500
"""Largest number of contacts returned for one state."""


def bring_up(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Update bodies, cameras and lights to the state; mj_step leaves them as before its last step."""
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_camlight(model, data)


class StillScene:
    """The scene of cameras for states from a recording or from a run elsewhere."""

    def __init__(self, world: World) -> None:
        """Compile the world, in its initial state."""
        self.model: mujoco.MjModel = compiled(compile_world(world))
        self.data = mujoco.MjData(self.model)
        self.light = light_source(world, self.model)
        """Source of its baked light; None for plain light."""
        self._scenery = Scenery(self.model, world)
        self._initial_looks = self._scenery.looks

    def show(self, qpos: Array, *, qvel: Array | None = None, looks: Looks | None = None) -> None:
        """Set the state.

        Args:
            qpos: MuJoCo's positions, shape (nq,), as in ticks and recordings.
            qvel: MuJoCo's velocities, shape (nv,), for motion blur; by default at rest.
            looks: Light and removed objects; by default as at the start.

        Raises:
            UsageError: The state is not of this world.
        """
        if qpos.shape != self.data.qpos.shape:
            raise UsageError(
                Sentence("a state of {count} numbers cannot be drawn; this world has {nq}", len(qpos), self.model.nq)
            )
        self.data.qpos[:] = qpos
        self.data.qvel[:] = 0.0 if qvel is None else qvel
        self._scenery.show(self._initial_looks if looks is None else looks)
        bring_up(self.model, self.data)

    def contacts(self) -> Array:
        """Return the contacts between bodies in the current state, at most `MAX_CONTACTS`.

        Returns:
            A row of x, y, z [m], world frame, and 1 for a contact with the floor, else 0, shape (n, 4).
        """
        mujoco.mj_collision(self.model, self.data)
        contact = self.data.contact
        touching = np.flatnonzero(contact.dist <= 0.0)[:MAX_CONTACTS]
        geoms = contact.geom[touching].reshape(-1, 2)
        seen = (self.model.geom_group[geoms] != UNSEEN).all(axis=1)
        floor = (self.model.geom_type[geoms] == mujoco.mjtGeom.mjGEOM_PLANE).any(axis=1)
        rows: Array = np.column_stack([contact.pos[touching].reshape(-1, 3), floor])
        return np.asarray(rows[seen], dtype=float)
