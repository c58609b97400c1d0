"""Events of a world during a run."""

from collections.abc import Mapping
from typing import Annotated, Literal, Self

from pydantic import Field, PrivateAttr, TypeAdapter, ValidationError, model_validator

from mjsim.errors import UsageError, did_you_mean
from mjsim.sentences import Sentence
from mjsim.world.ground import (
    Degrees,
    Metres,
    Model,
    Name,
    OneOf,
    Point,
    Point3,
    RollPitchYaw,
    fault,
    kind_of,
    path_of,
    sentence,
)
from mjsim.world.items.room_lamps import Brightness
from mjsim.world.items.timeline.signals import Signal

MAX_TARGETS = 1000
"""Maximum number of targets of an event after its first."""


class _Event(Model):
    time: Annotated[float, Field(ge=0, le=1e6)]
    """Time; the event happens at the first tick not before it [s]."""


class MoveEvent(_Event):
    """Moves a robot or an obstacle elsewhere; the modules of a robot are not informed (kidnapping)."""

    move: Name
    """The robot or movable obstacle."""
    to: Point
    """[x, y] [m]."""
    heading_deg: Degrees | None = None
    """New heading; default: unchanged."""


class OpenEvent(_Event):
    """Opens a door."""

    open: Name
    """The opening with the door."""
    angle_deg: Annotated[float, Field(ge=-170, le=170)] = 90.0
    """Target angle; positive to the left side of the wall."""


class CloseEvent(_Event):
    """Closes a door."""

    close: Name
    """The opening with the door."""


class LightEvent(_Event):
    """Changes the ambient light."""

    light: Brightness
    """As the key `light` of the world."""


class LampEvent(_Event):
    """Switches or dims a lamp."""

    lamp: Name
    """Its name."""
    brightness: Brightness
    """0 is off."""


class NoiseEvent(_Event):
    """Changes the noise of a sensor, a drive or odometry from then on; modules are not informed."""

    noise: Annotated[str, Field(min_length=1, max_length=500)]
    """Key of the parameter as in `--set`, such as robots.scout.odometry.noise.turn."""
    value: Annotated[float, Field(ge=-1e6, le=1e6)]
    """New value, in its unit."""


class RemoveEvent(_Event):
    """Removes a beacon or an obstacle."""

    remove: Name
    """Its name."""


class RestoreEvent(_Event):
    """Restores a removed beacon or obstacle, with everything attached to it."""

    restore: Name
    """The beacon or obstacle; a beacon stays away if its carrier was removed."""
    to: Point | None = None
    """[x, y] for a movable obstacle; default: where it was removed [m]."""
    heading_deg: Degrees | None = None
    """New heading with `to`; default: unchanged."""

    @model_validator(mode="after")
    def _is_turned_elsewhere(self) -> Self:
        if self.heading_deg is not None and self.to is None:
            raise fault("what is restored keeps its heading unless it is put elsewhere; give to: [x, y]", "heading_deg")
        return self


class ShoveEvent(_Event):
    """Applies an impulse to the centre of mass of a robot or movable obstacle."""

    shove: Name
    """The robot or movable obstacle."""
    impulse: Annotated[
        tuple[Annotated[float, Field(ge=-1e5, le=1e5)], ...], Field(strict=False, min_length=3, max_length=3)
    ]
    """Total impulse [x, y, z], world frame [N s]."""
    seconds: Annotated[float, Field(gt=0, le=10)] = 0.1
    """Duration of the push [s]."""


class PushEvent(_Event):
    """Applies a time-varying force to the centre of mass of a robot or movable obstacle."""

    push: Name
    """The robot or movable obstacle."""
    signal: Signal
    """The force; its time starts at the event [N]."""
    along: Annotated[
        tuple[Annotated[float, Field(ge=-1, le=1)], ...], Field(strict=False, min_length=3, max_length=3)
    ] = (1.0, 0.0, 0.0)
    """Direction of a positive force, [x, y, z], world frame; its length scales the force."""
    seconds: Annotated[float, Field(gt=0, le=1e6)] | None = None
    """Duration; default: to the end of the run [s]."""

    @model_validator(mode="after")
    def _is_a_force(self) -> Self:
        if (wrong := self.signal.misfit(angle=False)) is not None:
            raise fault(wrong[0], "signal", *wrong[1])
        return self


TargetRows = Annotated[
    tuple[Annotated[tuple[Annotated[float, Field(ge=-1e6, le=1e6)], ...], Field(strict=False)], ...],
    Field(strict=False, min_length=1, max_length=MAX_TARGETS),
]


class ReachEvent(_Event):
    """Moves an arm to joint values or a tool pose, at up to 1 rad/s or 1 m/s, and holds it until released.

    For a person, moves a hand, at up to 1 m/s, and holds it until released.
    """

    reach: Name
    """The robot or person."""
    arm: Name = "arm"
    """Name of the arm."""
    joints_deg: Annotated[tuple[Metres, ...], Field(strict=False, min_length=1, max_length=32)] | None = None
    """Joint values [deg, m]."""
    tool: Point3 | None = None
    """Tool position [x, y, z] in the robot frame instead, by inverse kinematics [m]."""
    rpy_deg: RollPitchYaw | None = None
    """Tool orientation [roll, pitch, yaw] about the axes of the robot, right-handed, in this order. Without it, and for
    arms with fewer than six joints, only the position of the tool counts."""
    hand: Literal["left", "right"] | None = None
    """For a person: which hand."""
    to: Point3 | None = None
    """Position [x, y, z] of its grip, world frame, by inverse kinematics; as close as possible if out of reach [m]."""
    then: TargetRows | None = None
    """Later targets in place of the first: rows of the time after the event, and the target [s, ...]."""
    _short: float = PrivateAttr(default=0.0)

    @property
    def short(self) -> float:
        """Distance between the hand and its target [m], once known; 0 if it reaches it."""
        return self._short

    def stays_away(self, short: float) -> Self:
        """Return the same event with the distance that remains to the target [m]."""
        copy = self.model_copy()
        copy._short = short
        return copy

    @model_validator(mode="after")
    def _has_goal(self) -> Self:
        if self.hand is not None or self.to is not None:
            self._check_hand_goal()
        elif (self.joints_deg is None) == (self.tool is None):
            raise fault("an arm reaches for joint values or with its tool; give joints_deg or tool: [x, y, z]")
        elif self.rpy_deg is not None and self.tool is None:
            raise fault("rpy_deg turns a tool; give tool: [x, y, z] with it", "rpy_deg")
        _check_rows(self.then, len(self.to or self.tool or self.joints_deg or ()))
        return self

    def _check_hand_goal(self) -> None:
        if self.hand is None or self.to is None:
            raise fault("a person reaches with a hand; give hand: left or right, and to: [x, y, z]")
        _refuse_of_arms(self, "arm", "joints_deg", "tool", "rpy_deg")


def _check_rows(rows: tuple[tuple[float, ...], ...] | None, size: int) -> None:
    """Raise if a row does not have a later time than the one before, and as many numbers as the first target."""
    last = 0.0
    for number, row in enumerate(rows or ()):
        if len(row) != 1 + size:
            target = "the value" if size == 1 else Sentence("the {size} numbers of the target", size)
            raise fault(
                Sentence("this row has {count} numbers; give the time after the event, and {target}", len(row), target),
                "then",
                number,
            )
        if row[0] <= last:
            raise fault(
                Sentence("time {time:g} s is not after {last:g} s; put the rows in order of time", row[0], last),
                "then",
                number,
            )
        last = row[0]


class ReleaseEvent(_Event):
    """Returns an arm to its navigator, a hand of a person to its initial position, or a joint to its own motion."""

    release: Name
    """The robot, person or mechanism."""
    arm: Name = "arm"
    """Name of the arm."""
    hand: Literal["left", "right"] | None = None
    """For a person: which hand."""
    joint: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """For a mechanism: which joint. A joint without limits keeps whole turns of difference from its signal."""

    @model_validator(mode="after")
    def _is_of_one(self) -> Self:
        if self.hand is not None:
            _refuse_of_arms(self, "arm")
            if self.joint is not None:
                raise fault("'joint' is for mechanisms, 'hand' for people; leave out one of them", "joint")
        if self.joint is not None and self.arm != "arm":
            raise fault("'joint' is for mechanisms, 'arm' for robots; leave out one of them", "joint")
        return self


def _refuse_of_arms(event: ReachEvent | ReleaseEvent, *keys: str) -> None:
    """Raise if an event of a hand also has keys of an arm."""
    for key in keys:
        if getattr(event, key) != type(event).model_fields[key].default:
            raise fault(Sentence("'{key}' is for a robot's arm, 'hand' for people; leave out one of them", key), key)


_Turn = Annotated[float, Field(ge=-36000, le=36000)]


class LeadEvent(_Event):
    """Moves a joint of a mechanism to a value, at about 1 rad/s or 1 m/s, and holds it there."""

    lead: Name
    """The mechanism."""
    joint: Annotated[str, Field(min_length=1, max_length=200)]
    """The joint, or `JOINT.VALUE`."""
    to_deg: _Turn | None = None
    """Value [deg], or [m] for a translational joint."""
    rotation_deg: Annotated[tuple[_Turn, ...], Field(strict=False, min_length=3, max_length=3)] | None = None
    """For a ball joint, instead of one value: its rotation vector [rx, ry, rz]."""
    then: TargetRows | None = None
    """Later values in place of the first: rows of the time after the event, and the value or rotation [s, deg]."""

    @model_validator(mode="after")
    def _says_where(self) -> Self:
        if (self.to_deg is None) == (self.rotation_deg is None):
            raise fault("a joint is led to a value, a ball to a rotation; give to_deg, or rotation_deg: [rx, ry, rz]")
        _check_rows(self.then, 1 if self.rotation_deg is None else 3)
        return self


class GoalEvent(_Event):
    """Gives a robot's navigator a new goal in place of the others."""

    goal: Name
    """The robot; its navigator must take goals, as `GoToGoal` does."""
    to: Point
    """[x, y], in the frame of the estimate [m]."""
    heading_deg: Degrees | None = None
    """Heading at the goal; default: any."""


EVENT_KINDS: dict[str, type[_Event]] = {
    "move": MoveEvent,
    "open": OpenEvent,
    "close": CloseEvent,
    "light": LightEvent,
    "lamp": LampEvent,
    "noise": NoiseEvent,
    "remove": RemoveEvent,
    "restore": RestoreEvent,
    "shove": ShoveEvent,
    "push": PushEvent,
    "reach": ReachEvent,
    "release": ReleaseEvent,
    "lead": LeadEvent,
    "goal": GoalEvent,
}
"""Event models by their key."""


WorldEvent = Annotated[
    MoveEvent
    | OpenEvent
    | CloseEvent
    | LightEvent
    | LampEvent
    | NoiseEvent
    | RemoveEvent
    | RestoreEvent
    | ShoveEvent
    | PushEvent
    | ReachEvent
    | ReleaseEvent
    | LeadEvent
    | GoalEvent,
    OneOf(
        EVENT_KINDS,
        "an event needs an action; write move: NAME, open: DOOR, close: DOOR, light: 0.5, lamp: NAME,"
        " noise: KEY, remove: NAME, restore: NAME, shove: NAME, push: NAME, reach: ROBOT or PERSON,"
        " release: ROBOT, PERSON or MECHANISM, lead: MECHANISM, or goal: ROBOT",
    ),
]


def placement(event: WorldEvent) -> MoveEvent | None:
    """Return the move that an event makes; None if it puts nothing elsewhere."""
    if isinstance(event, RestoreEvent) and event.to is not None:
        return MoveEvent(time=event.time, move=event.restore, to=event.to, heading_deg=event.heading_deg)
    return event if isinstance(event, MoveEvent) else None


_EVENT: TypeAdapter[WorldEvent] = TypeAdapter(WorldEvent)


def event_from(keys: Mapping[str, object]) -> WorldEvent:
    """Return the event given by the keys of a world file.

    Raises:
        UsageError: A key is unknown or missing, or a value is not allowed.
    """
    kind = kind_of(dict(keys), EVENT_KINDS)
    if kind is None:
        key = next((key for key in keys if key != "time"), "")
        raise UsageError(Sentence("an event needs an action{meant}", did_you_mean(key, EVENT_KINDS)))
    try:
        event: WorldEvent = _EVENT.validate_python(dict(keys))
    except ValidationError as error:
        first = error.errors()[0]
        path = tuple(step for step in path_of(first) if step != f"<{kind}>")
        raise UsageError(sentence(first, path, EVENT_KINDS[kind])) from None
    return event
