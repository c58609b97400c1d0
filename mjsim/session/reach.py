"""What somebody who moves arms by hand has said last: goals of joints, and poses of tools."""

import threading
from collections.abc import Sequence

import numpy as np

from mjsim.errors import UsageError, did_you_mean
from mjsim.geometry import Array
from mjsim.interface import JointGoal, Observation
from mjsim.mechanics import Arm, placed
from mjsim.world import World

FASTEST = 1.0
"""Speed at which joints go to where a hand wants them, unless their limits are lower [rad/s, m/s]."""
MISS = 1e-3
"""A tool that cannot come nearer to a pose does not reach it [m, rad]."""
EVERY, PLACE = (1.0,) * 6, (1.0, 1.0, 1.0, 0.0, 0.0, 0.0)
"""What of a pose an arm with enough joints reaches, and one with fewer."""


class Reach:
    """Holds the joint values that arms are wanted at; set from any thread, asked by the run at each tick.

    A goal moves there from where the arm is, no faster than its limits allow, and stays until it is given back.
    """

    def __init__(self, world: World) -> None:
        """Let the navigators move the arms."""
        self._arms = {robot.name: {item.name: item.arm for item in robot.arms} for robot in world.robots}
        self._lock = threading.Lock()
        self._wanted: dict[tuple[str, str], Array] = {}
        self._now: dict[tuple[str, str], Array] = {}
        self._seen: dict[tuple[str, str], Array] = {}

    def take(self, robot: str, arm: str, positions: Sequence[float] | None) -> None:
        """Want the joints of an arm at these values [rad, m]; None gives the arm back to its navigator.

        Raises:
            UsageError: There is no such arm, or it cannot be there.
        """
        model = self._model(robot, arm)
        goal = None if positions is None else _checked(model, arm, positions)
        with self._lock:
            if goal is None:
                self._wanted.pop((robot, arm), None)
                self._now.pop((robot, arm), None)
            else:
                self._wanted[robot, arm] = goal

    def take_tool(self, robot: str, arm: str, at: Sequence[float], rpy: Sequence[float]) -> None:
        """Want the tool of an arm at a pose in the robot's frame; of an arm with fewer than six joints only its place.

        Args:
            robot: Whose arm it is.
            arm: Its name.
            at: x, y, z [m].
            rpy: Roll, pitch, yaw about fixed axes, right-handed [rad].

        Raises:
            UsageError: There is no such arm, or its tool does not reach there.
        """
        model = self._model(robot, arm)
        with self._lock:
            start = self._wanted.get((robot, arm), self._seen.get((robot, arm)))
        mask = EVERY if model.n >= 6 else PLACE
        reached = model.ikine(placed(at, rpy), start, mask=mask)
        if max(float(reached.distance), float(reached.angle)) > MISS:
            x, y, z = (f"{value:g}" for value in at)
            raise UsageError(
                f"the tool of '{arm}' does not reach {x}, {y}, {z} m turned so; it misses by "
                f"{float(reached.distance):.3g} m and {float(np.degrees(reached.angle)):.3g} degrees"
            )
        self.take(robot, arm, reached.q.tolist())

    def let_go(self) -> None:
        """Give all arms back."""
        with self._lock:
            self._wanted.clear()
            self._now.clear()

    def goals(self, robot: str, seen: Observation) -> dict[str, JointGoal]:
        """Return the goals of a robot's arms that somebody moves, for the tick that begins."""
        with self._lock:
            self._seen |= {(robot, arm): state.positions for arm, state in seen.joints.items()}
            return {
                arm: self._towards((robot, arm), model, seen.dt)
                for arm, model in self._arms.get(robot, {}).items()
                if (robot, arm) in self._wanted and (robot, arm) in self._seen
            }

    def _towards(self, key: tuple[str, str], model: Arm, dt: float) -> JointGoal:
        """Return the goal of a tick, on the way to where the arm is wanted."""
        now = self._now.get(key, self._seen[key])
        limits = np.minimum([link.max_velocity for link in model.links], FASTEST)
        rates = np.clip((self._wanted[key] - now) / dt, -limits, limits)
        self._now[key] = now + rates * dt
        return JointGoal(positions=tuple(now.tolist()), velocities=tuple(rates.tolist()))

    def _model(self, robot: str, arm: str) -> Arm:
        if robot not in self._arms:
            raise UsageError(f"no robot '{robot}' in this world{did_you_mean(robot, self._arms)}")
        if arm not in self._arms[robot]:
            raise UsageError(f"robot '{robot}' has no arm '{arm}'{did_you_mean(arm, self._arms[robot])}")
        return self._arms[robot][arm]


def _checked(model: Arm, arm: str, positions: Sequence[float]) -> Array:
    """Return joint values as an array; UsageError where they do not fit the arm."""
    goal = np.array(positions, dtype=float)
    if goal.shape != (model.n,) or not np.isfinite(goal).all():
        raise UsageError(f"arm '{arm}' has {model.n} joints; give as many finite numbers")
    lower, upper = model.limits
    beyond = (goal < lower - 1e-9) | (goal > upper + 1e-9)
    if beyond.any():
        joint = int(np.argmax(beyond))
        value, low, high = float(goal[joint]), float(lower[joint]), float(upper[joint])
        raise UsageError(f"joint {joint + 1} of arm '{arm}' cannot go to {value:g}; its range is {low:g} to {high:g}")
    return goal
