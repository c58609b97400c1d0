"""Mechanisms at work: what moves them at every step of the physics, and how they truly move at a tick."""

from collections.abc import Callable

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.mechanics import (
    JointMotion,
    SensorReadings,
    TimeSignal,
    inverted,
    jacobian,
    rotation_vector,
    tracked,
    turning,
)
from mjsim.sim.followers import Follower
from mjsim.sim.mechanism_sensors import Moment, Probe, probes_of
from mjsim.sim.streams import stream
from mjsim.world import Assembly, Mechanism, World

SLIP = 1e-6
"""Of the step by which the change of a constraint's speed is found [s]."""


class MechanismAtWork:
    """One mechanism: it writes what moves it before each step of the physics.

    The physics has speeds half a step before positions, as leapfrog methods do; at ticks they are brought together, so
    that what is read is right to the second order of the step.
    """

    every = 1

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        mechanism: Mechanism,
        *,
        seed: int,
        read: Callable[[str], bytes],
    ) -> None:
        """Set the speeds of the start.

        Args:
            model: The compiled world.
            data: Its state, at the start.
            mechanism: As the world file has it.
            seed: Of the run.
            read: Returns a file that the world names.
        """
        self._model, self._data, self.mechanism = model, data, mechanism
        self._scratch = mujoco.MjData(model)
        self._assembly = mechanism.assembly
        self._h = float(model.opt.timestep)
        self._places = _Places(model, mechanism)
        self._followers = self._make_followers()
        self._efforts = self._make_efforts(seed, read)
        self._cut_values = self._assembly.start.copy()
        self._probes: tuple[Probe, ...] = probes_of(model, mechanism)
        self._step = 0
        self._begin()

    def _make_followers(self) -> list[Follower]:
        made = []
        for drive in self._assembly.drives:
            name = self._assembly.names[drive.column] if drive.column >= 0 else drive.name
            start = float(self._assembly.start[drive.column]) if drive.column >= 0 else float(drive.signal.value(0.0))
            made.append(Follower(self._model, self._model.equality(self._full(name)).id, drive, start=start))
        return made

    def _make_efforts(self, seed: int, read: Callable[[str], bytes]) -> list[tuple[int, TimeSignal]]:
        """Return the motors, each with what it is told."""
        driven, made = {drive.number for drive in self._assembly.drives}, []
        for number, actuator in enumerate(self.mechanism.actuators):
            if number not in driven:
                rng = stream(seed, self.mechanism.name, f"{actuator.target}/signal")
                motor = self._model.actuator(self._full(actuator.target)).id
                made.append((motor, actuator.signal.made(read, rng)))
        return made

    def _full(self, name: str) -> str:
        return f"{self.mechanism.name}/{name}"

    @property
    def moved(self) -> bool:
        """Whether something moves it, so that it must act at every step."""
        return bool(self._followers or self._efforts)

    def act(self, step: int) -> None:
        """Write what moves it in the step of that number, counted from 0 at the start of the run."""
        self._step = step
        for follower in self._followers:
            follower.aim(step)
        for motor, signal in self._efforts:
            self._data.ctrl[motor] = signal.value(step * self._h)

    def _begin(self) -> None:
        """Set speeds half a step before the start."""
        dofs = self._places.dofs
        self._places.set_speeds(self._data, self._assembly)
        self.act(0)
        self._exact(0, self._data.qvel)
        self._data.qvel[dofs] -= self._h / 2.0 * self._scratch.qacc[dofs]

    def moment(self, step: int) -> Moment:
        """Return how it moves now, before the step of that number.

        Args:
            step: Counted from 0 at the start of the run.
        """
        self.act(step)
        dofs, speeds = self._places.dofs, self._data.qvel.copy()
        self._exact(step, speeds)
        speeds[dofs] += self._h / 2.0 * self._scratch.qacc[dofs]
        self._exact(step, speeds)
        mujoco.mj_rnePostConstraint(self._model, self._scratch)
        values, rates, accelerations = self._values()
        return Moment(
            model=self._model,
            data=self._scratch,
            values=values,
            speeds=rates,
            accelerations=accelerations,
            efforts=self._forces(),
        )

    def motion(self, step: int) -> tuple[JointMotion, SensorReadings]:
        """Return how its joints move and what its sensors read now, before the step of that number."""
        now = self.moment(step)
        goal = now.values.copy()
        for follower in self._followers:
            if follower.drive.column >= 0:
                goal[follower.drive.column] = follower.goal(step)
        motion = JointMotion(
            names=self._assembly.names,
            positions=now.values,
            velocities=now.speeds,
            accelerations=now.accelerations,
            torques=now.efforts,
            goal=goal,
        )
        parts = [probe.read(now) for probe in self._probes]
        readings = SensorReadings(
            names=tuple(name for probe in self._probes for name in probe.names),
            units=tuple(unit for probe in self._probes for unit in probe.units),
            values=np.concatenate([np.zeros(0), *parts]),
        )
        return motion, readings

    def _exact(self, step: int, speeds: Array) -> None:
        """Work out accelerations and forces at which loops stay closed and motions are in the scratch state.

        Args:
            step: Whose motions are followed.
            speeds: Of all freedoms of the world, shape (nv,).
        """
        model, data, scratch = self._model, self._data, self._scratch
        changes = self._changes(speeds)
        _copy_state(data, scratch, data.qpos, speeds)
        mujoco.mj_fwdPosition(model, scratch)
        mujoco.mj_fwdVelocity(model, scratch)
        wanted = {follower.equality: follower.acceleration(step) for follower in self._followers}
        for row in self._rows(scratch):
            equality = int(scratch.efc_id[row])
            scratch.efc_aref[row] = wanted.get(equality, -changes[row])
        mujoco.mj_fwdActuation(model, scratch)
        mujoco.mj_fwdAcceleration(model, scratch)
        mujoco.mj_fwdConstraint(model, scratch)

    def _rows(self, data: mujoco.MjData) -> list[int]:
        """Return the rows of its own equality constraints."""
        count = int(data.ne)
        own = np.isin(data.efc_id[:count], self._places.equalities)
        own &= data.efc_type[:count] == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        found: list[int] = np.flatnonzero(own).tolist()
        return found

    def _changes(self, speeds: Array) -> Array:
        """Return how the residuals' speeds change by the speeds alone, by row of the equality constraints."""
        ends = []
        for sign in (1.0, -1.0):
            places = self._data.qpos.copy()
            mujoco.mj_integratePos(self._model, places, speeds, sign * SLIP)
            _copy_state(self._data, self._scratch, places, speeds)
            mujoco.mj_fwdPosition(self._model, self._scratch)
            mujoco.mj_fwdVelocity(self._model, self._scratch)
            ends.append(self._scratch.efc_vel[: self._scratch.ne].copy())
        return np.asarray((ends[0] - ends[1]) / (2.0 * SLIP))

    def _values(self) -> tuple[Array, Array, Array]:
        """Return values, speeds and accelerations of all joints, those at cuts too, each of shape (values,)."""
        linkage, rows = self._assembly.linkage, self._assembly.rows
        values, speeds, accelerations = self._places.read(self._scratch, self._assembly)
        known = self._places.columns
        if len(known) == linkage.size:
            return values, speeds, accelerations
        cut = np.setdiff1d(np.arange(linkage.size), known)
        values[cut] = self._cut_values[cut]
        values = tracked(linkage, rows, values, columns=cut.tolist())
        self._cut_values = values
        matrix = jacobian(linkage, rows, values)
        speeds[cut] = np.linalg.lstsq(matrix[:, cut], -matrix[:, known] @ speeds[known], rcond=None)[0]
        right = -matrix[:, known] @ accelerations[known] - turning(linkage, rows, values, speeds)
        accelerations[cut] = np.linalg.lstsq(matrix[:, cut], right, rcond=None)[0]
        return values, speeds, accelerations

    def _forces(self) -> Array:
        """Return torques and forces of the actuators at the joints, shape (values,) [N m, N]."""
        scratch, found = self._scratch, np.zeros(self._assembly.linkage.size)
        own = self._places
        found[own.columns] = scratch.qfrc_actuator[own.dofs_by_column]
        for follower in self._followers:
            if follower.drive.column >= 0:
                found[follower.drive.column] += equality_forces(scratch, follower.equality).sum()
        return found


class Mechanisms:
    """All mechanisms of a world at work."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, world: World, *, seed: int) -> None:
        """Set them to their starts.

        Args:
            model: The compiled world.
            data: Its state, at the start.
            world: As it was written.
            seed: Of the run.
        """
        self._all = [MechanismAtWork(model, data, each, seed=seed, read=world.read_asset) for each in world.mechanisms]
        self._per_tick = world.run.steps_per_tick
        self._now: tuple[int, dict[str, tuple[JointMotion, SensorReadings]]] = -1, {}

    def acting(self) -> list[MechanismAtWork]:
        """Return those that something moves."""
        return [each for each in self._all if each.moved]

    def motions(self, tick: int) -> dict[str, JointMotion]:
        """Return how the joints of each mechanism move at a tick, by its name."""
        return {name: motion for name, (motion, _) in self._at(tick).items()}

    def readings(self, tick: int) -> dict[str, SensorReadings]:
        """Return what the sensors of each mechanism read at a tick, by its name."""
        return {name: readings for name, (_, readings) in self._at(tick).items()}

    def _at(self, tick: int) -> dict[str, tuple[JointMotion, SensorReadings]]:
        """Return all of a tick; worked out once."""
        if self._now[0] != tick:
            self._now = tick, {each.mechanism.name: each.motion(tick * self._per_tick) for each in self._all}
        return self._now[1]


def equality_forces(data: mujoco.MjData, equality: int) -> Array:
    """Return the forces of an equality constraint, shape (rows,) [N, N m]."""
    count = int(data.ne)
    own = (data.efc_id[:count] == equality) & (data.efc_type[:count] == mujoco.mjtConstraint.mjCNSTR_EQUALITY)
    return np.asarray(data.efc_force[:count][own])


def _copy_state(source: mujoco.MjData, target: mujoco.MjData, places: Array, speeds: Array) -> None:
    """Copy all that forces depend on, with other positions and speeds."""
    target.qpos[:], target.qvel[:], target.time = places, speeds, source.time
    target.ctrl[:], target.act[:] = source.ctrl, source.act
    target.qfrc_applied[:], target.xfrc_applied[:] = source.qfrc_applied, source.xfrc_applied
    target.eq_active[:], target.qacc_warmstart[:] = source.eq_active, source.qacc_warmstart


class _Places:
    """Where the values of a mechanism are in MuJoCo's state."""

    def __init__(self, model: mujoco.MjModel, mechanism: Mechanism) -> None:
        assembly, name = mechanism.assembly, mechanism.name
        columns, qpos, dofs = list[int](), list[int](), list[int]()
        self._balls: list[tuple[int, int, int, int]] = []
        for number, tree in enumerate(assembly.linkage.joints, start=1):
            if not assembly.bodies[number]:
                continue
            for primitive, column in zip(tree.primitives, tree.columns(), strict=True):
                ball = primitive.kind == "ball"
                joint = model.joint(f"{name}/{tree.name if ball else assembly.names[column]}")
                place, dof = int(joint.qposadr[0]), int(joint.dofadr[0])
                if ball:
                    self._balls.append((number, column, place, dof))
                columns += range(column, column + primitive.width)
                qpos += [place] * primitive.width
                dofs += range(dof, dof + primitive.width)
        self.columns, self._qpos = np.array(columns, dtype=int), np.array(qpos, dtype=int)
        self.dofs_by_column = np.array(dofs, dtype=int)
        self.dofs = np.sort(self.dofs_by_column)
        own = [k for k in range(model.neq) if model.equality(k).name.startswith(f"{name}/")]
        self.equalities = np.array(own, dtype=int)
        numbered = list(enumerate(assembly.bodies))
        self._bodies = [model.body(f"{name}/{body}").id if body and place else 0 for place, body in numbered]

    def set_speeds(self, data: mujoco.MjData, assembly: Assembly) -> None:
        """Write the speeds of the start."""
        data.qvel[self.dofs_by_column] = assembly.speeds[self.columns]

    def read(self, data: mujoco.MjData, assembly: Assembly) -> tuple[Array, Array, Array]:
        """Return values, speeds and accelerations, each of shape (values,); 0 for those at cuts."""
        size = assembly.linkage.size
        values, speeds, accelerations = np.zeros(size), np.zeros(size), np.zeros(size)
        values[self.columns] = data.qpos[self._qpos]
        speeds[self.columns] = data.qvel[self.dofs_by_column]
        accelerations[self.columns] = data.qacc[self.dofs_by_column]
        for number, column, _, _ in self._balls:
            tree = assembly.linkage.joints[number - 1]
            parent, body = (data.xmat[self._bodies[k]].reshape(3, 3) for k in (tree.parent, number))
            before, after = tree.before[:3, :3], inverted(tree.after)[:3, :3]
            turned = before.T @ parent.T @ body @ after
            values[column : column + 3] = tree.sign * rotation_vector(turned)
        return values, speeds, accelerations
