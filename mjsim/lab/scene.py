"""A plant of a scene: which degrees of freedom, what moves it, what is measured, and where it is at rest."""

from collections.abc import Mapping
from typing import TypeVar

import mujoco
import numpy as np

from mjsim.errors import UsageError, did_you_mean
from mjsim.geometry import Array
from mjsim.lab.linear import COUPLED, LinearPlant, kept_states, linearised, slope
from mjsim.lab.parts import JOINTS, Measure, Part, base_of, part_of, settled, working_point
from mjsim.lab.reduced import Reduced, Setting
from mjsim.world import Plant, World

AT_REST = 1e-9
"""What is left of an acceleration at an equilibrium, of the largest that counts, 1 unless it is more."""
MOST_STEPS = 50
"""Of Newton's method."""
T = TypeVar("T")


class ScenePlant:
    """A plant of a scene at its working point."""

    def __init__(self, world: World, plant: Plant) -> None:
        """Settle it, put it at its working point, and find the input that keeps it there.

        Raises:
            UsageError: It names something that is not there, or is in no equilibrium there.
        """
        assert plant.of is not None
        assert plant.input is not None
        assert plant.outputs is not None
        self.plant = plant
        self.model, setting, rest = settled(world, plant.of)
        part = part_of(self.model, world, plant.of, setting.qpos)
        self._drive = _found(part.drives, plant.input, "input", plant)
        self._measures = [_found(part.measures, base_of(name), "output", plant) for name in plant.outputs]
        joints = {part.joints[name] for name in (plant.input, *map(base_of, plant.outputs)) if name in part.joints}
        around = working_point(self.model, part, plant)
        own = [int(self.model.jnt_dofadr[joint]) for joint in (*around, *sorted(joints - set(around)))]
        locked = [dof for dof in part.dofs if part.lockable and dof not in own]
        for joint, value in around.items():
            setting.qpos[self.model.jnt_qposadr[joint]] = value
        setting = self._closed(setting, [int(self.model.jnt_dofadr[joint]) for joint in around], locked, part)
        # What is locked is so in the simulation of the nonlinear plant too.
        self.model.dof_armature[locked] = 1e9
        self._reduced = Reduced(self.model, setting, dofs=list(part.dofs), prefer=[*own, *part.prefer], locked=locked)
        fixed = [int(self.model.jnt_dofadr[joint]) for joint in around]
        self.held, self.setting = self._trimmed(setting, fixed)
        self._sunk = self._depth(world, rest)
        self.linear = self._linear()

    @property
    def unit(self) -> str:
        """Of the input."""
        return self._drive.unit

    def simulated(self, inputs: Array) -> Array:
        """Return the outputs of the nonlinear plant, step by step of MuJoCo, less those of the working point.

        Args:
            inputs: What is added to the input at the working point before each step, shape (k,).

        Returns:
            Shape (outputs, k): what is measured before each step.
        """
        data = mujoco.MjData(self.model)
        at = self.setting
        data.qpos[:], data.qfrc_applied[:], data.act[:] = at.qpos + self._sunk, at.applied, at.act
        found = np.zeros((len(self._measures), len(inputs)))
        for k, value in enumerate(inputs.tolist()):
            found[:, k] = self._outputs(data.qpos, data.qvel)
            moved = self._drive.add(at, value)
            data.ctrl[:], data.qfrc_applied[:] = moved.ctrl, moved.applied
            mujoco.mj_step(self.model, data)
        return found - self._outputs(at.qpos, np.zeros(self.model.nv))[:, None]

    def step_poles(self) -> Array:
        """Return the poles of one step of MuJoCo as continuous ones, log(z) / dt, soft constraints and all [rad/s].

        They are those of the whole scene, from `mjd_transitionFD`.
        """
        model, data = self.model, mujoco.MjData(self.model)
        at = self.setting
        data.qpos[:], data.ctrl[:], data.qfrc_applied[:], data.act[:] = at.qpos, at.ctrl, at.applied, at.act
        mujoco.mj_forward(model, data)
        size = 2 * model.nv + model.na
        A = np.zeros((size, size))
        mujoco.mjd_transitionFD(model, data, 1e-6, 1, A, None, None, None)
        z = np.linalg.eigvals(A).astype(complex)
        return np.asarray(np.log(z[np.abs(z) > 1e-6]) / model.opt.timestep)

    def _depth(self, world: World, rest: Array) -> Array:
        """Return how much a robot's base stands higher at rest than at its start, shape (nq,)."""
        sunk = np.zeros(self.model.nq)
        if any(robot.name == self.plant.of and robot.base != "fixed" for robot in world.robots):
            height = int(self.model.joint(f"{self.plant.of}/free").qposadr[0]) + 2
            sunk[height] = rest[height] - self.setting.qpos[height]
        return sunk

    def _outputs(self, qpos: Array, qvel: Array) -> Array:
        assert self.plant.outputs is not None
        pairs = zip(self.plant.outputs, self._measures, strict=True)
        return np.array([self._rate(m, qpos, qvel) if n.endswith(".rate") else m(qpos) for n, (_, m) in pairs])

    def _rate(self, measure: Measure, qpos: Array, qvel: Array) -> float:
        """Return how fast a value changes."""

        def ahead(time: float) -> Array:
            moved = np.array(qpos)
            mujoco.mj_integratePos(self.model, moved, qvel, time)
            return np.array([measure(moved)])

        return float(slope(ahead, 1e-5)[0])

    def _closed(self, setting: Setting, fixed: list[int], locked: list[int], part: Part) -> Setting:
        """Return the setting with its loops closed; the joints of the working point stay."""
        data, stay = mujoco.MjData(self.model), {*fixed, *locked}
        free = [dof for dof in part.dofs if dof not in stay]
        for _ in range(MOST_STEPS):
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

    def _trimmed(self, setting: Setting, fixed: list[int]) -> tuple[float, Setting]:
        """Return the input that keeps the plant at rest, and the setting there: by Newton's method."""
        reduced, held = self._reduced, 0.0
        free = [k for k, dof in enumerate(reduced.coordinates) if dof not in fixed]
        axes = np.eye(len(reduced.coordinates))[free]
        for _ in range(MOST_STEPS):
            left = reduced.acceleration(setting)
            if float(np.abs(left).max(initial=0.0)) <= AT_REST * max(1.0, self._pull(setting)):
                return held, setting
            columns = [
                slope(lambda h, e=e, at=setting: reduced.acceleration(reduced.moved(at, h * e)))  # type: ignore[misc]
                for e in axes
            ]
            columns.append(slope(lambda h, at=setting: reduced.acceleration(self._drive.add(at, h))))  # type: ignore[misc]
            step = -np.linalg.lstsq(np.array(columns).T, left, rcond=1e-9)[0]
            setting = self._drive.add(reduced.moved(setting, axes.T @ step[:-1]), float(step[-1]))
            held += float(step[-1])
        worst = int(np.argmax(np.abs(left)))
        name = self._dof_name(reduced.coordinates[worst])
        raise UsageError(
            f"plant '{self.plant.name}' is in no equilibrium at its working point: {name} would gain"
            f" {left[worst]:.3g} /s^2; change 'around', or take the input that can hold it"
        )

    def _pull(self, setting: Setting) -> float:
        """Return how much one unit of the input accelerates it."""
        more = self._reduced.acceleration(self._drive.add(setting, 1.0)) - self._reduced.acceleration(setting)
        return float(np.abs(more).max(initial=0.0))

    def _linear(self) -> LinearPlant:
        reduced, setting, outputs = self._reduced, self.setting, self.plant.outputs
        assert outputs is not None
        assert self.plant.input is not None
        measures = [measure for _, measure in self._measures]
        A, B, Y = linearised(reduced, setting, drive=self._drive.add, measure=measures)
        n = len(reduced.coordinates)
        C = np.zeros((len(outputs), len(A)))
        for row, name in enumerate(outputs):
            C[row, slice(n, 2 * n) if name.endswith(".rate") else slice(0, n)] = Y[row]
        keep = kept_states(A, B, C)
        if not len(keep):
            raise UsageError(
                f"plant '{self.plant.name}': {self.plant.input} moves none of {', '.join(outputs)}; name another input"
            )
        names = [self._dof_name(dof) for dof in reduced.coordinates]
        names += [f"{name}.rate" for name in names] + [f"activation {k + 1}" for k in range(len(setting.act))]
        A, B, C = (_clean(part) for part in (A[np.ix_(keep, keep)], B[keep], C[:, keep]))
        T, states = _in_outputs(keep, n, Y, [names[k] for k in keep], [base_of(name) for name in outputs])
        inverse = np.linalg.inv(T)
        rate = {"m": "m/s", "rad": "rad/s"}
        units = [
            rate[unit] if name.endswith(".rate") else unit
            for name, (unit, _) in zip(outputs, self._measures, strict=True)
        ]
        return LinearPlant(
            A=_clean(T @ A @ inverse),
            B=_clean(T @ B),
            C=_clean(C @ inverse),
            D=np.zeros((len(outputs), 1)),
            states=tuple(states),
            input=self.plant.input,
            outputs=tuple(outputs),
            units=(self._drive.unit, *units),
        )

    def _dof_name(self, dof: int) -> str:
        joint = int(self.model.dof_jntid[dof])
        name = self.model.joint(joint).name
        axis = dof - int(self.model.jnt_dofadr[joint])
        if self.model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE:
            return f"{name.rpartition('/')[0]} {('x', 'y', 'z', 'roll', 'pitch', 'yaw')[axis]}"
        return str(name) if self.model.jnt_type[joint] in JOINTS else f"{name} {'xyz'[axis]}"


def _in_outputs(keep: list[int], n: int, Y: Array, names: list[str], bases: list[str]) -> tuple[Array, list[str]]:
    """Return how states become those measured, where these tell all of them, and the names of the new ones."""
    places, rates = [k for k in keep if k < n], [k - n for k in keep if n <= k < 2 * n]
    rows = list(dict.fromkeys(bases))
    S = Y[[bases.index(base) for base in rows]][:, rates]
    alike = not places or places == rates
    if len(rows) != len(rates) or not alike or np.linalg.cond(S) > 1e6:
        return np.eye(len(keep)), names
    T = np.eye(len(keep))
    at = len(places)
    if at:
        T[:at, :at] = S
    T[at : at + len(rates), at : at + len(rates)] = S
    return T, [*rows[: len(places)], *(f"{row}.rate" for row in rows), *names[at + len(rates) :]]


def _clean(matrix: Array) -> Array:
    """Return a matrix without what is rounding, so that integrators are exactly that."""
    return np.where(np.abs(matrix) > COUPLED * float(np.abs(matrix).max(initial=0.0)), matrix, 0.0)


def _found(known: Mapping[str, T], name: str, what: str, plant: Plant) -> T:
    if name not in known:
        raise UsageError(f"plant '{plant.name}': no {what} '{name}' of {plant.of}{did_you_mean(name, known)}")
    return known[name]
