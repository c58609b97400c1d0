"""Joints of mechanisms held by a hand: a spring-damper of bounded force, in addition to everything that drives them.

The force in step n is that of the spring and the damper at its end, predicted from positions and velocities at its
start and the inertia that the hand moves. This is stable for any stiffness.

References:
    Tan, Liu, Turk, Stable proportional-derivative controllers (2011), equations 8 to 10.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.sim.mechanisms.followers import Blend
from mjsim.sim.mechanisms.grasps import Grasp, grasp_of, shorter, yielding
from mjsim.sim.mechanisms.mechanism_state import Places, placed_bodies
from mjsim.world import Mechanism

MAX_FORCE = 300.0
"""Maximum force of a hand at the lever [N]."""
STIFFNESS = 6000.0
"""Stiffness of a hand at the lever [N/m]."""
MIN_LEVER = 0.1
"""Minimum lever [m]; otherwise it is the distance of the body's farthest point from the axis, or from a ball."""
IMMOBILE_RATIO = 1e-9
"""A direction of a ball is immobile if a torque moves it less than the most mobile one by this factor."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Hold:
    """One held joint: a value, or the three of a ball."""

    grasp: Grasp
    columns: tuple[int, ...]
    """Columns of its values."""
    lever: float
    """[m]; 1 for a sliding joint."""
    courses: tuple[Blend, ...]
    """Course of the hand, of each value."""
    goals: tuple[float, ...]
    """Where the courses end [rad, m]."""

    def course(self, time: float) -> tuple[Array, Array, Array]:
        """Return the values of the hand at a time [s], their speeds and accelerations."""
        values, speeds, changes = np.array([each.at(time) for each in self.courses]).T
        return values, speeds, changes


class Holds:
    """The joints of one mechanism that are held by a hand."""

    def __init__(self, model: mujoco.MjModel, mechanism: Mechanism, places: Places) -> None:
        """Start without held joints."""
        self._model, self._mechanism, self._places = model, mechanism, places
        self._h = float(model.opt.timestep)
        self._held: dict[int, _Hold] = {}
        """By the first column."""
        self._pulls: dict[int, Array] = {}
        """Forces of each hold on all degrees of freedom of the world in the last step, shape (nv,) [N m, N]."""
        self._before = np.zeros(model.nv)
        """Their sum in the step before."""
        self._step = -1

    def __bool__(self) -> bool:
        """Return whether any joint is held."""
        return bool(self._held)

    @property
    def pull(self) -> Array:
        """Force of the hand on each degree of freedom of the mechanism in the last step, shape (n,) [N m, N]."""
        return np.asarray(self._whole[self._places.dofs])

    @property
    def _whole(self) -> Array:
        return np.asarray(sum(self._pulls.values(), np.zeros(self._model.nv)))

    def lead(self, goals: Mapping[str, float | None], step: int, data: mujoco.MjData, scratch: mujoco.MjData) -> None:
        """Stop joints, and move them to values from a step on [rad, m]; None releases one.

        A joint that is already held continues from the position of the hand at that time. Values of a ball that are not
        named stay where they are.

        Args:
            goals: Goals by the names of values.
            step: Number of the step.
            data: State before the step.
            scratch: A state for temporary use.
        """
        targets: dict[int, dict[int, float | None]] = {}
        grasps = {}
        for name, goal in goals.items():
            grasp, columns = grasp_of(self._model, self._mechanism, self._places, name)
            grasps[columns[0]] = grasp, columns
            targets.setdefault(columns[0], {})[self._mechanism.assembly.names.index(name)] = goal
        placed_bodies(self._model, data, scratch)
        for first, goals_of in targets.items():
            if None in goals_of.values():
                self._held.pop(first, None)
                self._pulls.pop(first, None)
            else:
                self._take(
                    *grasps[first],
                    {column: goal for column, goal in goals_of.items() if goal is not None},
                    step,
                    scratch,
                )

    def _take(
        self, grasp: Grasp, columns: tuple[int, ...], requested: Mapping[int, float], step: int, data: mujoco.MjData
    ) -> None:
        known, time = self._held.get(columns[0]), step * self._h
        if known is None:
            values = grasp.now(data)
            speeds = changes = np.zeros(grasp.size)
            previous, lever = values, self._lever(columns)
        else:
            values, speeds, changes = known.course(time)
            previous, lever = np.array(known.goals), known.lever
        goals = np.array(
            [requested.get(column, before) for column, before in zip(columns, previous.tolist(), strict=True)]
        )
        goals = values + shorter(goals - values, grasp.period)
        begins = zip(goals.tolist(), values.tolist(), speeds.tolist(), changes.tolist(), strict=True)
        courses = (
            Blend.to(goal, begin=time, value=value, speed=speed, change=change) for goal, value, speed, change in begins
        )
        self._held[columns[0]] = _Hold(
            grasp=grasp, columns=columns, lever=lever, courses=tuple(courses), goals=tuple(goals.tolist())
        )

    def goals(self, step: int) -> dict[int, float]:
        """Return the goal of each held joint at a step, by column [rad, m]."""
        return {
            column: value
            for hold in self._held.values()
            for column, value in zip(hold.columns, hold.course(step * self._h)[0].tolist(), strict=True)
        }

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
            self._step, self._before = step, self._whole
        placed_bodies(self._model, data, scratch)
        slopes = np.concatenate([hold.grasp.slopes(scratch) for hold in held])
        moved = yielding(self._model, scratch, slopes, self._places.equalities)
        per_pull = moved @ slopes.T
        speeds = slopes @ data.qvel
        # The other forces are estimated from the previous step: the acceleration that the hand does not account for.
        others = slopes @ data.qacc - moved @ self._before
        pull, by_change = np.zeros(len(slopes)), np.zeros_like(per_pull)
        parts, begin = list[slice](), 0
        for hold in held:
            parts.append(slice(begin, begin := begin + hold.grasp.size))
            own, stiffness = parts[-1], STIFFNESS * hold.lever**2
            damping = _damping(stiffness, per_pull[own, own])
            goal, changes, _ = hold.course((step + 1) * self._h)
            spring = stiffness * hold.grasp.missing(scratch, goal, speeds[own], self._h)
            limited = _bounded(spring, MAX_FORCE * hold.lever)
            # A hand at its limit waits: its spring does not grow, and its damper slows the joint down.
            follows = limited is spring
            growing = stiffness if follows else 0.0
            ahead = hold.grasp.rates(goal, changes) if follows else np.zeros(hold.grasp.size)
            pull[own] = limited + damping @ (ahead - speeds[own])
            by_change[own, own] = self._h * damping + self._h**2 * growing * np.eye(hold.grasp.size)
        pull = np.linalg.solve(np.eye(len(pull)) + by_change @ per_pull, pull - by_change @ others)
        for (column, hold), own in zip(self._held.items(), parts, strict=True):
            self._pulls[column] = slopes[own].T @ _bounded(pull[own], MAX_FORCE * hold.lever)

    def _lever(self, columns: tuple[int, ...]) -> float:
        """Return the distance of the farthest point of the moved body from the axis or the ball [m]; 1 for a slide."""
        found, column = self._mechanism.assembly, columns[0]
        if found.slides[column]:
            return 1.0
        joint = next(each.name for each in self._mechanism.joints if column in found.columns[each.name])
        placed, number = found.linkage.place(found.start), found.moved_body(joint)
        own = next((body for body in self._mechanism.bodies if body.name == found.bodies[number]), None)
        if own is None:
            return MIN_LEVER
        pose = placed.poses[number]
        away = own.hull()[0] @ pose[:3, :3].T + pose[:3, 3] - placed.anchors[column]
        if len(columns) == 1:
            away = np.cross(away, placed.axes[column])
        return max(float(np.linalg.norm(away, axis=1).max()), MIN_LEVER)


def _damping(stiffness: float, per_pull: Array) -> Array:
    """Return the critical damping of a spring, shape (n, n), for the acceleration per unit pull, of that shape."""
    mobility, vectors = np.linalg.eigh((per_pull + per_pull.T) / 2.0)
    mobility = np.maximum(mobility, IMMOBILE_RATIO * max(float(mobility.max()), np.finfo(float).tiny))
    return np.asarray((vectors * (2.0 * np.sqrt(stiffness / mobility))) @ vectors.T)


def _bounded(pull: Array, limit: float) -> Array:
    """Return a pull of at most a size, in the same direction."""
    size = float(np.linalg.norm(pull))
    return pull if size <= limit else np.asarray(pull * (limit / size))
