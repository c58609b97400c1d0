"""Requests of a browser to a run, over the WebSocket."""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from mjsim.errors import UsageError, did_you_mean
from mjsim.sentences import Sentence
from mjsim.world import World, with_values

Share = Annotated[float, Field(ge=-1.0, le=1.0)]
"""Fraction of a limit of the robot."""
Drivers = dict[str, dict[Literal["observer", "estimator", "navigator", "avoidance", "push"], Any]]
"""Robot -> modules that replace those of its world."""
Number = Annotated[float, Field(allow_inf_nan=False)]
Moderate = Annotated[float, Field(ge=-1e6, le=1e6)]
"""Coordinates beyond it overflow when drawn."""


class _Request(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Start(_Request):
    """Start a run of a world's text."""

    do: Literal["start"]
    path: str | None = None
    text: str
    seed: Annotated[int, Field(ge=0, lt=2**63)] | None = None
    seconds: Annotated[float, Field(gt=0, le=1e6)] | None = None
    speed: Annotated[float, Field(gt=0, le=1e6)] | None = None
    drivers: Drivers = {}
    record: str | None = None


class Simple(_Request):
    """A request without arguments."""

    do: Literal["pause", "go", "tick", "restart", "stop"]


class SetSpeed(_Request):
    """Run at a multiple of real time."""

    do: Literal["speed"]
    value: Annotated[float, Field(gt=0, le=1e6)] | None = None


class DriveByHand(_Request):
    """Drive a robot manually, as fractions of its limits; null releases control."""

    do: Literal["drive"]
    robot: str
    forward: Share | None = None
    left: Share | None = None
    turn: Share | None = None


class Touch(_Request):
    """Trigger an event of the world file at the next tick; a paused run executes that tick."""

    do: Literal["touch"]
    event: dict[str, Any]
    """Its keys as in the world file, without `time`."""
    drag: Literal["first", "next"] | None = None
    """While something is dragged: the first of its targets, or a later one, which becomes a part of the same event. A
    paused run executes no tick."""


class SetNoise(_Request):
    """Change a noise parameter."""

    do: Literal["set"]
    key: str
    value: Number


class Outside(_Request):
    """Viewpoint of the external view."""

    azimuth_deg: Moderate
    elevation_deg: Annotated[float, Field(ge=-90.0, le=90.0)]
    distance: Annotated[float, Field(gt=0.0, le=1000.0)]
    at: tuple[Moderate, Moderate]


class Watch(_Request):
    """Choose the views to be sent."""

    do: Literal["watch"]
    cameras: Annotated[list[str], Field(max_length=100)] = []
    depth: bool = False
    segmentation: bool = False
    outside: Outside | None = None
    bodies: bool = False
    """Whether to send the poses of bodies in the 3-D scene; that scene must have been requested before."""


class FrameShown(_Request):
    """A picture has been displayed: another may be sent."""

    do: Literal["shown"]
    number: int


REQUESTS: tuple[type[BaseModel], ...] = (
    Start,
    Simple,
    SetSpeed,
    DriveByHand,
    Touch,
    SetNoise,
    Watch,
    FrameShown,
)
RunRequest = Annotated[
    Start | Simple | SetSpeed | DriveByHand | Touch | SetNoise | Watch | FrameShown,
    Field(discriminator="do"),
]
_REQUEST: TypeAdapter[RunRequest] = TypeAdapter(RunRequest)


def read_request(text: str) -> RunRequest:
    """Return the request in a message.

    Raises:
        UsageError: It is not a valid request.
    """
    try:
        return _REQUEST.validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        location = ".".join(map(str, first["loc"])) or "the request"
        raise UsageError(f"{location}: {first['msg'][0].lower()}{first['msg'][1:]}") from None


def with_drivers(world: World, chosen: Drivers) -> World:
    """Return the world with some of its modules replaced.

    Raises:
        UsageError: A robot does not exist, or a module is not valid for it.
    """
    if not chosen:
        return world
    names = [robot.name for robot in world.robots]
    drivers: dict[str, dict[Any, Any]] = {
        name: modules.model_dump(exclude_unset=True) for name, modules in world.run.drivers.items()
    }
    for name, modules in chosen.items():
        if name not in names:
            raise UsageError(
                Sentence("no robot '{robot}' to drive in this world{meant}", name, did_you_mean(name, names))
            )
        drivers[name] = {**drivers.get(name, {}), **modules}
    return with_values(world, {"run.drivers": drivers})
