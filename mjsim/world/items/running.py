"""How `mjsim run` drives a world: time, seed, and the modules of each robot."""

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import ConfigDict, Discriminator, Field, Tag, model_validator

from mjsim.world.ground import USE_PATTERN, Model, Name, Rate, fault
from mjsim.world.items.events import WorldEvent


class Use(Model):
    """A module of the user's own; the keys beside `use` are its keyword arguments, or options."""

    model_config = ConfigDict(extra="allow")

    use: Annotated[str, Field(pattern=USE_PATTERN, max_length=256, examples=["my_module.py:MyClass"])]
    """'dotted.module:Class', or, beside the world file, 'file.py:Class', 'file.m' (Octave), 'exec:./program --flag'."""

    def arguments(self) -> dict[str, Any]:
        """Return the keyword arguments of the class."""
        return dict(self.model_extra or {})


class Control(Use):
    """A controller of a balancing base or an arm; the keys beside those named here are arguments of its class."""

    rate_hz: Rate = 250.0
    """How often it is asked between ticks; a period is a whole number of physics steps."""
    latency: Annotated[int, Field(ge=0, le=1000)] = 0
    """Physics steps from what it senses until its torques act."""


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
    controllers: Annotated[Mapping[Name, Control], Field(strict=False)] = {}
    """What drives motors with torques between ticks, by part: `drive` of a balancing base, or the name of an arm."""
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


def whole_steps(rate_hz: float, step: float) -> bool:
    """Return whether a period at this rate is a whole number of physics steps [s]."""
    steps = 1.0 / (rate_hz * step)
    return steps > 0.5 and abs(steps - round(steps)) < 1e-9


def step_misfit(what: str, rate_hz: float, step: float) -> str | None:
    """Return why a period at this rate is no whole number of physics steps [s], in a sentence; None when it is."""
    if whole_steps(rate_hz, step):
        return None
    nearest = nearest_divisor(1.0 / step, rate_hz)
    return (
        f"rate_hz is {rate_hz:g} Hz; {what} must be a whole number of {step * 1e3:g} ms steps,"
        f" the nearest rate is {nearest:g} Hz"
    )


def nearest_divisor(fast_hz: float, wanted_hz: float) -> float:
    """Return the rate nearest to one that is wanted, of those that divide a faster rate [Hz]."""
    times = max(math.floor(fast_hz / wanted_hz), 1)
    return min((fast_hz / times, fast_hz / (times + 1)), key=lambda rate: abs(rate - wanted_hz))


class Run(Model):
    """One run of this world."""

    seconds: Annotated[float, Field(gt=0, le=1e6)] = 60.0
    """How long, simulated [s]."""
    rate_hz: Annotated[float, Field(gt=0, le=1000)] = 25.0
    """Ticks of the loop a second; a tick is a whole number of physics steps."""
    step_ms: Literal[1, 2, 4] = 4
    """Period of the physics [ms]: 1, 2 or 4; ticks and the readings of an IMU take a whole number of steps."""
    seed: Annotated[int, Field(ge=0, lt=2**63)] = 1
    """Of all chance in the run."""
    map: Literal["unknown", "known"] = "unknown"
    """Known: modules get the map and where the beacons hang."""
    view: View = View()
    """What the video and the live view show."""
    drivers: Annotated[Mapping[Name, Modules], Field(strict=False)] = {}
    """The modules of each robot, by its name."""
    events: Annotated[tuple[WorldEvent, ...], Field(strict=False, max_length=10_000)] = ()
    """What happens when."""

    @model_validator(mode="after")
    def _tick_is_whole(self) -> Self:
        if (misfit := step_misfit("a tick", self.rate_hz, self.step)) is not None:
            raise fault(misfit, "rate_hz")
        return self

    @property
    def step(self) -> float:
        """Period of the physics [s]."""
        return self.step_ms / 1000

    @property
    def steps_per_tick(self) -> int:
        """Physics steps in one tick."""
        return round(1.0 / (self.rate_hz * self.step))
