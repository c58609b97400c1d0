"""Closed loops of mechanisms: targets of the points that hold a loop together.

A constraint of MuJoCo reduces its residual r by J a = -b r' - k r, and ignores the part of r'' due to velocities
alone, c = r'' - J a. With velocities half a step before positions, and b = 1 / h and k = 1 / h^2 as in `mjsim.compile`,
r is -c / 2k after one step. The point of one side is shifted by that, so that bodies are at their exact positions. c is
that of the step before, which leaves an error of third order in the step.
"""

import mujoco
import numpy as np

from mjsim.geometry import Array

CONNECT = int(mujoco.mjtEq.mjEQ_CONNECT)


class Closures:
    """Points at which loops of a mechanism are held together."""

    def __init__(self, model: mujoco.MjModel, equalities: Array) -> None:
        """Find the points.

        Args:
            model: The compiled world.
            equalities: Numbers of the constraints of the mechanism, shape (n,).
        """
        self._model = model
        self._own = np.array([k for k in equalities if int(model.eq_type[k]) == CONNECT], dtype=int)
        self._sites = [(int(model.eq_obj1id[k]), int(model.eq_obj2id[k])) for k in self._own]
        self._rest = [model.site_pos[first].copy() for first, _ in self._sites]

    def aim(self, data: mujoco.MjData) -> None:
        """Shift the points for the next step; the state still has the accelerations of the step before."""
        count = int(data.ne)
        if not len(self._own) or not count:
            return
        mujoco.mj_rnePostConstraint(self._model, data)
        pulled = np.zeros(data.nefc)
        mujoco.mj_mulJacVec(self._model, data, pulled, data.qacc)
        rows = {int(k): row for row, k in reversed(list(enumerate(data.efc_id[:count])))}
        softness = self._model.opt.timestep**2
        for equality, (first, second), rest in zip(self._own.tolist(), self._sites, self._rest, strict=True):
            row = rows[equality]
            alone = self._parting(data, first, second) - pulled[row : row + 3]
            turned = data.xmat[self._model.site_bodyid[first]].reshape(3, 3)
            self._model.site_pos[first] = rest - softness / 2.0 * (turned.T @ alone)

    def _parting(self, data: mujoco.MjData, first: int, second: int) -> Array:
        """Return the acceleration of the first site relative to the second, world frame, shape (3,) [m/s^2]."""
        ends = []
        for site in (first, second):
            spatial = np.zeros(6)
            kind = mujoco.mjtObj.mjOBJ_SITE
            mujoco.mj_objectAcceleration(self._model, data, kind, site, spatial, 0)
            # MuJoCo's accelerations are those that an accelerometer would measure.
            ends.append(spatial[3:] if self._model.site_bodyid[site] else -self._model.opt.gravity)
        return np.asarray(ends[0] - ends[1])
