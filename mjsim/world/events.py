"""What happens to a world while it runs."""

from typing import Annotated

from pydantic import Discriminator, Field, Tag

from mjsim.world.base import Degrees, Model, Name, Point
from mjsim.world.light import Brightness


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


class RemoveEvent(_Event):
    """A beacon or an obstacle is taken away."""

    remove: Name
    """Which one."""


KINDS: dict[str, type[_Event]] = {
    "move": MoveEvent,
    "open": OpenEvent,
    "close": CloseEvent,
    "light": LightEvent,
    "lamp": LampEvent,
    "remove": RemoveEvent,
}
"""Events by the key that says what happens."""


def _kind_of_event(item: object) -> str | None:
    if isinstance(item, dict):
        return next((f"<{kind}>" for kind in KINDS if kind in item), None)
    return next((f"<{kind}>" for kind, model in KINDS.items() if isinstance(item, model)), None)


Event = Annotated[
    Annotated[MoveEvent, Tag("<move>")]
    | Annotated[OpenEvent, Tag("<open>")]
    | Annotated[CloseEvent, Tag("<close>")]
    | Annotated[LightEvent, Tag("<light>")]
    | Annotated[LampEvent, Tag("<lamp>")]
    | Annotated[RemoveEvent, Tag("<remove>")],
    Discriminator(
        _kind_of_event,
        custom_error_type="kind",
        custom_error_message="an event needs what happens; write move: NAME, open: DOOR, close: DOOR, light: 0.5,"
        " lamp: NAME or remove: NAME",
    ),
]


def said_of(event: Event) -> str:
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
        case RemoveEvent():
            return f"{event.remove} is taken away"
