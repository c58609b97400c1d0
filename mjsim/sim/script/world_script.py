"""Scripted changes of a world: events, movers, joints with motors."""

import itertools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import mujoco

from mjsim.errors import UsageError, did_you_mean
from mjsim.geometry import Array, Pose
from mjsim.sentences import Sentence
from mjsim.sim.actuation import Actuation
from mjsim.sim.script.mover_motion import Movers
from mjsim.sim.script.placing import heading_of, held_by, put_down
from mjsim.sim.script.scripted_joints import Joints
from mjsim.sim.script.shoves import Shoves
from mjsim.sim.states import Scenery
from mjsim.sim.streams import stream
from mjsim.world import (
    CloseEvent,
    GoalEvent,
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
    led_goals,
    led_values,
    misplaced,
    placement,
    reached_joints,
    single_targets,
    with_noise,
)

if TYPE_CHECKING:
    import numpy as np
    from numpy.random import Generator
    from numpy.typing import NDArray

    from mjsim.mechanics import TimeSignal
    from mjsim.sim.arm_motion import ArmAtWork

EVENT_TOLERANCE = 1e-9
"""Tolerance by which a tick may precede the time of its event [s]."""

ArmOf = Callable[[str, str], "ArmAtWork"]
Tune = Callable[[str, float], None]

Lead = Callable[[str, Mapping[str, float | None]], None]
Barred = Callable[[str, Mapping[str, float | None]], str]


class WorldScript:
    """Executes events, and moves scripted objects and motorised joints, in a compiled world."""

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
        """Set all moving objects to their initial poses; events at time 0 are still pending.

        Args:
            model: The compiled world.
            data: Its state.
            world: The world.
            seed: Seed of the run.
            arm: Returns an arm by the name of its robot and its own name.
            tune: Changes a noise parameter by its key; raises UsageError if it cannot.
            lead: Moves a joint of a mechanism, both given by name, to a value [rad, m]; None releases it.
            barred: Returns why a loop does not permit that, as text; '' if it does.
        """
        self._arm, self._tune, self._lead, self._barred = arm, tune, lead, barred
        self._seed, self._pushes = seed, 0
        self._model, self._data, self._world = model, data, world
        self._scenery = Scenery(model, world)
        self._movers = Movers(model, data, world)
        self._doors = {leaf.name: leaf for leaf in leaves(world)}
        self._joints = Joints(model, data, [leaf.joint() for leaf in self._doors.values()])
        self._shoves = Shoves(model, data)
        # The last one is next; of simultaneous events, the first in the file comes first.
        events = itertools.chain(*map(single_targets, world.run.events))
        self._due = sorted(events, key=lambda event: event.time)[::-1]
        self._happened: list[WorldEvent] = []
        obstacles = list(zip(world.obstacles, item_names(world.obstacles), strict=True))
        self._moving = [name for obstacle, name in obstacles if obstacle.movable or obstacle.path is not None]
        self._movable = [obstacle.name for obstacle in world.obstacles if obstacle.movable and obstacle.name]
        # A robot that leans at the start is placed upright.
        self._heights = {robot.name: 0.0 for robot in world.robots}
        self._movers.put(0.0)

    def schedule(
        self, event: WorldEvent, *, instead_of: WorldEvent | None = None, before: WorldEvent | None = None
    ) -> WorldEvent:
        """Schedule an event, after those of the same time.

        Args:
            event: The event.
            instead_of: A pending event to replace.
            before: A pending event of the same time to precede.

        Returns:
            The event; for a hand, with the distance that will remain to its target.

        Raises:
            UsageError: It names something that does not exist, or places something where there is no space; then
                nothing changes.
        """
        first, *later = single_targets(event)
        self._check_possible(first)
        for each in later:
            self._check(each)
        if isinstance(first, ReachEvent) and first.hand is not None:
            until = [each for each in reversed(self._due) if each.time <= first.time and each is not instead_of]
            first = self._scenery.tried(first, until)
        due = [each for each in self._due if each is not instead_of]
        place = next((number + 1 for number, each in enumerate(due) if each is before), 0)
        self._due = [*later[::-1], *due[:place], first, *due[place:]]
        # The sort is stable, and of simultaneous ones the newest comes first: it is executed last.
        self._due.sort(key=lambda each: -each.time)
        return event if later else first

    def _check_possible(self, event: WorldEvent) -> None:
        """Raise UsageError if an event is impossible now."""
        self._check(event)
        if isinstance(event, MoveEvent | RestoreEvent):
            move, removed = placement(event), self._scenery.removed_after(self._until(event))
            if move is not None and (message := misplaced(self._world, move, removed=removed)) is not None:
                raise UsageError(message)
            self._require_room(event)
        if isinstance(event, NoiseEvent):
            with_noise(self._world, event.noise, event.value)
        wrong = ""
        if isinstance(event, LeadEvent):
            wrong = self._barred(event.lead, led_goals(self._world, event))
        elif isinstance(event, ReleaseEvent) and event.joint is not None:
            wrong = self._barred(event.release, self._released(event.release, event.joint))
        if wrong:
            raise UsageError(wrong)

    def let_happen(self, time: float) -> None:
        """Execute all scripted events that are due at a time [s]."""
        while self._due and self._due[-1].time <= time + EVENT_TOLERANCE:
            self.happen(self._due.pop(), time)
        if self._scenery.looks.reached:
            self._scenery.show(replace(self._scenery.looks, time=time))

    def happen(self, event: WorldEvent, time: float) -> None:
        """Execute an event now; later targets of it follow in time.

        Raises:
            UsageError: It names something that does not exist.
        """
        event, *later = single_targets(event)
        self._check(event)
        match event:
            case MoveEvent() | RestoreEvent() if (move := placement(event)) is not None:
                self._put_down(move, self._data)
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
                self._lead(event.release, self._released(event.release, joint))
            case ReleaseEvent() if event.hand is None:
                self._arm(event.release, event.arm).lead(None)
            case LeadEvent():
                self._lead(event.lead, led_goals(self._world, event))
        # Hands start at the tick, not at the time in the file.
        happened: WorldEvent = event.model_copy(update={"time": time})
        if isinstance(happened, ReachEvent) and happened.hand is not None:
            happened = self._scenery.tried(happened)
        self._scenery.show(replace(self._scenery.looks.after(happened, self._world), time=time))
        self._happened.append(happened)
        if later:
            self._due = sorted([*later[::-1], *self._due], key=lambda each: -each.time)

    @property
    def looks(self) -> Looks:
        """Light and removed items."""
        return self._scenery.looks

    def happened(self) -> tuple[WorldEvent, ...]:
        """Return the events executed since the last call, each with its actual time."""
        happened, self._happened = tuple(self._happened), []
        return happened

    @property
    def acts(self) -> bool:
        """Whether it moves or pushes anything between ticks."""
        return bool(self._movers or self._joints.moving or self._shoves)

    def run(
        self,
        tick: int,
        *,
        actuations: Sequence[Actuation] = (),
        after_each: Sequence[Callable[[], None]] = (),
    ) -> None:
        """Take the physics steps of a tick.

        Args:
            tick: Its number, from 0 at the start of the run.
            actuations: Actuations of motors; each acts before the steps at which it is due.
            after_each: Functions called after each step.
        """
        model, data, steps = self._model, self._data, self._world.run.steps_per_tick
        scripted = self.acts
        # One call of many steps takes less time than many calls.
        stride = 1 if scripted or after_each else math.gcd(steps, *(actuation.every for actuation in actuations))
        for number in range(tick * steps, (tick + 1) * steps, stride):
            for actuation in actuations:
                if number % actuation.every == 0:
                    actuation.act(number)
            if scripted:
                self._movers.put(number * model.opt.timestep)
                self._joints.drive()
                self._shoves.push()
            mujoco.mj_step(model, data, stride)
            for call in after_each:
                call()
        self._movers.put((tick + 1) * steps * model.opt.timestep)

    def things(self) -> dict[str, Pose]:
        """Return the poses of all movable objects except robots, world frame: `obstacle/NAME`, and `door/NAME`.

        A door's position is its hinge, its heading that of its leaf. Removed objects are omitted.
        """
        removed = self._scenery.looks.removed
        places = {f"obstacle/{name}": self._pose(f"obstacle/{name}") for name in self._moving if name not in removed}
        doors = {f"door/{name}": leaf.pose(self._joints.value(f"door/{name}")) for name, leaf in self._doors.items()}
        return places | doors

    def door(self, name: str) -> float:
        """Return the opening angle of a door, positive to the left side of its wall [rad]."""
        _require(name, "door", self._doors)
        return self._joints.value(f"door/{name}")

    def _check(self, event: WorldEvent) -> None:
        """Raise UsageError if an event names something that does not exist, or is impossible."""
        robots = [robot.name for robot in self._world.robots]
        rolling = [robot.name for robot in self._world.robots if robot.base != "fixed"]
        match event:
            case MoveEvent():
                _require(event.move, "robot or movable obstacle", rolling + self._movable)
            case GoalEvent():
                _require(event.goal, "robot that drives", rolling)
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
            case RemoveEvent(remove=name) | RestoreEvent(restore=name, to=None):
                things = [item.name for item in (*self._world.beacons, *self._world.obstacles) if item.name]
                _require(name, "beacon or obstacle", things)
            case RestoreEvent():
                _require(event.restore, "movable obstacle", self._movable)
            case ReachEvent(reach=name) | ReleaseEvent(release=name) if event.hand is not None:
                _require(name, "person", [person.name for person in self._world.people])
            case LeadEvent() | ReleaseEvent(joint=str()):
                self._check_led(event)
            case ReachEvent() | ReleaseEvent():
                self._check_arm(event)

    def _check_led(self, event: LeadEvent | ReleaseEvent) -> None:
        try:
            if isinstance(event, LeadEvent):
                led_goals(self._world, event)
            else:
                led_values(self._world, event.release, event.joint or "")
        except ValueError as error:
            raise UsageError(str(error)) from None

    def _released(self, mechanism: str, joint: str) -> dict[str, None]:
        """Return the values of a joint that are released."""
        return dict.fromkeys(led_values(self._world, mechanism, joint))

    def _check_arm(self, event: ReachEvent | ReleaseEvent) -> None:
        try:
            arm_of_event(self._world, event)
        except ValueError as error:
            raise UsageError(str(error)) from None
        if isinstance(event, ReachEvent) and (wrong := self._reached(event)[1]) is not None:
            raise wrong

    def _reached(self, event: ReachEvent) -> tuple[Array, UsageError | None]:
        """Return the joint values requested by an event, based on the current goals, and an error if invalid."""
        item, now = arm_of_event(self._world, event), self._arm(event.reach, event.arm).goal()
        return reached_joints(item, event, now)

    def _force(self, event: PushEvent, rng: "Generator | None" = None) -> "TimeSignal":
        """Return the force of a push over time [N]; raises UsageError if its signal is invalid."""
        try:
            return event.signal.made(self._world.read_asset, rng)
        except ValueError as error:
            raise UsageError(Sentence("the signal of the push of '{push}': {error}", event.push, error)) from None

    def _check_swing(self, event: OpenEvent) -> None:
        leaf = self._doors[event.open]
        joint, angle = leaf.joint(), math.radians(event.angle_deg)
        if not joint.lower - EVENT_TOLERANCE <= angle <= joint.upper + EVENT_TOLERANCE:
            beyond = "the angle is {angle:.6g} degrees; door '{door}' swings to {limit:.6g} at most"
            raise UsageError(Sentence(beyond, event.angle_deg, event.open, leaf.door.limit_deg))

    def require_room(self, event: WorldEvent) -> None:
        """Raise UsageError if a move names something unknown, or puts it into anything but robots, which may swap."""
        self._check(event)
        if isinstance(event, MoveEvent):
            mobile = [robot.name for robot in self._world.robots if robot.base != "fixed"]
            roots = [int(self._model.body(self._body(name)).rootid[0]) for name in mobile]
            self._require_room(event, but=roots)

    def _require_room(self, event: MoveEvent | RestoreEvent, *, but: Sequence[int] = ()) -> None:
        """Raise UsageError if something would be placed, or come back, inside something currently there."""
        if (found := self._obstacle_at(event, but=but)) is not None:
            if isinstance(event, RestoreEvent) and event.to is None:
                back = "'{name}' would come back inside {found}; move that away first"
                raise UsageError(Sentence(back, event.restore, found))
            name, (x, y) = event.move if isinstance(event, MoveEvent) else event.restore, event.to or (0.0, 0.0)
            inside = "'{name}' is placed at [{x:g}, {y:g}] inside {found}; move it to a free place"
            raise UsageError(Sentence(inside, name, x, y, found))

    def _obstacle_at(self, event: MoveEvent | RestoreEvent, *, but: Sequence[int] = ()) -> str | None:
        """Return the object inside which something would be placed; None if there is none, such as on the floor."""
        model = self._model
        trial = mujoco.MjData(model)
        mujoco.mj_copyData(trial, model, self._data)
        events = self._until(event)
        put = [self._put_down(move, trial) for each in events if (move := placement(each)) is not None]
        own = self._scenery.geoms(event.restore) if isinstance(event, RestoreEvent) else put[-1]
        with self._scenery.without(self._scenery.removed_after(events)):
            mujoco.mj_fwdPosition(model, trial)
        return held_by(model, trial, own, but=but)

    def _until(self, event: WorldEvent) -> list[WorldEvent]:
        """Return the events that are due before an event, and the event."""
        return [*(due for due in reversed(self._due) if due.time <= event.time + EVENT_TOLERANCE), event]

    def _body(self, name: str) -> str:
        """Return the body of a robot or an obstacle to push."""
        return f"{name}/base" if name in self._heights else f"obstacle/{name}"

    def _put_down(self, event: MoveEvent, data: mujoco.MjData) -> "NDArray[np.intp]":
        """Move a robot or an obstacle elsewhere in a state; return its geoms."""
        joint = f"{event.move}/free" if event.move in self._heights else f"obstacle/{event.move}"
        height = self._heights.get(event.move)
        heading = None if event.heading_deg is None else math.radians(event.heading_deg)
        return put_down(self._model, data, joint, event.to, height=height, heading=heading)

    def _pose(self, body: str) -> Pose:
        index = self._model.body(body).id
        x, y, _ = self._data.xpos[index].tolist()
        return Pose(x, y, heading_of(self._data.xmat[index]))


def _require(name: str, kind: str, known: Iterable[str]) -> None:
    if name not in known:
        meant = did_you_mean(name, known)
        raise UsageError(Sentence("no {kind} '{name}' in this world{meant}", kind, name, meant))
