"""Scripted changes of a world: events, movers, joints with motors."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from mjsim.errors import UsageError, did_you_mean
from mjsim.geometry import Array, Pose
from mjsim.sim.actuation import Actuation
from mjsim.sim.arms import ArmAtWork
from mjsim.sim.joints import Joints
from mjsim.sim.movers import Movers
from mjsim.sim.scenery import Scenery
from mjsim.sim.shoves import Shoves
from mjsim.sim.streams import stream
from mjsim.world import (
    CloseEvent,
    LampEvent,
    LeadEvent,
    Looks,
    MoveEvent,
    NoiseEvent,
    OpenEvent,
    PushEvent,
    ReachEvent,
    ReleaseEvent,
    RemoveEvent,
    RestoreEvent,
    ShoveEvent,
    World,
    WorldEvent,
    arm_of_event,
    item_names,
    leaves,
    led_joint,
    led_value,
    misplaced,
    reached_joints,
    with_noise,
)

if TYPE_CHECKING:
    from numpy.random import Generator

    from mjsim.mechanics import TimeSignal

EARLY = 1e-9
"""A tick that is this much before an event is the event's [s]."""
DEEP = 1e-3
"""What is put down may reach this far into something that moves [m], as into what stays."""


ArmOf = Callable[[str, str], ArmAtWork]
Tune = Callable[[str, float], None]

Lead = Callable[[str, str, float | None], None]
Barred = Callable[[str, str, float | None], str]


class WorldScript:
    """Lets events happen, and movers and joints move, in a compiled world."""

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        world: World,
        *,
        seed: int,
        arm: ArmOf,
        tune: Tune,
        lead: Lead,
        barred: Barred,
    ) -> None:
        """Put all movers where they start; events at time 0 are still to happen.

        Args:
            model: The compiled world.
            data: Its state.
            world: As it was written.
            seed: Of the run.
            arm: Returns an arm by the names of its robot and its own.
            tune: Changes a figure of noise by its key; raises UsageError where it cannot.
            lead: Leads a joint of a mechanism, by the names of both, to a value [rad, m]; None gives it back.
            barred: Returns why a loop does not allow that, in words; '' where it does.
        """
        self._arm, self._tune, self._lead, self._barred = arm, tune, lead, barred
        self._seed, self._pushes = seed, 0
        self._model, self._data, self._world = model, data, world
        self._scenery = Scenery(model, world)
        self._movers = Movers(model, data, world)
        self._doors = {leaf.name: leaf for leaf in leaves(world)}
        self._joints = Joints(model, data, [leaf.joint() for leaf in self._doors.values()])
        self._shoves = Shoves(model, data)
        # The next one is the last; of events at one time the first in the file comes first.
        self._due = sorted(world.run.events, key=lambda event: event.time)[::-1]
        self._happened: list[WorldEvent] = []
        obstacles = list(zip(world.obstacles, item_names(world.obstacles), strict=True))
        self._moving = [name for obstacle, name in obstacles if obstacle.movable or obstacle.path is not None]
        self._movable = [obstacle.name for obstacle in world.obstacles if obstacle.movable and obstacle.name]
        # What leans at the start is put down upright.
        self._heights = {robot.name: 0.0 for robot in world.robots}
        self._movers.put(0.0)

    def schedule(self, event: WorldEvent, *, instead_of: WorldEvent | None = None) -> WorldEvent:
        """Have an event happen when its time comes, after those of the same time.

        Args:
            event: What is to happen.
            instead_of: One that was scheduled before and is still to happen.

        Returns:
            The event; that of a hand tells how far it will stay away.

        Raises:
            UsageError: What it names is not there, or there is no room where it puts something; nothing changes then.
        """
        self._check(event)
        if isinstance(event, MoveEvent):
            self._check_room(event)
        if isinstance(event, NoiseEvent):
            with_noise(self._world, event.noise, event.value)
        wrong = ""
        if isinstance(event, LeadEvent):
            wrong = self._barred(event.lead, event.joint, led_value(self._world, event))
        elif isinstance(event, ReleaseEvent) and event.joint is not None:
            wrong = self._barred(event.release, event.joint, None)
        if wrong:
            raise UsageError(wrong)
        if isinstance(event, ReachEvent) and event.hand is not None:
            until = [each for each in reversed(self._due) if each.time <= event.time]
            event = self._scenery.tried(event, until)
        self._due = [event, *(each for each in self._due if each is not instead_of)]
        # The sort is stable, and of those at one time the newest stands first: it happens last.
        self._due.sort(key=lambda each: -each.time)
        return event

    def let_happen(self, time: float) -> None:
        """Let all scripted events happen whose time has come [s]."""
        while self._due and self._due[-1].time <= time + EARLY:
            self.happen(self._due.pop(), time)
        if self._scenery.looks.reached:
            self._scenery.show(replace(self._scenery.looks, time=time))

    def happen(self, event: WorldEvent, time: float) -> None:
        """Let an event happen now.

        Raises:
            UsageError: What it names is not there.
        """
        self._check(event)
        match event:
            case MoveEvent():
                self._put_down(event, self._data)
            case ShoveEvent():
                self._shoves.add(self._body(event.shove), event.impulse, event.seconds)
            case PushEvent():
                self._pushes += 1
                rng = stream(self._seed, event.push, f"push/{self._pushes}")
                self._shoves.push_along(
                    self._body(event.push), self._force(event, rng), event.along, seconds=event.seconds
                )
            case OpenEvent():
                self._joints.move(f"door/{event.open}", math.radians(event.angle_deg))
            case CloseEvent():
                self._joints.move(f"door/{event.close}", 0.0)
            case NoiseEvent():
                self._tune(event.noise, event.value)
            case ReachEvent() if event.hand is None:
                self._arm(event.reach, event.arm).lead(self._reached(event)[0])
            case ReleaseEvent(joint=str(joint)):
                self._lead(event.release, joint, None)
            case ReleaseEvent() if event.hand is None:
                self._arm(event.release, event.arm).lead(None)
            case LeadEvent():
                self._lead(event.lead, event.joint, led_value(self._world, event))
        # Hands set out at the tick, not at the time that the file has.
        happened: WorldEvent = event.model_copy(update={"time": time})
        if isinstance(happened, ReachEvent) and happened.hand is not None:
            happened = self._scenery.tried(happened)
        self._scenery.show(replace(self._scenery.looks.after(happened, self._world), time=time))
        self._happened.append(happened)

    @property
    def looks(self) -> Looks:
        """Light, and what was taken away."""
        return self._scenery.looks

    def happened(self) -> tuple[WorldEvent, ...]:
        """Return what has happened since the last call, each at the time when it did."""
        happened, self._happened = tuple(self._happened), []
        return happened

    def run(
        self,
        count: int,
        first: int,
        *,
        actuations: Sequence[Actuation] = (),
        after_each: Sequence[Callable[[], None]] = (),
    ) -> None:
        """Take physics steps.

        Args:
            count: How many.
            first: Number of the first one, counted from 0 at the start of the run.
            actuations: What tells motors what to do; each acts before the steps that it is due at.
            after_each: Called after each step.
        """
        model, data = self._model, self._data
        alone = not after_each and not self._movers and not self._joints.moving and not self._shoves
        # One call for many steps is quicker than one each.
        stride = math.gcd(count, *(actuation.every for actuation in actuations)) if alone else 1
        for number in range(first, first + count, stride):
            for actuation in actuations:
                if number % actuation.every == 0:
                    actuation.act(number)
            if alone:
                mujoco.mj_step(model, data, stride)
                continue
            self._movers.put(number * model.opt.timestep)
            self._joints.drive()
            if self._shoves:
                self._shoves.push()
            mujoco.mj_step(model, data)
            for call in after_each:
                call()
        if not alone:
            self._movers.put((first + count) * model.opt.timestep)

    def things(self) -> dict[str, Pose]:
        """Return where everything is that can move but robots, world frame: `obstacle/NAME`, and `door/NAME`.

        A door's place is its hinge, its heading that of its leaf. What was taken away is left out.
        """
        gone = self._scenery.looks.removed
        places = {f"obstacle/{name}": self._pose(f"obstacle/{name}") for name in self._moving if name not in gone}
        doors = {f"door/{name}": leaf.pose(self._joints.value(f"door/{name}")) for name, leaf in self._doors.items()}
        return places | doors

    def door(self, name: str) -> float:
        """Return how far a door stands open, positive to the left side of its wall [rad]."""
        _require(name, "door", self._doors)
        return self._joints.value(f"door/{name}")

    def _check(self, event: WorldEvent) -> None:
        """Raise UsageError when what an event names is not there, or cannot be so."""
        robots = [robot.name for robot in self._world.robots]
        match event:
            case MoveEvent():
                free = [robot.name for robot in self._world.robots if robot.base != "fixed"]
                _require(event.move, "robot or movable obstacle", free + self._movable)
            case ShoveEvent():
                _require(event.shove, "robot or movable obstacle", robots + self._movable)
            case PushEvent():
                _require(event.push, "robot or movable obstacle", robots + self._movable)
                self._force(event)
            case OpenEvent():
                _require(event.open, "door", self._doors)
                self._check_swing(event)
            case CloseEvent():
                _require(event.close, "door", self._doors)
            case LampEvent():
                _require(event.lamp, "lamp", self._scenery.looks.lamps)
            case RemoveEvent():
                things = [item.name for item in (*self._world.beacons, *self._world.obstacles) if item.name]
                _require(event.remove, "beacon or obstacle", things)
            case RestoreEvent():
                _require(event.restore, "beacon", [beacon.name for beacon in self._world.beacons])
            case ReachEvent(reach=name) | ReleaseEvent(release=name) if event.hand is not None:
                _require(name, "person", [person.name for person in self._world.people])
            case LeadEvent() | ReleaseEvent(joint=str()):
                self._check_led(event)
            case ReachEvent() | ReleaseEvent():
                self._check_arm(event)

    def _check_led(self, event: LeadEvent | ReleaseEvent) -> None:
        try:
            if isinstance(event, LeadEvent):
                led_value(self._world, event)
            else:
                led_joint(self._world, event.release, event.joint or "")
        except ValueError as error:
            raise UsageError(str(error)) from None

    def _check_arm(self, event: ReachEvent | ReleaseEvent) -> None:
        try:
            arm_of_event(self._world, event)
        except ValueError as error:
            raise UsageError(str(error)) from None
        if isinstance(event, ReachEvent) and (wrong := self._reached(event)[1]) is not None:
            raise wrong

    def _reached(self, event: ReachEvent) -> tuple[Array, UsageError | None]:
        """Return the joint values that an event asks for, from where they shall be now, and what is wrong with them."""
        item, now = arm_of_event(self._world, event), self._arm(event.reach, event.arm).goal()
        return reached_joints(item, event, now)

    def _force(self, event: PushEvent, rng: "Generator | None" = None) -> "TimeSignal":
        """Return the force of a push over time [N]; raise UsageError when its signal cannot be made."""
        try:
            return event.signal.made(self._world.read_asset, rng)
        except ValueError as error:
            raise UsageError(f"the signal of the push of '{event.push}': {error}") from None

    def _check_swing(self, event: OpenEvent) -> None:
        leaf = self._doors[event.open]
        joint, angle = leaf.joint(), math.radians(event.angle_deg)
        if not joint.lower - EARLY <= angle <= joint.upper + EARLY:
            most = leaf.door.limit_deg
            raise UsageError(
                f"the angle is {event.angle_deg:.6g} degrees; door '{event.open}' swings to {most:.6g} at most"
            )

    def _check_room(self, event: MoveEvent) -> None:
        """Raise UsageError when something would be put down in what stays, or in what is there now."""
        message = misplaced(self._world, event)
        if message is None and (found := self._met(event)) is not None:
            where = f"[{event.to[0]:g}, {event.to[1]:g}]"
            message = f"'{event.move}' is placed at {where} inside {found}; move it to a free place"
        if message is not None:
            raise UsageError(message)

    def _met(self, event: MoveEvent) -> str | None:
        """Return what that moves, or stands on its own by then, something would be put down in; None for nothing."""
        model = self._model
        trial = mujoco.MjData(model)
        mujoco.mj_copyData(trial, model, self._data)
        for due in reversed(self._due):
            if isinstance(due, MoveEvent) and due.time <= event.time + EARLY:
                self._put_down(due, trial)
        own = self._put_down(event, trial)
        mujoco.mj_fwdPosition(model, trial)
        for contact in trial.contact[: trial.ncon]:
            roots = model.body_rootid[model.geom_bodyid[contact.geom]].tolist()
            other = next((root for root in roots if root not in (own, 0)), None)
            if other is not None and own in roots and contact.dist < -DEEP:
                kind, _, name = model.body(other).name.partition("/")
                return f"{kind} '{name}'" if kind in ("obstacle", "door") else f"'{kind}'"
        return None

    def _body(self, name: str) -> str:
        """Return the body of a robot or an obstacle that is pushed."""
        return f"{name}/base" if name in self._heights else f"obstacle/{name}"

    def _put_down(self, event: MoveEvent, data: mujoco.MjData) -> int:
        """Put what has a free joint down elsewhere, at rest in all its parts; its wheels stay as they are turned.

        Returns:
            The body that is the root of what was put down.
        """
        model = self._model
        joint = model.joint(f"{event.move}/free" if event.move in self._heights else f"obstacle/{event.move}")
        start = int(joint.qposadr[0])
        heading = _heading(_matrix(data.qpos[start + 3 : start + 7]))
        if event.heading_deg is not None:
            heading = math.radians(event.heading_deg)
        data.qpos[start : start + 2] = event.to
        data.qpos[start + 2] = self._heights.get(event.move, model.qpos0[start + 2])
        data.qpos[start + 3 : start + 7] = [math.cos(heading / 2), 0.0, 0.0, math.sin(heading / 2)]
        root = int(model.body_rootid[model.jnt_bodyid[joint.id]])
        data.qvel[model.body_rootid[model.dof_bodyid] == root] = 0.0
        return root

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
