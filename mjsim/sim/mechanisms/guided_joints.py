"""Joints of a mechanism that are led: by their motion, through loops by the motion of another, or by a hand."""

import math
from collections.abc import Mapping, Sequence

import mujoco

from mjsim.geometry import Array
from mjsim.sim.mechanisms.followers import Follower
from mjsim.sim.mechanisms.grasps import grasp_of, period_of
from mjsim.sim.mechanisms.hand_forces import Holds
from mjsim.sim.mechanisms.loop_locks import Locks
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
        """Return a goal the shorter way, where the physics has no joint that counts turns or rounds of a curve."""
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
