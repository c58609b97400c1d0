"""Joints of mechanisms held by a hand: a spring-damper of bounded force, in addition to everything that drives them.

The force in step n is that of the spring and the damper at its end, predicted from positions and velocities at its
start and the inertia that the hand moves. This is stable for any stiffness.

References:
    Tan, Liu, Turk, Stable proportional-derivative controllers (2011), equations 8 to 10.
"""

from dataclasses import dataclass

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.sim.followers import Blend
from mjsim.sim.mechanism_state import Places
from mjsim.world import Mechanism

STRONGEST = 300.0
"""Maximum force of a hand at the lever [N]."""
STIFFNESS = 6000.0
"""Stiffness of a hand at the lever [N/m]."""
SHORTEST = 0.1
"""Minimum lever [m]; otherwise it is the distance of the body's farthest point from the axis."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Hold:
    """One held joint."""

    place: int
    """Index of its value in qpos."""
    dof: int
    lever: float
    """[m]; 1 for a sliding joint."""
    course: Blend
    """Course of the hand."""


class Holds:
    """The joints of one mechanism that are held by a hand."""

    def __init__(self, model: mujoco.MjModel, mechanism: Mechanism, places: Places) -> None:
        """Start without held joints."""
        self._model, self._mechanism, self._places = model, mechanism, places
        self._h = float(model.opt.timestep)
        self._held: dict[int, _Hold] = {}
        """By column."""
        self._pull = self._before = np.zeros(model.nv)
        """Step number, and the forces on each degree of freedom of the world in it and in the previous step [N m, N].
        """
        self._step = -1

    def __bool__(self) -> bool:
        """Return whether any joint is held."""
        return bool(self._held)

    @property
    def pull(self) -> Array:
        """Force of the hand on each degree of freedom of the mechanism in the last step, shape (n,) [N m, N]."""
        return np.asarray(self._pull[self._places.dofs])

    def lead(self, joint: str, goal: float | None, step: int, data: mujoco.MjData) -> None:
        """Stop a joint, and move it to a value from a step on [rad, m]; None releases it.

        A joint that is already held continues from the position of the hand at that time.
        """
        column = self._mechanism.assembly.names.index(joint)
        if goal is None:
            self._held.pop(column, None)
            self._pull = self._pull.copy()
            self._pull[self._places.of(column)[1]] = 0.0
            return
        known, time = self._held.get(column), step * self._h
        place, dof = self._places.of(column)
        value, speed, change = float(data.qpos[place]), 0.0, 0.0
        if known is not None:
            value, speed, change = known.course.at(time)
        course = Blend.to(goal, begin=time, value=value, speed=speed, change=change)
        lever = self._lever(column) if known is None else known.lever
        self._held[column] = _Hold(place=place, dof=dof, lever=lever, course=course)

    def goals(self, step: int) -> dict[int, float]:
        """Return the goal of each held joint at a step, by column [rad, m]."""
        return {column: hold.course.at(step * self._h)[0] for column, hold in self._held.items()}

    def aim(self, data: mujoco.MjData, scratch: mujoco.MjData, step: int) -> None:
        """Set the forces of a step; a second call for the same step sets the same forces.

        Args:
            data: State before the step.
            scratch: A state for temporary use.
            step: Number of the step.
        """
        held = list(self._held.values())
        if not held:
            return
        if step != self._step:
            self._step, self._before = step, self._pull
        dofs = [hold.dof for hold in held]
        wanted = np.array([hold.course.at((step + 1) * self._h)[:2] for hold in held])
        levers = np.array([hold.lever for hold in held])
        yielding = self._yielding(data, scratch, dofs)
        stiffness = STIFFNESS * levers**2
        damping = 2.0 * np.sqrt(stiffness / np.diag(yielding))
        speeds = data.qvel[dofs]
        ahead = data.qpos[[hold.place for hold in held]] + self._h * speeds
        pull = stiffness * (wanted[:, 0] - ahead) + damping * (wanted[:, 1] - speeds)
        # The other forces are estimated from the previous step: the acceleration that the hand does not account for.
        others = data.qacc[dofs] - yielding @ self._before[dofs]
        by_change = self._h * damping + self._h**2 * stiffness
        pull = np.linalg.solve(np.eye(len(held)) + by_change[:, None] * yielding, pull - by_change * others)
        self._pull = np.zeros(self._model.nv)
        self._pull[dofs] = np.clip(pull, -STRONGEST * levers, STRONGEST * levers)

    def _yielding(self, data: mujoco.MjData, scratch: mujoco.MjData, dofs: list[int]) -> Array:
        """Return the accelerations of held joints per unit force on them, shape (held, held)."""
        model = self._model
        scratch.qpos[:] = data.qpos
        mujoco.mj_kinematics(model, scratch)
        mujoco.mj_comPos(model, scratch)
        mujoco.mj_makeM(model, scratch)
        mujoco.mj_factorM(model, scratch)
        units, answers = np.eye(model.nv)[dofs], np.zeros((len(dofs), model.nv))
        mujoco.mj_solveM(model, scratch, answers, units)
        return answers[:, dofs]

    def _lever(self, column: int) -> float:
        """Return the distance of the farthest point of the carried body from the axis [m]; 1 for a slide."""
        # Loads SciPy, which a world without held joints does not need.
        from mjsim.world import carried_body

        found = self._mechanism.assembly
        if found.slides[column]:
            return 1.0
        joint = next(each for each in self._mechanism.joints if column in found.columns[each.name])
        placed, number = found.linkage.place(found.start), carried_body(found, joint)
        own = next((body for body in self._mechanism.bodies if body.name == found.bodies[number]), None)
        if own is None:
            return SHORTEST
        pose = placed.poses[number]
        away = own.hull()[0] @ pose[:3, :3].T + pose[:3, 3] - placed.anchors[column]
        return max(float(np.linalg.norm(np.cross(away, placed.axes[column]), axis=1).max()), SHORTEST)
