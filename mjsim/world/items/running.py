"""Settings of a run: duration, seed, and the modules of each robot."""

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import ConfigDict, Discriminator, Field, Tag, model_validator

from mjsim.errors import UsageError
from mjsim.sentences import Sentence
from mjsim.world.ground import USE_PATTERN, Model, Name, Rate, composed, fault
from mjsim.world.items.timeline import WorldEvent

MAX_SECONDS = 1e6
"""Maximum duration in a world file [s]."""
MAX_GIVEN_SECONDS = 1e8
"""Maximum duration that a command or a program gives: a bridge has no end [s]."""


class Use(Model):
    """A module; the other keys beside `use` are its keyword arguments, or options."""

    model_config = ConfigDict(extra="allow")

    use: Annotated[str, Field(pattern=USE_PATTERN, max_length=256, examples=["my_module.py:MyClass"])]
    """'dotted.module:Class', or, beside the world file, 'file.py:Class', 'file.m' (Octave), 'exec:./program --flag'."""

    def arguments(self) -> dict[str, Any]:
        """Return the keyword arguments of the class; texts are composed, as the names are that they may refer to."""
        given = self.model_extra or {}
        return {key: composed(value) if isinstance(value, str) else value for key, value in given.items()}


class Control(Use):
    """A controller of a balancing base or an arm; other keys are arguments of its class."""

    rate_hz: Rate = 250.0
    """Rate of calls between ticks; the period must be a whole number of physics steps."""
    latency: Annotated[int, Field(ge=0, le=1000)] = 0
    """Delay from sensing to actuation, in physics steps."""


def _kind_of_avoidance(value: object) -> str:
    return "<use>" if isinstance(value, (dict, Use)) else "<bool>"


class Modules(Model):
    """The modules of a robot; without an estimator it dead reckons, without a navigator it stands still."""

    observer: Use | None = None
    """Turns pictures and scans into sightings."""
    estimator: Use | None = None
    """Estimates the pose, and optionally a map."""
    navigator: Use | None = None
    """Decides where to go."""
    avoidance: Annotated[
        Annotated[bool, Tag("<bool>")] | Annotated[Use, Tag("<use>")], Discriminator(_kind_of_avoidance)
    ] = False
    """Whether to avoid obstacles, or your own avoidance module."""
    controllers: Annotated[Mapping[Name, Control], Field(strict=False)] = {}
    """Controllers that set motor torques between ticks, by part: `drive` of a balancing base, or an arm."""
    push: bool = False
    """Whether it may keep pushing against doors and movable objects; otherwise a bump stops it."""


class View(Model):
    """Contents of the video and the live view."""

    follow: Literal["truth", "estimate", "nothing"] = "truth"
    """What the close-up follows."""
    sightings: bool = True
    """Whether to show lines to sighted beacons."""
    scans: bool = True
    """Whether to show the points of lidar scans."""
    ellipses: bool = True
    """Whether to show 95 % confidence ellipses."""
    trails: bool = True
    """Whether to show true and estimated paths."""
    quality: Literal["normal", "high"] = "normal"
    """Quality of views from outside in videos: high adds shadows, reflections and multisampling."""


def whole_steps(rate_hz: float, step: float) -> bool:
    """Return whether a period at this rate is a whole number of physics steps."""
    steps = 1.0 / (rate_hz * step)
    return steps > 0.5 and abs(steps - round(steps)) < 1e-9


def step_misfit(label: str, rate_hz: float, step: float) -> str | None:
    """Return why a period at this rate is not a whole number of physics steps, as a message, or None."""
    if whole_steps(rate_hz, step):
        return None
    nearest = nearest_divisor(1.0 / step, rate_hz)
    return Sentence(
        "rate_hz is {rate_hz:g} Hz; {label} must be a whole number of {step:g} ms steps, the nearest"
        " rate is {nearest:g} Hz",
        *(rate_hz, label, step * 1e3, nearest),
    )


def nearest_divisor(fast_hz: float, requested_hz: float) -> float:
    """Return the rate nearest to a requested one that divides a faster rate [Hz]."""
    times = max(math.floor(fast_hz / requested_hz), 1)
    return min((fast_hz / times, fast_hz / (times + 1)), key=lambda rate: abs(rate - requested_hz))


class Run(Model):
    """Settings of a run of this world."""

    seconds: Annotated[float, Field(gt=0, le=MAX_SECONDS)] = 60.0
    """Duration, in simulated time [s]."""
    rate_hz: Annotated[float, Field(gt=0, le=1000)] = 25.0
    """Ticks per second; a tick is a whole number of physics steps."""
    step_ms: Literal[1, 2, 4] = 4
    """Physics time step [ms]; ticks and IMU readings take a whole number of steps."""
    seed: Annotated[int, Field(ge=0, lt=2**63)] = 1
    """Seed of all random numbers of the run."""
    map: Literal["unknown", "known"] = "unknown"
    """known: modules get the map and the positions of the beacons."""
    view: View = View()
    """Contents of the video and the live view."""
    drivers: Annotated[Mapping[Name, Modules], Field(strict=False)] = {}
    """Modules by the name of the robot."""
    events: Annotated[tuple[WorldEvent, ...], Field(strict=False, max_length=10_000)] = ()
    """Events during the run."""

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

    def ticks(self, seconds: float | None = None, *, of: str = "a run") -> int:
        """Return the number of ticks in a duration [s], by default that of the run.

        Raises:
            UsageError: It is shorter than a tick, or too long.
        """
        seconds = self.seconds if seconds is None else seconds
        if not 0.5 < seconds * self.rate_hz <= MAX_GIVEN_SECONDS * self.rate_hz:
            most = "" if seconds < 1.0 else Sentence(", and at most {max_given_seconds:g} s", MAX_GIVEN_SECONDS)
            raise UsageError(
                Sentence(
                    "seconds is {seconds:g}; {of} has at least one tick of {rate_hz:g} s{most}",
                    *(seconds, of, 1 / self.rate_hz, most),
                )
            )
        return round(seconds * self.rate_hz)
