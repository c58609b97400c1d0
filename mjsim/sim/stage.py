"""The stage: what of a world moves by itself or by events, from tick to tick."""

import math
from collections.abc import Callable, Iterable, Sequence

import mujoco
import numpy as np

from mjsim.errors import UsageError, did_you_mean
from mjsim.geometry import Array, Pose
from mjsim.sim.doors import Doors
from mjsim.sim.movers import Movers
from mjsim.sim.scenery import Scenery
from mjsim.world.doors import leaves
from mjsim.world.events import CloseEvent, Event, LampEvent, MoveEvent, OpenEvent, RemoveEvent
from mjsim.world.looks import Looks
from mjsim.world.model import World
from mjsim.world.names import item_names

EARLY = 1e-9
"""A tick that is this much before an event is the event's [s]."""


class Stage:
    """Lets events happen, and movers and doors move, in a compiled world."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, world: World) -> None:
        """Set the stage for the start; events at time 0 are still to happen."""
        self._model, self._data, self._world = model, data, world
        self._scenery = Scenery(model, world)
        self._movers = Movers(model, data, world)
        self._doors = Doors(model, data, leaves(world))
        # The next one is the last; of events at one time the first in the file comes first.
        self._due = sorted(world.run.events, key=lambda event: event.time)[::-1]
        self._happened: list[Event] = []
        obstacles = list(zip(world.obstacles, item_names(world.obstacles), strict=True))
        self._moving = [name for obstacle, name in obstacles if obstacle.movable or obstacle.path is not None]
        self._movable = [obstacle.name for obstacle in world.obstacles if obstacle.movable and obstacle.name]
        self._movers.put(0.0)

    def let_happen(self, time: float) -> None:
        """Let all scripted events happen whose time has come [s]."""
        while self._due and self._due[-1].time <= time + EARLY:
            self.happen(self._due.pop(), time)

    def happen(self, event: Event, time: float) -> None:
        """Let an event happen now.

        Raises:
            UsageError: What it names is not there.
        """
        match event:
            case MoveEvent():
                robots = [robot.name for robot in self._world.robots]
                _require(event.move, "robot or movable obstacle", robots + self._movable)
                self._move(event, f"{event.move}/free" if event.move in robots else f"obstacle/{event.move}")
            case OpenEvent():
                _require(event.open, "door", self._doors.names())
                self._swing(event.open, math.radians(event.angle_deg))
            case CloseEvent():
                _require(event.close, "door", self._doors.names())
                self._doors.swing(event.close, 0.0)
            case LampEvent():
                _require(event.lamp, "lamp", self._scenery.looks.lamps)
            case RemoveEvent():
                things = [item.name for item in (*self._world.beacons, *self._world.obstacles) if item.name]
                _require(event.remove, "beacon or obstacle", things)
        self._scenery.show(self._scenery.looks.after(event, self._world))
        self._happened.append(event.model_copy(update={"time": time}))

    @property
    def looks(self) -> Looks:
        """Light, and what was taken away."""
        return self._scenery.looks

    def happened(self) -> tuple[Event, ...]:
        """Return what has happened since the last call, each at the time when it did."""
        happened, self._happened = tuple(self._happened), []
        return happened

    def run(self, count: int, first: int, *, after_each: Sequence[Callable[[], None]] = ()) -> None:
        """Take physics steps.

        Args:
            count: How many.
            first: Number of the first one, counted from 0 at the start of the run.
            after_each: Called after each of them.
        """
        model, data = self._model, self._data
        if not after_each and not self._movers and not self._doors.moving:
            # One call for all is quicker than one each.
            mujoco.mj_step(model, data, count)
            return
        for number in range(first, first + count):
            self._movers.put(number * model.opt.timestep)
            self._doors.drive()
            mujoco.mj_step(model, data)
            for call in after_each:
                call()
        self._movers.put((first + count) * model.opt.timestep)

    def things(self) -> dict[str, Pose]:
        """Return where everything is that can move but robots, world frame: `obstacle/NAME`, and `door/NAME`.

        A door's place is its hinge, its heading that of its leaf. What was taken away is left out.
        """
        gone = self._scenery.looks.removed
        places = {f"obstacle/{name}": self._pose(f"obstacle/{name}") for name in self._moving if name not in gone}
        doors = {f"door/{name}": self._doors.leaf(name).pose(self._doors.angle(name)) for name in self._doors.names()}
        return places | doors

    def door(self, name: str) -> float:
        """Return how far a door stands open, positive to the left side of its wall [rad]."""
        _require(name, "door", self._doors.names())
        return self._doors.angle(name)

    def _swing(self, name: str, angle: float) -> None:
        limit = self._doors.limit(name)
        if abs(angle) > limit + EARLY:
            far, most = math.degrees(angle), math.degrees(limit)
            raise UsageError(f"the angle is {far:.6g} degrees; door '{name}' swings to {most:.6g} at most")
        self._doors.swing(name, angle)

    def _move(self, event: MoveEvent, joint: str) -> None:
        """Put what has a free joint down elsewhere, at rest in all its parts; its wheels stay as they are turned."""
        data, model = self._data, self._model
        start = int(model.joint(joint).qposadr[0])
        heading = _heading(_matrix(data.qpos[start + 3 : start + 7]))
        if event.heading_deg is not None:
            heading = math.radians(event.heading_deg)
        data.qpos[start : start + 2] = event.to
        data.qpos[start + 2] = model.qpos0[start + 2]
        data.qpos[start + 3 : start + 7] = [math.cos(heading / 2), 0.0, 0.0, math.sin(heading / 2)]
        root = model.body_rootid[model.jnt_bodyid[model.joint(joint).id]]
        data.qvel[model.body_rootid[model.dof_bodyid] == root] = 0.0

    def _pose(self, body: str) -> Pose:
        index = self._model.body(body).id
        x, y, _ = self._data.xpos[index].tolist()
        return Pose(x, y, _heading(self._data.xmat[index]))


def _require(name: str, what: str, known: Iterable[str]) -> None:
    if name not in known:
        raise UsageError(f"no {what} '{name}' in this world{did_you_mean(name, known)}")


def _matrix(quaternion: Array) -> Array:
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, quaternion)
    return matrix


def _heading(matrix: Array) -> float:
    """Return where the x axis of a body points, seen from above [rad]; its rotation has shape (9,)."""
    return math.atan2(float(matrix[3]), float(matrix[0]))
