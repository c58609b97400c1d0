"""What happens to a world while it runs."""

import math
from collections.abc import Mapping
from typing import Annotated, Literal, Self

from pydantic import Field, PrivateAttr, TypeAdapter, ValidationError, model_validator

from mjsim.errors import UsageError, did_you_mean
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
from mjsim.world.items.light import Brightness
from mjsim.world.items.signals import Signal


class _Event(Model):
    time: Annotated[float, Field(ge=0, le=1e6)]
    """When, at the first tick not before it [s]."""


class MoveEvent(_Event):
    """A robot or an obstacle is lifted and put down elsewhere; a robot is not told."""

    move: Name
    """The robot, or the movable obstacle."""
    to: Point
    """[x, y] [m]."""
    heading_deg: Degrees | None = None
    """As it was unless given."""


class OpenEvent(_Event):
    """A door swings open."""

    open: Name
    """The opening whose door it is."""
    angle_deg: Annotated[float, Field(ge=-170, le=170)] = 90.0
    """How far; positive to the left side of the wall."""


class CloseEvent(_Event):
    """A door swings shut."""

    close: Name
    """The opening whose door it is."""


class LightEvent(_Event):
    """The general light changes."""

    light: Brightness
    """As the key `light` of the world."""


class LampEvent(_Event):
    """A lamp is switched or dimmed."""

    lamp: Name
    """Which one."""
    brightness: Brightness
    """0 is off."""


class NoiseEvent(_Event):
    """A sensor, a drive or its odometry errs otherwise from now on; modules are not told."""

    noise: Annotated[str, Field(min_length=1, max_length=500)]
    """Which figure, as `--set` names it, such as robots.scout.odometry.noise.turn."""
    value: Annotated[float, Field(ge=-1e6, le=1e6)]
    """The new one, in its unit."""


class RemoveEvent(_Event):
    """A beacon or an obstacle is taken away."""

    remove: Name
    """Which one."""


class RestoreEvent(_Event):
    """A beacon that was taken away is there again."""

    restore: Name
    """The beacon; one on what was taken away itself stays away."""


class ShoveEvent(_Event):
    """A robot or a movable obstacle is pushed at its centre of mass."""

    shove: Name
    """Whom."""
    impulse: Annotated[
        tuple[Annotated[float, Field(ge=-1e5, le=1e5)], ...], Field(strict=False, min_length=3, max_length=3)
    ]
    """[x, y, z] in the world, all of it together [N s]."""
    seconds: Annotated[float, Field(gt=0, le=10)] = 0.1
    """How long the push takes [s]."""


class PushEvent(_Event):
    """A force that changes with time acts at the centre of mass of a robot or a movable obstacle."""

    push: Name
    """Whom."""
    signal: Signal
    """The force, its time counted from the event [N]."""
    along: Annotated[
        tuple[Annotated[float, Field(ge=-1, le=1)], ...], Field(strict=False, min_length=3, max_length=3)
    ] = (1.0, 0.0, 0.0)
    """[x, y, z] in the world, the direction of a positive force; its length scales the force."""
    seconds: Annotated[float, Field(gt=0, le=1e6)] | None = None
    """How long it acts; to the end of the run unless given [s]."""

    @model_validator(mode="after")
    def _is_a_force(self) -> Self:
        if (wrong := self.signal.misfit(angle=False)) is not None:
            raise fault(wrong[0], "signal", *wrong[1])
        return self


class ReachEvent(_Event):
    """An arm goes to joint values or a pose of its tool, at 1 rad/s or 1 m/s at most, and stays until released.

    Of a person, a hand goes elsewhere, at 1 m/s at most, and stays there until released.
    """

    reach: Name
    """The robot, or the person."""
    arm: Name = "arm"
    """Which of its arms."""
    joints_deg: Annotated[tuple[Metres, ...], Field(strict=False, min_length=1, max_length=32)] | None = None
    """Value of each joint [deg, m]."""
    tool: Point3 | None = None
    """[x, y, z] of the tool in the robot's frame instead, found by inverse kinematics [m]."""
    rpy_deg: RollPitchYaw | None = None
    """[roll, pitch, yaw] of the tool about the axes of the robot, right-handed, in this order. Unless it is given,
    and of an arm with fewer than six joints, only the place of the tool counts."""
    hand: Literal["left", "right"] | None = None
    """Of a person: which hand."""
    to: Point3 | None = None
    """[x, y, z] of its grip in the world, found by inverse kinematics; out of reach, it comes as near as it can [m]."""
    _short: float = PrivateAttr(default=0.0)

    @property
    def short(self) -> float:
        """How far the hand stays away from where it was led [m], once it is known; 0 when it gets there."""
        return self._short

    def stays_away(self, short: float) -> Self:
        """Return the same event, of a hand that stays so far away from where it was led [m]."""
        copy = self.model_copy()
        copy._short = short
        return copy

    @model_validator(mode="after")
    def _says_where(self) -> Self:
        if self.hand is not None or self.to is not None:
            return self._says_where_the_hand_is()
        if (self.joints_deg is None) == (self.tool is None):
            raise fault("an arm reaches for joint values or with its tool; give joints_deg or tool: [x, y, z]")
        if self.rpy_deg is not None and self.tool is None:
            raise fault("rpy_deg turns a tool; give tool: [x, y, z] with it", "rpy_deg")
        return self

    def _says_where_the_hand_is(self) -> Self:
        if self.hand is None or self.to is None:
            raise fault("a person reaches with a hand; give hand: left or right, and to: [x, y, z]")
        _refuse_of_arms(self, "arm", "joints_deg", "tool", "rpy_deg")
        return self


class ReleaseEvent(_Event):
    """The navigator moves an arm again; a hand of a person goes back to where it was at the start."""

    release: Name
    """The robot, or the person."""
    arm: Name = "arm"
    """Which of its arms."""
    hand: Literal["left", "right"] | None = None
    """Of a person: which hand."""

    @model_validator(mode="after")
    def _is_of_one(self) -> Self:
        if self.hand is not None:
            _refuse_of_arms(self, "arm")
        return self


def _refuse_of_arms(event: ReachEvent | ReleaseEvent, *keys: str) -> None:
    """Raise when an event of a hand has keys of an arm as well."""
    for key in keys:
        if getattr(event, key) != type(event).model_fields[key].default:
            raise fault(f"'{key}' is of a robot's arm, 'hand' of a person; leave out one of them", key)


class LeadEvent(_Event):
    """A joint of a mechanism that follows a motion goes to a value, at 1 rad/s or 1 m/s or so, and stays there."""

    lead: Name
    """The mechanism."""
    joint: Annotated[str, Field(min_length=1, max_length=200)]
    """Joint of an `angle`, `position` or `velocity` actuator, or `JOINT.VALUE`."""
    to_deg: Annotated[float, Field(ge=-36000, le=36000)]
    """Its value [deg], or [m] of one that slides."""


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
}
"""Events by the key that says what happens."""


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
    | LeadEvent,
    OneOf(
        EVENT_KINDS,
        "an event needs what happens; write move: NAME, open: DOOR, close: DOOR, light: 0.5, lamp: NAME,"
        " noise: KEY, remove: NAME, restore: BEACON, shove: NAME, push: NAME, reach: ROBOT or PERSON,"
        " release: ROBOT or PERSON, or lead: MECHANISM",
    ),
]


_EVENT: TypeAdapter[WorldEvent] = TypeAdapter(WorldEvent)


def event_from(keys: Mapping[str, object]) -> WorldEvent:
    """Return the event of keys as a world file has them.

    Raises:
        UsageError: A key is unknown or missing, or a value does not fit.
    """
    kind = kind_of(dict(keys), EVENT_KINDS)
    if kind is None:
        said = next((key for key in keys if key != "time"), "")
        raise UsageError(f"an event needs what happens{did_you_mean(said, EVENT_KINDS)}")
    try:
        event: WorldEvent = _EVENT.validate_python(dict(keys))
    except ValidationError as error:
        first = error.errors()[0]
        path = tuple(step for step in path_of(first) if step != f"<{kind}>")
        raise UsageError(sentence(first, path, EVENT_KINDS[kind])) from None
    return event


def said_of(event: WorldEvent) -> str:
    """Return what an event does, in a sentence."""
    match event:
        case MoveEvent():
            heading = "" if event.heading_deg is None else f", heading {event.heading_deg:g} deg"
            return f"{event.move} is put down at [{event.to[0]:g}, {event.to[1]:g}]{heading}"
        case OpenEvent():
            return f"door {event.open} swings open to {event.angle_deg:g} deg"
        case CloseEvent():
            return f"door {event.close} swings shut"
        case LightEvent():
            return f"the general light becomes {event.light:g}"
        case LampEvent():
            return f"lamp {event.lamp} becomes {event.brightness:g}"
        case NoiseEvent():
            return f"{event.noise} becomes {event.value:g}"
        case RemoveEvent():
            return f"{event.remove} is taken away"
        case RestoreEvent():
            return f"{event.restore} is there again"
        case ShoveEvent():
            return f"{event.shove} is shoved by {math.hypot(*event.impulse):g} N s"
        case PushEvent():
            duration = "" if event.seconds is None else f" for {event.seconds:g} s"
            return f"{event.push} is pushed by a force, a {event.signal.kind}{duration}"
        case ReachEvent(to=to) if to is not None:
            short = f", which is {event.short:.2g} m out of reach" if event.short else ""
            return f"the {event.hand} hand of {event.reach} reaches for [{to[0]:g}, {to[1]:g}, {to[2]:g}]{short}"
        case ReachEvent():
            return f"{event.arm} of {event.reach} goes to {_goal_said(event)}"
        case ReleaseEvent(hand=str(hand)):
            return f"the {hand} hand of {event.release} goes back to where it was at the start"
        case ReleaseEvent():
            return f"{event.arm} of {event.release} is its navigator's again"
        case LeadEvent():
            return f"joint {event.joint} of {event.lead} goes to {event.to_deg:g}"


def _goal_said(event: ReachEvent) -> str:
    values = event.tool or event.joints_deg or ()
    listed = ", ".join(f"{value:g}" for value in values)
    return f"joints [{listed}]" if event.tool is None else f"[{listed}] with its tool"
