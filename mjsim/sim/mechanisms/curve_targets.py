"""Points on curves: the targets of the physics' constraints that hold them there.

A tendon between the point and a site far away across the curve, of constant length, holds the point in one direction
across. There are two for each curve, one in a plane mechanism. Before every step their sites are moved to the
current point, so that the tendons only correct the motion within one step; the curvature enters as an acceleration.
With n a direction across and s the length along the curve, fixed to the body that carries it,

    n . (P'' - C'') = 2 n . (w x T s') + n . C_ss s'^2

where C'' is the acceleration of the body's material point at the point, w its angular velocity, and T = C_s.

References:
    Haug, Computer-Aided Kinematics and Dynamics of Mechanical Systems (1989), section 3.4; closures.py explains
    why a constraint settles beside its target.
"""

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.mechanics import cross
from mjsim.world import CurvePoint, Mechanism


class TrackAtWork:
    """One point on a curve, and the two constraints of the physics that hold it there."""

    def __init__(self, model: mujoco.MjModel, mechanism: Mechanism, track: CurvePoint) -> None:
        """Find the constraints.

        Args:
            model: The compiled world.
            mechanism: Mechanism of the point.
            track: The track.
        """
        full, assembly = f"{mechanism.name}/{track.name}", mechanism.assembly
        joint = assembly.linkage.joints[track.ghost - 1]
        curve = joint.primitives[0].curve
        assert curve is not None, "made for it"
        self._model, self._curve = model, curve
        self._body_from_curve = joint.before if joint.parent else mechanism.world_from_ground @ joint.before
        self._along = float(assembly.start[track.column])
        self._point = model.site(f"{full}.b").id
        names = {model.tendon(number).name: number for number in range(model.ntendon)}
        self._axes = [count for count in (0, 1) if f"{full}.{count}" in names]
        self._sites = [model.site(f"{full}.a{count}").id for count in self._axes]
        self._equalities = [model.equality(f"{full}.{count}").id for count in self._axes]
        self._lever = float(model.tendon_length0[names[f"{full}.{self._axes[0]}"]])
        self._slope, self._turn, self._change = (np.zeros((3, model.nv)) for _ in range(3))

    def aim(self, gave: Array, scratch: mujoco.MjData) -> None:
        """Set the targets of the constraints in the next step.

        Args:
            gave: Yield of constraints in the step before, by their numbers, shape (neq,) [m].
            scratch: The current state, with kinematics and velocities computed.
        """
        half = self._model.opt.timestep**2 / 2.0
        for equality, change in self.place(scratch).items():
            self._model.eq_data[equality, 0] = gave[equality] - half * change

    def place(self, scratch: mujoco.MjData) -> dict[int, float]:
        """Move the sites to the point, and return the accelerations of the tendons' lengths due to velocities alone.

        Args:
            scratch: A state with kinematics and velocities computed.

        Returns:
            The second derivative of the length minus the part due to joint accelerations [m/s^2], by the number of the
            constraint.
        """
        model, carrier = self._model, int(self._model.site_bodyid[self._sites[0]])
        pose = self._body_from_curve
        body, at = scratch.xmat[carrier].reshape(3, 3), scratch.xpos[carrier]
        point = scratch.site_xpos[self._point]
        inner = pose[:3, :3].T @ (body.T @ (point - at) - pose[:3, 3])
        self._along = self._curve.follow(inner, self._along)
        turned = body @ pose[:3, :3]
        on, slope, curl = self._curve.at(self._along)
        on_curve = at + body @ (pose[:3, :3] @ on + pose[:3, 3])
        ends = [
            self._motion(scratch, int(model.site_bodyid[self._point]), point),
            self._motion(scratch, carrier, on_curve),
        ]
        tangent, bend = turned @ slope, turned @ curl
        speed = float(tangent @ (ends[0][0] - ends[1][0])) / float(tangent @ tangent)
        turning = 2.0 * speed * cross(ends[1][2], tangent)
        gap = ends[0][1] - ends[1][1] - turning - bend * speed**2
        found, normals = {}, self._curve.across(slope)
        for site, equality, axis in zip(self._sites, self._equalities, self._axes, strict=True):
            across = normals[axis]
            model.site_pos[site] = pose[:3, :3] @ (on + self._lever * across) + pose[:3, 3]
            # The length increases as the point moves away from the site.
            found[equality] = -float(turned @ across @ gap)
        return found

    def _motion(self, scratch: mujoco.MjData, body: int, point: Array) -> tuple[Array, Array, Array]:
        """Return velocity, velocity-dependent acceleration, and angular velocity at a point, shape (3,) each."""
        speeds = scratch.qvel
        mujoco.mj_jac(self._model, scratch, self._slope, self._turn, point, body)
        mujoco.mj_jacDot(self._model, scratch, self._change, None, point, body)
        return self._slope @ speeds, self._change @ speeds, self._turn @ speeds


class Tracks:
    """All points on curves of a mechanism."""

    def __init__(self, model: mujoco.MjModel, mechanism: Mechanism) -> None:
        """Find the points."""
        self._model = model
        self._all = [TrackAtWork(model, mechanism, track) for track in mechanism.assembly.tracks]

    def __bool__(self) -> bool:
        """Whether there are any."""
        return bool(self._all)

    def aim(self, gave: Array, scratch: mujoco.MjData) -> None:
        """Set all targets in the next step; `scratch` holds the current state, and is computed here."""
        self._work_out(scratch)
        for each in self._all:
            each.aim(gave, scratch)

    def place(self, scratch: mujoco.MjData) -> dict[int, float]:
        """Move all sites to the points in a state, which is computed here; see `TrackAtWork.place`."""
        self._work_out(scratch)
        return {equality: change for each in self._all for equality, change in each.place(scratch).items()}

    def _work_out(self, scratch: mujoco.MjData) -> None:
        mujoco.mj_kinematics(self._model, scratch)
        mujoco.mj_comPos(self._model, scratch)
        mujoco.mj_comVel(self._model, scratch)
