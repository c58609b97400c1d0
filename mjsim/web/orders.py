"""What a browser may ask of a run, over the WebSocket."""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from mjsim.errors import UsageError

Share = Annotated[float, Field(ge=-1.0, le=1.0)]
"""Of what a robot can do."""
Number = Annotated[float, Field(allow_inf_nan=False)]


class _Order(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Start(_Order):
    """Begin a run of a world's text."""

    do: Literal["start"]
    path: str | None = None
    text: str
    seed: Annotated[int, Field(ge=0, lt=2**63)] | None = None
    seconds: Annotated[float, Field(gt=0, le=1e6)] | None = None
    speed: Annotated[float, Field(gt=0, le=1e6)] | None = None
    drivers: dict[str, dict[Literal["observer", "estimator", "navigator", "avoidance", "push"], Any]] = {}
    record: str | None = None


class Simple(_Order):
    """What needs no more words."""

    do: Literal["pause", "go", "tick", "restart", "stop"]


class Speed(_Order):
    """Go at a multiple of real time."""

    do: Literal["speed"]
    value: Annotated[float, Field(gt=0, le=1e6)] | None = None


class Drive(_Order):
    """Drive a robot by hand, in shares of what it can do; no number gives it back."""

    do: Literal["drive"]
    robot: str
    forward: Share | None = None
    left: Share | None = None
    turn: Share | None = None


class SetNoise(_Order):
    """Change how far something errs."""

    do: Literal["set"]
    key: str
    value: Number | None


class Outside(_Order):
    """From where the view from outside looks."""

    azimuth_deg: Number
    elevation_deg: Annotated[float, Field(ge=-90.0, le=90.0)]
    distance: Annotated[float, Field(gt=0.0, le=1000.0)]
    at: tuple[Number, Number]


class Watch(_Order):
    """Choose the views that are sent."""

    do: Literal["watch"]
    cameras: Annotated[list[str], Field(max_length=100)] = []
    depth: bool = False
    segmentation: bool = False
    outside: Outside | None = None


class Shown(_Order):
    """A picture has been shown: another may come."""

    do: Literal["shown"]
    number: int


Order = Annotated[Start | Simple | Speed | Drive | SetNoise | Watch | Shown, Field(discriminator="do")]
_ORDER: TypeAdapter[Order] = TypeAdapter(Order)


def read_order(text: str) -> Order:
    """Return what a browser asks.

    Raises:
        UsageError: It is no order.
    """
    try:
        return _ORDER.validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(map(str, first["loc"])) or "the order"
        raise UsageError(f"{where}: {first['msg'][0].lower()}{first['msg'][1:]}") from None
