"""A plant in a scene: its degrees of freedom, input, measured values, and operating point."""

import copy
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TypeVar

import mujoco
import numpy as np

from mjsim.errors import UsageError, did_you_mean
from mjsim.geometry import Array
from mjsim.lab.effects import LedJoint, PointsPush, led
from mjsim.lab.linear import NOISE_RATIO, LinearPlant, linearised, minimal_states, slope
from mjsim.lab.plant_parts import JOINTS, Measure, PlantPart, base_of, moved_joint, part_of, settled, working_point
from mjsim.lab.reduced import Reduced, Setting
from mjsim.world import Plant, World

AT_REST = 1e-9
"""Tolerance for the acceleration at an equilibrium, as a fraction of the largest relevant one, or of 1 if that is
larger."""
LOCKED_INERTIA = 1e9
"""Inertia of a locked joint, which no force moves [kg, kg m^2]."""
MAX_STEPS = 50
"""Maximum number of steps of Newton's method."""
MAX_SIMULATED = 50_000
"""Maximum number of physics steps in a response of the nonlinear plant."""
OUTPUT_BOUND = 1e6
"""Default bound on an output, above which the plant has diverged."""
DIVERGENCE_RATIO = 100.0
"""The plant has also diverged if an output exceeds this multiple of the linear plant's."""
T = TypeVar("T")
Law = Callable[[Array, Array], float]
"""Returns the value added to the input at the operating point, for states and outputs relative to that point."""


def bound_of(linear: Array) -> float:
    """Return the bound on outputs above which the plant has diverged, from the linear response, shape (outputs, k)."""
    return min(DIVERGENCE_RATIO * float(np.abs(linear).max(initial=0.0)) or OUTPUT_BOUND, OUTPUT_BOUND)


class ScenePlant:
    """A plant in a scene at its operating point."""

    def __init__(self, world: World, plant: Plant) -> None:
        """Settle it, move it to its operating point, and find the input that holds it there.

        Raises:
            UsageError: It names something that does not exist, or has no equilibrium there.
        """
        assert plant.of is not None
        assert plant.input is not None
        assert plant.outputs is not None
        self.plant = plant
        self.model, setting, rest = settled(world, plant.of)
        part = part_of(self.model, world, plant.of, setting.qpos)
        self.effect = _found(part.effects, plant.input, "input", plant)
        moved = moved_joint(part, plant.input)
        if moved is not None:
            _release(self.model, world, plant.of, self.model.joint(moved).name)
        if isinstance(self.effect, PointsPush):
            self.model.eq_active0[self.effect.equality] = 0
        self._measures = [_found(part.measures, base_of(name), "output", plant) for name in plant.outputs]
        joints = {part.joints[name] for name in map(base_of, plant.outputs) if name in part.joints}
        joints |= set() if moved is None else {moved}
        around = working_point(self.model, part, plant)
        own = [int(self.model.jnt_dofadr[joint]) for joint in (*around, *sorted(joints - set(around)))]
        locked = [dof for dof in part.dofs if part.lockable and dof not in own]
        for joint, value in around.items():
            setting.qpos[self.model.jnt_qposadr[joint]] = value
        setting = self._closed(setting, [int(self.model.jnt_dofadr[joint]) for joint in around], locked, part)
        # Locked joints stay locked in the simulation of the nonlinear plant.
        self.model.dof_armature[locked] = LOCKED_INERTIA
        self._rough = _with_friction(self.model, [dof for dof in part.dofs if dof not in locked])
        lead = [self.effect.dof] if isinstance(self.effect, LedJoint) else []
        prefer = [*dict.fromkeys([*lead, *own, *part.prefer])]
        dofs = list(part.dofs)
        self._reduced = Reduced(self.model, setting, effect=self.effect, dofs=dofs, prefer=prefer, locked=locked)
        fixed = [int(self.model.jnt_dofadr[joint]) for joint in around]
        self.setting = self._trimmed(setting, [*fixed, *lead])
        self._sunk = self._depth(world, rest)
        self.linear = self._linear()

    @property
    def dt(self) -> float:
        """Duration of a physics step [s]."""
        return float(self.model.opt.timestep)

    @property
    def held_input(self) -> float:
        """Input at the operating point."""
        return self.setting.value

    @property
    def held(self) -> str:
        """What holds the plant at its operating point, as text: a value of the input, or the force behind a motion."""
        effect = self.effect.force if isinstance(self.effect, LedJoint) else self.effect
        return f"{self.setting.value:.6g} {effect.unit}"

    @property
    def leads_value(self) -> bool:
        """Whether a joint follows the input, an angle or position, so that a step of the input would be a jump."""
        return isinstance(self.effect, LedJoint) and not self.effect.is_speed

    @property
    def dry_friction(self) -> float:
        """The largest dry friction of its joints, which a linear plant cannot have [N m, N]; 0 if there is none."""
        return 0.0 if self._rough is None else float((self._rough.dof_frictionloss - self.model.dof_frictionloss).max())

    def simulated(self, inputs: Array, *, dry_friction: bool = False, bound: float = OUTPUT_BOUND) -> Array:
        """Return the outputs of the nonlinear plant at each physics step, relative to the operating point.

        Args:
            inputs: Values added to the input at the operating point before each step, shape (k,).
            dry_friction: Whether joints have the dry friction given in the world.
            bound: Output above which the plant has diverged.

        Returns:
            Shape (outputs, k): values before each step, or after it if a joint follows the input; k is smaller than for
            the inputs if the plant diverges.
        """
        effect, model = self.effect, self._model_with(dry_friction)
        if isinstance(effect, LedJoint):
            model = copy.copy(model)
            model.dof_armature[effect.dof] = LOCKED_INERTIA
            # One more step, because it follows an input at the end of its step.
            forces = np.append(LOCKED_INERTIA * effect.accelerations(inputs, model.opt.timestep), 0.0)
            return self._stepped(model, lambda k, data, found: float(forces[k]), len(forces), bound)[:, 1:]
        return self._stepped(model, lambda k, data, found: float(inputs[k]), len(inputs), bound)

    def controlled(self, law: Law, count: int, *, dry_friction: bool = False, bound: float = OUTPUT_BOUND) -> Array:
        """Return the outputs under a controller at each physics step, relative to the operating point.

        Args:
            law: Sets the input before each step; no joint of the plant may follow the input.
            count: Number of steps.
            dry_friction: Whether joints have the dry friction given in the world.
            bound: Output above which the plant has diverged.

        Returns:
            Shape (outputs, k), values before each step; k is smaller than `count` if the plant diverges.
        """
        model = self._model_with(dry_friction)
        return self._stepped(model, lambda k, data, found: law(self.states(data), found), count, bound)

    def _model_with(self, dry_friction: bool) -> mujoco.MjModel:
        return self._rough if dry_friction and self._rough is not None else self.model

    def _stepped(
        self,
        model: mujoco.MjModel,
        input_of: Callable[[int, mujoco.MjData, Array], float],
        count: int,
        bound: float,
    ) -> Array:
        """Return the outputs before each step until the plant diverges, shape (outputs, k).

        Args:
            model: Model with or without dry friction.
            input_of: Returns the value added to the input, for the index of a step, the state, and the outputs.
            count: Number of steps.
            bound: Bound on the outputs.
        """
        at, data, found = self.setting, mujoco.MjData(model), np.zeros((len(self._measures), count))
        data.qpos[:], data.act[:] = at.qpos + self._sunk, at.act
        rest = self.outputs(at.qpos, np.zeros(model.nv))
        for k in range(count):
            found[:, k] = self.outputs(data.qpos, data.qvel) - rest
            if k and (data.warning.number.any() or not np.abs(found[:, k]).max() < bound):
                return found[:, :k]
            self.effect.write(data, at.value + input_of(k, data, found[:, k]))
            mujoco.mj_step(model, data)
        return found

    def states(self, data: mujoco.MjData) -> Array:
        """Return the linear plant's states for a state of the scene, relative to the operating point, shape (n,)."""
        at, moved = self.setting, np.zeros(self.model.nv)
        mujoco.mj_differentiatePos(self.model, moved, 1.0, at.qpos + self._sunk, data.qpos)
        own = list(self._reduced.coordinates)
        return np.asarray(self._into_states @ np.concatenate([moved[own], data.qvel[own], data.act - at.act]))

    def step_poles(self) -> Array:
        """Return the poles of one physics step in continuous time, log(z) / dt, including soft constraints [rad/s].

        They are those of the whole scene, from `mjd_transitionFD`.
        """
        model, data = self.model, mujoco.MjData(self.model)
        at = self.setting
        data.qpos[:], data.act[:] = at.qpos, at.act
        self.effect.write(data, at.value)
        mujoco.mj_forward(model, data)
        size = 2 * model.nv + model.na
        A = np.zeros((size, size))
        mujoco.mjd_transitionFD(model, data, 1e-6, 1, A, None, None, None)
        z = np.linalg.eigvals(A).astype(complex)
        return np.asarray(np.log(z[np.abs(z) > 1e-6]) / model.opt.timestep)

    def _depth(self, world: World, rest: Array) -> Array:
        """Return how much higher a robot's base is at rest than at its start, shape (nq,)."""
        sunk = np.zeros(self.model.nq)
        if any(robot.name == self.plant.of and robot.base != "fixed" for robot in world.robots):
            height = int(self.model.joint(f"{self.plant.of}/free").qposadr[0]) + 2
            sunk[height] = rest[height] - self.setting.qpos[height]
        return sunk

    def outputs(self, qpos: Array, qvel: Array) -> Array:
        """Return the measured values in a state of the scene, shape (outputs,)."""
        assert self.plant.outputs is not None
        pairs = zip(self.plant.outputs, self._measures, strict=True)
        return np.array([self._rate(m, qpos, qvel) if n.endswith(".rate") else m(qpos) for n, (_, m) in pairs])

    def _rate(self, measure: Measure, qpos: Array, qvel: Array) -> float:
        """Return the rate of a measured value."""

        def ahead(time: float) -> Array:
            moved = np.array(qpos)
            mujoco.mj_integratePos(self.model, moved, qvel, time)
            return np.array([measure(moved)])

        return float(slope(ahead, 1e-5)[0])

    def _closed(self, setting: Setting, fixed: list[int], locked: list[int], part: PlantPart) -> Setting:
        """Return the setting with closed loops; the joints of the operating point stay fixed."""
        data, stay = mujoco.MjData(self.model), {*fixed, *locked}
        free = [dof for dof in part.dofs if dof not in stay]
        for _ in range(MAX_STEPS):
            data.qpos[:] = setting.qpos
            mujoco.mj_fwdPosition(self.model, data)
            rows = np.flatnonzero(data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY)
            if not len(rows) or not free or float(np.abs(data.efc_pos[rows]).max()) < 1e-13:
                break
            J = np.zeros((data.nefc, self.model.nv))
            if mujoco.mj_isSparse(self.model):
                mujoco.mju_sparse2dense(J, data.efc_J, data.efc_J_rownnz, data.efc_J_rowadr, data.efc_J_colind)
            else:
                J = np.array(data.efc_J).reshape(data.nefc, self.model.nv)
            step = np.zeros(self.model.nv)
            step[free] = -np.linalg.lstsq(J[rows][:, free], data.efc_pos[rows], rcond=1e-9)[0]
            mujoco.mj_integratePos(self.model, setting.qpos, step, 1.0)
        return setting

    def _trimmed(self, setting: Setting, fixed: list[int]) -> Setting:
        """Return the equilibrium held by the input: at the start if possible, otherwise nearby.

        Args:
            setting: Initial setting.
            fixed: Degrees of freedom that must not change.
        """
        coordinates = self._reduced.coordinates
        for free in ([], [k for k, dof in enumerate(coordinates) if dof not in fixed]):
            found, left = self._newton(setting, free)
            if self._is_small(found, left):
                return found
        worst = int(np.argmax(np.abs(left)))
        raise UsageError(
            f"plant '{self.plant.name}' has no equilibrium at its operating point: {self._dof_name(coordinates[worst])}"
            f" would accelerate by {left[worst]:.3g} /s^2; change 'around', or use an input that can hold it"
        )

    def _newton(self, setting: Setting, free: list[int]) -> tuple[Setting, Array]:
        """Return a setting nearer to equilibrium, by Newton's method on the input and coordinates, and the residual."""
        reduced = self._reduced
        axes = np.eye(len(reduced.coordinates))[free]
        left = reduced.acceleration(setting)
        for _ in range(MAX_STEPS if free else 3):
            if self._is_small(setting, left):
                break
            columns = [
                slope(lambda h, e=e, at=setting: reduced.acceleration(reduced.moved(at, h * e)))  # type: ignore[misc]
                for e in axes
            ]
            columns.append(slope(lambda h, at=setting: reduced.acceleration(_more(at, h))))  # type: ignore[misc]
            step = -np.linalg.lstsq(np.array(columns).T, left, rcond=1e-9)[0]
            setting = _more(reduced.moved(setting, axes.T @ step[:-1]), float(step[-1]))
            left = reduced.acceleration(setting)
        return setting, left

    def _is_small(self, setting: Setting, left: Array) -> bool:
        return float(np.abs(left).max(initial=0.0)) <= AT_REST * max(1.0, self._pull(setting))

    def _pull(self, setting: Setting) -> float:
        """Return the acceleration per unit of the input."""
        more = self._reduced.acceleration(_more(setting, 1.0)) - self._reduced.acceleration(setting)
        return float(np.abs(more).max(initial=0.0))

    def _linear(self) -> LinearPlant:
        reduced, outputs, effect = self._reduced, self.plant.outputs, self.effect
        assert outputs is not None
        assert self.plant.input is not None
        A, B, Y = linearised(reduced, self.setting, measure=[measure for _, measure in self._measures])
        n, rates = len(reduced.coordinates), np.array([name.endswith(".rate") for name in outputs])
        names = [self._dof_name(dof) for dof in reduced.coordinates]
        if isinstance(effect, LedJoint):
            m = reduced.coordinates.index(effect.dof)
            A, B, C, D = led(effect, A, B, Y, m, rates)
            others = [name for k, name in enumerate(names) if k != m]
            names = [*names[m : m + 1][: effect.is_speed], *others, *(f"{name}.rate" for name in others)]
        else:
            C, D = np.zeros((len(outputs), len(A))), np.zeros((len(outputs), 1))
            C[rates, n : 2 * n], C[~rates, :n] = Y[rates], Y[~rates]
            names += [f"{name}.rate" for name in names] + [f"activation {k + 1}" for k in range(len(self.setting.act))]
        keep = minimal_states(A, B, C)
        if not len(keep) and not D.any():
            raise UsageError(
                f"plant '{self.plant.name}': {self.plant.input} affects none of {', '.join(outputs)};"
                " name another input"
            )
        A, B, C = (_clean(part) for part in (A[np.ix_(keep, keep)], B[keep], C[:, keep]))
        T, states = np.eye(len(keep)), [names[k] for k in keep]
        if not isinstance(effect, LedJoint):
            T, states = _in_outputs(keep, n, Y, states, [base_of(name) for name in outputs])
            self._into_states = T @ np.eye(2 * n + len(self.setting.act))[keep]
        inverse = np.linalg.inv(T)
        return LinearPlant(
            A=_clean(T @ A @ inverse),
            B=_clean(T @ B),
            C=_clean(C @ inverse),
            D=_clean(D),
            states=tuple(states),
            input=self.plant.input,
            outputs=tuple(outputs),
            units=(effect.unit, *self._units()),
        )

    def _units(self) -> list[str]:
        """Return the units of the outputs."""
        rate = {"m": "m/s", "rad": "rad/s"}
        pairs = zip(self.plant.outputs or (), self._measures, strict=True)
        return [rate[unit] if name.endswith(".rate") else unit for name, (unit, _) in pairs]

    def _dof_name(self, dof: int) -> str:
        joint = int(self.model.dof_jntid[dof])
        name = self.model.joint(joint).name
        axis = dof - int(self.model.jnt_dofadr[joint])
        if self.model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE:
            return f"{name.rpartition('/')[0]} {('x', 'y', 'z', 'roll', 'pitch', 'yaw')[axis]}"
        return str(name) if self.model.jnt_type[joint] in JOINTS else f"{name} {'xyz'[axis]}"


def _more(setting: Setting, value: float) -> Setting:
    """Return a setting with the input increased by a value."""
    return replace(setting, value=setting.value + value)


def _release(model: mujoco.MjModel, world: World, of: str, joint: str) -> None:
    """Release a joint of a mechanism from an actuator of the world that makes it follow a signal."""
    for mechanism in world.mechanisms:
        for drive in mechanism.assembly.drives if mechanism.name == of else ():
            if drive.column >= 0 and f"{of}/{mechanism.assembly.names[drive.column]}" == joint:
                model.eq_active0[model.equality(joint).id] = 0


def _with_friction(model: mujoco.MjModel, dofs: list[int]) -> mujoco.MjModel | None:
    """Remove the dry friction of joints from a model; return a copy that still has it, None if there is none."""
    if not model.dof_frictionloss[dofs].any():
        return None
    rough = copy.copy(model)
    model.dof_frictionloss[dofs] = 0.0
    return rough


def _in_outputs(keep: list[int], n: int, Y: Array, names: list[str], bases: list[str]) -> tuple[Array, list[str]]:
    """Return the transformation to the measured values as states, if they determine all states, and the new names."""
    places, rates = [k for k in keep if k < n], [k - n for k in keep if n <= k < 2 * n]
    rows = list(dict.fromkeys(bases))
    S = Y[[bases.index(base) for base in rows]][:, rates]
    same_order = not places or places == rates
    if len(rows) != len(rates) or not same_order or np.linalg.cond(S) > 1e6:
        return np.eye(len(keep)), names
    T = np.eye(len(keep))
    at = len(places)
    if at:
        T[:at, :at] = S
    T[at : at + len(rates), at : at + len(rates)] = S
    return T, [*rows[: len(places)], *(f"{row}.rate" for row in rows), *names[at + len(rates) :]]


def _clean(matrix: Array) -> Array:
    """Return a matrix without rounding errors, so that integrators are exact."""
    return np.where(np.abs(matrix) > NOISE_RATIO * float(np.abs(matrix).max(initial=0.0)), matrix, 0.0)


def _found(known: Mapping[str, T], name: str, kind: str, plant: Plant) -> T:
    if name not in known:
        raise UsageError(f"plant '{plant.name}': no {kind} '{name}' of {plant.of}{did_you_mean(name, known)}")
    return known[name]
