"""Joints of a mechanism that are led: by their motion, through loops by the motion of another, or by a hand.

A motion that the loops do not permit stops where they do.
"""

import math
from collections.abc import Mapping, Sequence

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.mechanics import Apart, Linear, Rows, close, rates, residual
from mjsim.sim.mechanisms.followers import Follower
from mjsim.sim.mechanisms.grasps import grasp_of, period_of
from mjsim.sim.mechanisms.hand_forces import Holds
from mjsim.sim.mechanisms.mechanism_state import Places, placed_bodies
from mjsim.world import Mechanism, led_joints


class Leading:
    """Leads the joints of one mechanism."""

    def __init__(
        self, model: mujoco.MjModel, mechanism: Mechanism, places: Places, followers: Sequence[Follower]
    ) -> None:
        """Start with all joints free."""
        self._model, self._mechanism, self._places = model, mechanism, places
        self._assembly, self._scratch = mechanism.assembly, mujoco.MjData(model)
        self.locks, self.holds = Locks(mechanism, followers), Holds(model, mechanism, places)
        self._sources: dict[str, Follower] = {}
        """By joint that was led: the motion that leads it."""

    def lead(self, goals: Mapping[str, float | None], step: int, data: mujoco.MjData) -> None:
        """From a step on, move joints to values and hold them there [rad, m].

        None makes one follow its signal again, or lets it go.
        """
        by_hand = {name: goal for name, goal in goals.items() if name in self._mechanism.held}
        if by_hand:
            self.holds.lead(by_hand, step, data, self._scratch)
        for name, goal in goals.items():
            if name in by_hand:
                continue
            if goal is None:
                source = self._source(name, step, data)
                self._sources.pop(name, None)
                source.release(step, whole=self._whole(source))
            else:
                values, goal = self._values(data), self._near(name, goal, data)
                source, end = self.locks.source(name, goal, step, values)
                self._sources[name] = source
                source.lead(end, step, far=abs(goal - float(values[self._assembly.names.index(name)])))

    def barred(self, goals: Mapping[str, float | None], step: int, data: mujoco.MjData) -> str:
        """Return why loops do not allow the motion of `lead`, as text; '' if they do."""
        reasons = (self._barred(name, goal, step, data) for name, goal in goals.items())
        return next(filter(None, reasons), "")

    def _barred(self, joint: str, goal: float | None, step: int, data: mujoco.MjData) -> str:
        if joint in self._mechanism.held:
            return ""  # A hand of bounded force cannot force a loop open.
        if goal is not None:
            return self.locks.barred(joint, self._near(joint, goal, data), step, self._values(data))
        source = self._source(joint, step, data)
        end = source.end(step, whole=self._whole(source))
        return "" if end is None else self.locks.barred_motion(source, end, step, self._values(data))

    def _source(self, joint: str, step: int, data: mujoco.MjData) -> Follower:
        """Return the motion that leads a joint, or would lead it."""
        return self._sources.get(joint) or self.locks.moves_most(joint, step, self._values(data))

    def _near(self, joint: str, goal: float, data: mujoco.MjData) -> float:
        """Return a goal the shorter way, where the physics has no joint that counts turns or laps of a curve."""
        column = self._assembly.names.index(joint)
        if column in self._places.columns:
            return goal
        now, period = float(self._values(data)[column]), period_of(self._assembly, column)
        return goal - period * round((goal - now) / period) if period else goal

    def _values(self, data: mujoco.MjData) -> Array:
        """Return the current values of all joints, shape (values,); at cuts and on curves without turns [rad, m]."""
        values = self._assembly.start.copy()
        values[self._places.columns] = self._places.read(data, self._assembly)[0][self._places.columns]
        placed_bodies(self._model, data, self._scratch)
        for joint in (*self._assembly.cuts, *(track.name for track in self._assembly.tracks)):
            for column in self._assembly.columns[joint]:
                if column not in self._places.columns:
                    grasp, columns = grasp_of(self._model, self._mechanism, self._places, self._assembly.names[column])
                    values[list(columns)] = grasp.now(self._scratch)
        return values

    def _whole(self, follower: Follower) -> float:
        """Return 2 pi for a revolute joint without limits, 0 for others [rad]."""
        if follower.drive.ends is not None:
            return 0.0
        slides, lower, upper = led_joints(self._mechanism)[self._assembly.names[follower.drive.column]]
        return 0.0 if slides or math.isfinite(lower) or math.isfinite(upper) else 2.0 * math.pi


MAX_STEP_BACK = 1e-12
"""Decrease of a squared distance that counts as rounding [m^2]."""
TRIED_POSITIONS = 9
"""Number of positions along the path of a led joint at which closing of the loops is tested."""


class Locks:
    """Tests whether prescribed motions are compatible with the loops of a mechanism."""

    def __init__(self, mechanism: Mechanism, followers: Sequence[Follower]) -> None:
        """Store a mechanism, and the motions that its joints follow."""
        self._mechanism, self._assembly, self._followers = mechanism, mechanism.assembly, followers

    def led(self, step: int) -> list[Rows]:
        """Return the constraints of the motions at a step."""
        return [_constraint(each, each.goal(step)) for each in self._followers]

    def locked(self, step: int, values: Array) -> str:
        """Return how motions contradict the loops at a step, as text; '' if they do not.

        Args:
            step: Step at which motions are tested.
            values: Initial values of the search, shape (values,) [rad, m].
        """
        if not self._followers:
            return ""
        closed = close(self._assembly.linkage, [*self._assembly.rows, *self.led(step)], values)
        if closed.good:
            return ""
        goals = " and ".join(self._described(each, each.goal(step)) for each in self._followers)
        return f"{self._missed(goals, closed.values)}; change the lengths, or the signal"

    def barred(self, joint: str, goal: float, step: int, values: Array) -> str:
        """Return how loops prevent a joint from reaching a value from its current one, as text; '' if they do not.

        Args:
            joint: A joint that follows a motion, or that motions move through loops; all other motions stay constant.
            goal: The value [rad, m].
            step: Current step.
            values: Current joint values, shape (values,) [rad, m].
        """
        return self._reached(joint, goal, step, values)[1]

    def barred_motion(self, own: Follower, goal: float, step: int, values: Array) -> str:
        """Return how loops prevent a motion from reaching its own value [rad, m], as `barred` does for a joint."""
        if own.drive.ends is None:
            return self.barred(self._assembly.names[own.drive.column], goal, step, values)
        path = np.linspace(own.goal(step), goal, TRIED_POSITIONS)[1:].tolist()
        closed = self._closed(own, [(Apart(own.drive.ends, value), value) for value in path], step, values)
        return "" if closed[1] is None else self._missed(self._described(own, closed[1]), closed[0])

    def source(self, joint: str, goal: float, step: int, values: Array) -> tuple[Follower, float]:
        """Return the motion that moves a joint most, and its value when the joint reaches its own [rad, m].

        The arguments are those of `barred`; beyond what loops permit, the motion ends where they stop it.
        """
        return self.moves_most(joint, step, values), self._reached(joint, goal, step, values)[0]

    def _reached(self, joint: str, goal: float, step: int, values: Array) -> tuple[float, str]:
        """Return the last value of the joint's motion on the way to a goal, and what stops it, '' if nothing does."""
        column = self._assembly.names.index(joint)
        own = self.moves_most(joint, step, values)
        begin = own.goal(step) if own.drive.column == column else float(values[column])
        path = np.linspace(begin, goal, TRIED_POSITIONS)[1:].tolist()
        end, way = self._value(own, values), 0.0
        for value in path:
            closed, wrong = self._closed(own, [(Linear({column: 1.0}, value), value)], step, values)
            if wrong is not None:
                return end, self._missed(self._shown(joint, column, value), closed)
            reached = self._value(own, closed)
            if own.drive.ends is not None and (reached - end) * way < -MAX_STEP_BACK:
                shown = self._shown(joint, column, value)
                return end, f"{self._locks} before {shown}: '{own.drive.name}' would have to reverse"
            way, values, end = reached - end, closed, reached
        return end, ""

    def _closed(
        self, own: Follower, path: Sequence[tuple[Rows, float]], step: int, values: Array
    ) -> tuple[Array, float | None]:
        """Return the values after a path of one motion, and the value on it that loops do not permit, None if all do.

        Args:
            own: The motion.
            path: Constraints in place of it, one after the other, each with its value.
            step: Current step.
            values: Current joint values, shape (values,) [rad, m].
        """
        others = [_constraint(each, each.goal(step)) for each in self._followers if each is not own]
        for row, value in path:
            closed = close(self._assembly.linkage, [*self._assembly.rows, *others, row], values)
            if not closed.good:
                return closed.values, value
            values = closed.values
        return values, None

    def _value(self, own: Follower, values: Array) -> float:
        """Return the value of a motion for joint values [rad, m]."""
        if own.drive.ends is None:
            return float(values[own.drive.column])
        placed = self._assembly.linkage.place(values)
        return float(np.linalg.norm(own.drive.ends[1].place(placed) - own.drive.ends[0].place(placed)))

    def moves_most(self, joint: str, step: int, values: Array) -> Follower:
        """Return the motion of a joint, or the motion of another that moves it most."""
        column = self._assembly.names.index(joint)
        for each in self._followers:
            if each.drive.column == column:
                return each
        found, led = self._assembly, self.led(step)
        count = len(residual(found.linkage, found.rows, values))

        def moved(follower: Follower) -> float:
            targets = np.zeros(count + len(led))
            targets[count + self._followers.index(follower)] = 1.0
            speeds, _ = rates(found.linkage, [*found.rows, *led], values, held={}, targets=targets)
            return abs(float(speeds[column]))

        return max(self._followers, key=moved)

    @property
    def _locks(self) -> str:
        return f"mechanism '{self._mechanism.name}' locks"

    def _missed(self, goals: str, values: Array) -> str:
        worst, how = self._assembly.gap(values)
        return f"{self._locks}: with {goals} its loop at '{worst}' does not close, by {how}"

    def _shown(self, joint: str, column: int, value: float) -> str:
        turns = not self._assembly.slides[column]
        return f"'{joint}' at {math.degrees(value):.4g} degrees" if turns else f"'{joint}' at {value:.4g} m"

    def _described(self, follower: Follower, goal: float) -> str:
        drive = follower.drive
        turns = drive.column >= 0 and not self._assembly.slides[drive.column]
        shown = f"{math.degrees(goal):.4g} degrees" if turns else f"{goal:.4g} m"
        return f"'{self._mechanism.actuators[drive.number].target}' at {shown}"


def _constraint(follower: Follower, goal: float) -> Rows:
    drive = follower.drive
    return Linear({drive.column: 1.0}, goal) if drive.ends is None else Apart(drive.ends, goal)
