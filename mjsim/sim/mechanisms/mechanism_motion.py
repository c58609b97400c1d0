"""Simulated mechanisms: inputs at every physics step, and true motion at a tick."""

import math
from collections.abc import Callable, Mapping

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.mechanics import (
    JointMotion,
    SensorReadings,
    TimeSignal,
    jacobian,
    tracked,
    turning,
)
from mjsim.sim.mechanisms.closures import Closures
from mjsim.sim.mechanisms.curve_targets import Tracks
from mjsim.sim.mechanisms.energy import EnergyCount
from mjsim.sim.mechanisms.followers import Follower, yields
from mjsim.sim.mechanisms.grasps import period_of
from mjsim.sim.mechanisms.guided_joints import Leading
from mjsim.sim.mechanisms.mechanism_sensors import MechanismState, Probe, probes_of
from mjsim.sim.mechanisms.mechanism_state import (
    Places,
    actuator_forces,
    copy_state,
    equality_forces,
    equality_rows,
)
from mjsim.sim.mechanisms.pushes import Push, around, effort_signal
from mjsim.sim.streams import stream
from mjsim.world import ForceActuator, Mechanism, TorqueActuator

SOFTNESS_RATIO = 1e-5
"""Factor on the softness R of constraints in the readings, against that in the physics."""
MAX_LOOP_GAP = 0.05
"""Gap between the sides of a loop above which it counts as torn, relative to the mechanism's size."""
MAX_TURN = 0.2
"""Largest rotation of joints of loops in one step [rad]: up to this, energy stays within a tenth for a while."""
DIFFERENCE_STEP = 1e-6
"""Step of the finite difference for the change of a constraint's speed [s]."""


class MechanismAtWork:
    """One running mechanism, which writes its inputs before each step of the physics.

    The physics has velocities half a step before positions, as leapfrog methods do; at ticks both are synchronized, so
    that readings are accurate to second order in the step.
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
        """Set the initial velocities.

        Args:
            model: The compiled world.
            data: Its state at the start.
            mechanism: Mechanism of the world file.
            seed: Seed of the run.
            read: Returns the content of a file named in the world.
        """
        self._model, self._data, self.mechanism = model, data, mechanism
        self._scratch = mujoco.MjData(model)
        self._assembly = mechanism.assembly
        self._h = float(model.opt.timestep)
        self._places = Places(model, mechanism)
        self._followers = self._make_followers()
        self._leading = Leading(model, mechanism, self._places, self._followers)
        self._pushes: list[Push] = []
        ties = [each.name for each in self._assembly.couplings] + [each.name for each in self._assembly.rods]
        self._ties = [model.equality(self._full(name)).id for name in ties]
        self._efforts = self._make_efforts(seed, read)
        self._closures = Closures(model, self._places.equalities)
        kinds = model.eq_type[self._places.equalities]
        self._loops = self._places.equalities[np.isin(kinds, (mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtEq.mjEQ_WELD))]
        self._max_gap = MAX_LOOP_GAP * float(np.ptp(mechanism.spanned(), axis=0).max())
        self._tracks = Tracks(model, mechanism)
        self._cut_values = self._assembly.start.copy()
        self._probes: tuple[Probe, ...] = probes_of(model, mechanism)
        self._step, self._energy = 0, EnergyCount(model, self._places.dofs, self._followers)
        self._lag, self._gave = np.zeros(len(self._places.dofs)), np.zeros(model.neq)
        """Yield of each constraint with one row in the last step, by its number [rad, m]."""
        self._before, self._gained = data.qvel.copy(), self._lag
        """Velocities of the entire world after the last step, and the change of the mechanism's own in it [1/s]."""
        turning = model.jnt_type[model.dof_jntid[self._places.dofs]] != mujoco.mjtJoint.mjJNT_SLIDE
        self._turning = self._places.dofs[turning]
        self._widest = 0.0
        """Largest rotation of a joint of a loop in one step so far [rad]."""
        self.fault = ""
        """Reason why the last step is invalid, as text."""
        self._begin()

    def _make_followers(self) -> list[Follower]:
        made = []
        for drive in self._assembly.drives:
            name = self._assembly.names[drive.column] if drive.column >= 0 else drive.name
            start = float(self._assembly.start[drive.column]) if drive.column >= 0 else float(drive.signal.value(0.0))
            made.append(Follower(self._model, self._model.equality(self._full(name)).id, drive, start=start))
        return made

    def _make_efforts(self, seed: int, read: Callable[[str], bytes]) -> list[tuple[int, TimeSignal]]:
        """Return the motors, each with its signal."""
        driven, made = {drive.number for drive in self._assembly.drives}, []
        for number, actuator in enumerate(self.mechanism.actuators):
            if number in driven or getattr(actuator, "controller", None) is not None:
                continue
            rng = stream(seed, self.mechanism.name, f"{actuator.target}/signal")
            signal = effort_signal(self._assembly, number, actuator, read, rng)
            if actuator.target in self._assembly.names:
                made.append((self._model.actuator(self._full(actuator.target)).id, signal))
            elif isinstance(actuator, TorqueActuator | ForceActuator):
                self._pushes.append(Push(self._model, self.mechanism, actuator, signal))
        return made

    def _full(self, name: str) -> str:
        return f"{self.mechanism.name}/{name}"

    @property
    def held(self) -> bool:
        """Whether a hand holds a joint of it, so that `act` must be called at every step."""
        return bool(self._leading.holds)

    @property
    def moved(self) -> bool:
        """Whether it has inputs of its own, so that `act` must be called at every step."""
        losses = any(joint.damping or joint.friction for joint in self.mechanism.joints)
        losses = losses or any(spring.damping for spring in self._assembly.springs)
        controlled = any(getattr(each, "controller", None) is not None for each in self.mechanism.actuators)
        return len(self._places.dofs) > 1 or bool(
            controlled or self._followers or self._ties or self._tracks or self._efforts or self._pushes or losses
        )

    def act(self, step: int) -> None:
        """Write its inputs for a step, counted from 0 at the start of the run."""
        self._go_to(step)
        for follower in self._followers:
            follower.aim(step, gave=float(self._gave[follower.equality]))
        self._model.eq_data[self._ties, 0] = self._gave[self._ties]
        if self._tracks:
            copy_state(self._data, self._scratch, self._data.qpos, self._data.qvel)
            self._tracks.aim(self._gave, self._scratch)
        self._lag = self._lagging()
        self._leading.holds.aim(self._data, self._scratch, step)
        self._exert(lambda signal: around(signal, step, self._h))

    def _exert(self, value: Callable[[TimeSignal], float]) -> None:
        """Write torques and forces, and inertial forces missing in the physics.

        Args:
            value: Returns the value of a signal [N m, N].
        """
        for motor, signal in self._efforts:
            self._data.ctrl[motor] = value(signal)
        self._data.qfrc_applied[self._places.dofs] = self._lag + self._leading.holds.pull
        if self._pushes:
            mujoco.mj_kinematics(self._model, self._data)
            mujoco.mj_comPos(self._model, self._data)
            for push in self._pushes:
                push.apply(self._data, value(push.signal))

    def _lagging(self) -> Array:
        """Return the correction of forces for half a step of the velocities, shape (own freedoms,) [N m, N].

        The physics computes inertial forces from velocities half a step ago, and damping from those half a step ahead.
        Current velocities follow to first order from the change in the step before, which leaves a second-order error.
        """
        model, data, scratch, dofs, found = self._model, self._data, self._scratch, self._places.dofs, []
        scratch.qpos[:], scratch.qvel[:], forces = data.qpos, data.qvel, np.zeros(model.nv)
        mujoco.mj_kinematics(model, scratch)
        mujoco.mj_comPos(model, scratch)
        for gained in (0.0, self._gained / 2.0):
            scratch.qvel[dofs] += gained
            mujoco.mj_comVel(model, scratch)
            mujoco.mj_rne(model, scratch, 0, forces)
            found.append(forces[dofs])
        return np.asarray(found[0] - found[1] + model.dof_damping[dofs] * self._gained / 2.0)

    def settle(self, step: int) -> None:
        """Move the mechanism to its state at the end of a tick, before a given step."""
        self.fault = self._found_fault()
        if self.moved or self.held:
            self._go_to(step)

    def _go_to(self, step: int) -> None:
        """Record the results of the step before a given one, once, while the state still has its forces."""
        if step == self._step:
            return
        self._energy.add(self._data, self._before, self._lag, self._step)
        self._before, before = self._data.qvel.copy(), self._before
        self._gained = (self._before - before)[self._places.dofs]
        self._closures.aim(self._data)
        self._gave = yields(self._model, self._data)
        # Prescribed motions determine its motion, regardless of its energy.
        if len(self._loops) and not self._followers:
            turned = self._h * float(np.abs(self._before[self._turning]).max(initial=0.0))
            self._widest = max(self._widest, turned)
        self._step = step

    def lead(self, goals: Mapping[str, float | None], step: int) -> None:
        """From a step on, move joints to values and hold them there, as `Leading.lead` does [rad, m]."""
        self._leading.lead(goals, step, self._data)
        # If only a hand moved it, no later step clears this force.
        self._data.qfrc_applied[self._places.dofs] = self._lag + self._leading.holds.pull

    def barred(self, goals: Mapping[str, float | None], step: int) -> str:
        """Return why its loops do not allow the motion of `lead`, as text; '' if they do."""
        return self._leading.barred(goals, step, self._data)

    def locked(self, step: int) -> str:
        """Return why its loops do not allow its motions at a step, as text; '' if they do."""
        return self._leading.locks.locked(step, self._cut_values)

    def _found_fault(self) -> str:
        """Return a description of a torn loop, or of one that rotates too far within a step to keep its energy."""
        data, name = self._data, self.mechanism.name
        if not len(self._loops):
            return ""
        rows = np.flatnonzero(np.isin(data.efc_id[: data.ne], self._loops))
        if np.abs(data.efc_pos[rows]).max(initial=0.0) > self._max_gap:
            return f"a loop of mechanism '{name}' is torn"
        if self._widest <= MAX_TURN:
            return ""
        return (
            f"mechanism '{name}' turns by {math.degrees(self._widest):.0f} degrees in one step of the physics, too far"
            " for its loops to conserve energy; drive it more slowly, or reduce run: step_ms"
        )

    def _begin(self) -> None:
        """Set speeds half a step before the start."""
        dofs = self._places.dofs
        self._places.set_speeds(self._data, self._assembly)
        self.act(0)
        self._exact(0, self._data.qvel)
        self._energy.begin(self._scratch)
        self._gained = self._h * self._scratch.qacc[dofs]
        self._data.qvel[dofs] -= self._gained / 2.0
        self._before = self._data.qvel.copy()
        self._closures.aim(self._scratch)

    def state(self, step: int) -> MechanismState:
        """Return its current state, before a given step.

        Args:
            step: Number of the step, counted from 0 at the start of the run.
        """
        self.act(step)
        self._exert(lambda signal: float(signal.value(step * self._h)))
        dofs, speeds = self._places.dofs, self._data.qvel.copy()
        self._exact(step, speeds)
        speeds[dofs] += self._h / 2.0 * self._scratch.qacc[dofs]
        self._exact(step, speeds)
        mujoco.mj_rnePostConstraint(self._model, self._scratch)
        return self._motion_state(step, *self._energy.now(self._scratch, step))

    def _motion_state(self, step: int, work: float, lost: float) -> MechanismState:
        """Return its state in the scratch data, with work and losses up to now [J]."""
        values, rates, accelerations = self._values()
        return MechanismState(
            model=self._model,
            data=self._scratch,
            values=values,
            speeds=rates,
            accelerations=accelerations,
            efforts=actuator_forces(self._scratch, self._places, self._followers, self._assembly.linkage.size),
            pulls={each.drive.name: self._pull(each, step) for each in self._followers if each.drive.column < 0},
            work=work,
            lost=lost,
        )

    def motion(self, step: int) -> tuple[JointMotion, SensorReadings]:
        """Return the current motion of its joints and the readings of its sensors, before a given step."""
        now = self.state(step)
        goal = now.values.copy()
        for follower in self._followers:
            if follower.drive.column >= 0:
                goal[follower.drive.column] = follower.goal(step)
        for column, value in self._leading.holds.goals(step).items():
            # A hand at a cut or on a curve does not know whole turns.
            period = 0.0 if column in self._places.columns else period_of(self._assembly, column)
            goal[column] = value + (period * round((now.values[column] - value) / period) if period else 0.0)
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
        """Compute accelerations and forces that satisfy loops and motions exactly in the scratch data.

        Args:
            step: Step of the motions.
            speeds: Velocities of all freedoms of the world, shape (nv,).
        """
        model, data, scratch = self._model, self._data, self._scratch
        changes = self._changes(speeds)
        copy_state(data, scratch, data.qpos, speeds)
        bends = self._tracks.place(scratch) if self._tracks else {}
        copy_state(data, scratch, data.qpos, speeds)
        flags, tolerance = int(model.opt.disableflags), float(model.opt.tolerance)
        # With islands, the solver would use copies of what is changed below.
        model.opt.disableflags, model.opt.tolerance = flags | int(mujoco.mjtDisableBit.mjDSBL_ISLAND), 0.0
        mujoco.mj_fwdPosition(model, scratch)
        mujoco.mj_fwdVelocity(model, scratch)
        # Here the speeds are the current ones.
        scratch.qfrc_applied[self._places.dofs] -= self._lag
        accelerations = self._accelerations(step)
        for row in equality_rows(scratch, self._places.equalities):
            equality = int(scratch.efc_id[row])
            scratch.efc_aref[row] = accelerations.get(equality, 0.0) - bends.get(equality, changes[row])
            # Constraints that are soft in the physics, for stability, are rigid here.
            scratch.efc_R[row] *= SOFTNESS_RATIO
            scratch.efc_D[row] = 1.0 / scratch.efc_R[row]
        mujoco.mj_fwdActuation(model, scratch)
        mujoco.mj_fwdAcceleration(model, scratch)
        mujoco.mj_fwdConstraint(model, scratch)
        model.opt.disableflags, model.opt.tolerance = flags, tolerance

    def _accelerations(self, step: int) -> dict[int, float]:
        """Return the accelerations of followed motions at a step, by the number of the constraint [1/s^2]."""
        return {follower.equality: follower.acceleration(step) for follower in self._followers}

    def _changes(self, speeds: Array) -> Array:
        """Return the residuals' accelerations due to velocities alone, by row of the equality constraints."""
        ends = []
        for sign in (1.0, -1.0):
            places = self._data.qpos.copy()
            mujoco.mj_integratePos(self._model, places, speeds, sign * DIFFERENCE_STEP)
            copy_state(self._data, self._scratch, places, speeds)
            mujoco.mj_fwdPosition(self._model, self._scratch)
            mujoco.mj_fwdVelocity(self._model, self._scratch)
            ends.append(self._scratch.efc_vel[: self._scratch.ne].copy())
        return np.asarray((ends[0] - ends[1]) / (2.0 * DIFFERENCE_STEP))

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

    def _pull(self, follower: Follower, step: int) -> tuple[float, float]:
        """Return the force between two points at a followed distance, and the rate of the distance [N, m/s]."""
        force = float(equality_forces(self._scratch, follower.equality).sum())
        return force, follower.middle_speed(step)
