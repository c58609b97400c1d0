"""How `mjsim run` drives a world: time, seed, and the modules of each robot."""

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import ConfigDict, Discriminator, Field, Tag, model_validator

from mjsim.world.base import PHYSICS_STEP, USE_PATTERN, Model, Name, fault
from mjsim.world.events import Event


class Use(Model):
    """A class of the user's own; the keys beside `use` are its keyword arguments."""

    model_config = ConfigDict(extra="allow")

    use: Annotated[str, Field(pattern=USE_PATTERN, max_length=256)]
    """'dotted.module:Class', or 'file.py:Class' beside the world file."""

    def arguments(self) -> dict[str, Any]:
        """Return the keyword arguments of the class."""
        return dict(self.model_extra or {})


def _kind_of_avoidance(value: object) -> str:
    return "<use>" if isinstance(value, (dict, Use)) else "<bool>"


class Modules(Model):
    """The modules of one robot; without an estimator dead reckoning, without a navigator it stands still."""

    observer: Use | None = None
    """Turns pictures and scans into sightings."""
    estimator: Use | None = None
    """Estimates the pose, and a map if it likes."""
    navigator: Use | None = None
    """Decides where to go."""
    avoidance: Annotated[
        Annotated[bool, Tag("<bool>")] | Annotated[Use, Tag("<use>")], Discriminator(_kind_of_avoidance)
    ] = False
    """Whether obstacles are avoided, or the user's own class that does."""
    push: bool = False
    """Whether it may press on against what it touches, to push a door open or a thing away; else a bump stops it."""


class View(Model):
    """What the video and the live view show."""

    follow: Literal["truth", "estimate", "nothing"] = "truth"
    """Whom the close-up follows."""
    sightings: bool = True
    """Lines to what is seen now."""
    scans: bool = True
    """Where the beams of lidars meet something."""
    ellipses: bool = True
    """Regions that hold the truth with 95 % probability."""
    trails: bool = True
    """Where the robot was, and where it thought it was."""
    quality: Literal["normal", "high"] = "normal"
    """Of views from outside in videos: high adds shadows, reflections and multisampling."""


def whole_steps(rate_hz: float) -> bool:
    """Return whether a tick at this rate is a whole number of physics steps."""
    steps = 1.0 / (rate_hz * PHYSICS_STEP)
    return steps > 0.5 and abs(steps - round(steps)) < 1e-9


def nearest_divisor(fast_hz: float, wanted_hz: float) -> float:
    """Return the rate nearest to one that is wanted, of those that divide a faster rate [Hz]."""
    times = max(math.floor(fast_hz / wanted_hz), 1)
    return min((fast_hz / times, fast_hz / (times + 1)), key=lambda rate: abs(rate - wanted_hz))


class Run(Model):
    """One run of this world."""

    seconds: Annotated[float, Field(gt=0, le=1e6)] = 60.0
    """How long, simulated [s]."""
    rate_hz: Annotated[float, Field(gt=0, le=250)] = 25.0
    """Ticks of the loop a second; a tick is a whole number of 4 ms physics steps."""
    seed: Annotated[int, Field(ge=0, lt=2**63)] = 1
    """Of all chance in the run."""
    map: Literal["unknown", "known"] = "unknown"
    """Known: modules get the map and where the beacons hang."""
    view: View = View()
    """What the video and the live view show."""
    drivers: Annotated[Mapping[Name, Modules], Field(strict=False)] = {}
    """The modules of each robot, by its name."""
    events: Annotated[tuple[Event, ...], Field(strict=False, max_length=10_000)] = ()
    """What happens when."""

    @model_validator(mode="after")
    def _tick_is_whole(self) -> Self:
        if not whole_steps(self.rate_hz):
            nearest = nearest_divisor(1.0 / PHYSICS_STEP, self.rate_hz)
            raise fault(
                f"rate_hz is {self.rate_hz:g} Hz; a tick must be a whole number of {PHYSICS_STEP * 1e3:g} ms steps,"
                f" the nearest rate is {nearest:g} Hz",
                "rate_hz",
            )
        return self

    @property
    def steps_per_tick(self) -> int:
        """Physics steps in one tick."""
        return round(1.0 / (self.rate_hz * PHYSICS_STEP))
