"""The kinds of signals, each with its keys.

Every quantity has two keys, such as `amplitude` and `amplitude_deg`: the second one is for angles and their rates. What
the signal drives determines which of the two is used.
"""

import math
from abc import abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self, TypeVar

from pydantic import (
    Discriminator,
    Field,
    Tag,
    ValidationInfo,
    create_model,
    model_validator,
)

from mjsim.sentences import Sentence
from mjsim.world.files import BUILT, read_asset, read_columns
from mjsim.world.ground import Model, Rate, fault

if TYPE_CHECKING:  # Imported where it is used: worlds without signals load faster.
    from numpy.random import Generator

    from mjsim.mechanics import TimeSignal

Value = Annotated[float, Field(ge=-1e9, le=1e9)]
Time = Annotated[float, Field(ge=0, le=1e6)]
Duration = Annotated[float, Field(gt=0, le=1e6)]
Share = Annotated[float, Field(ge=0, le=1)]
Column = Annotated[
    Annotated[str, Field(min_length=1, max_length=100), Tag("<name>")]
    | Annotated[int, Field(ge=1, le=1000), Tag("<number>")],
    Discriminator(lambda value: "<name>" if isinstance(value, str) else "<number>"),
]
Row = Annotated[tuple[Value, ...], Field(strict=False, min_length=2, max_length=2)]
Points = Annotated[tuple[Row, ...], Field(strict=False, min_length=1, max_length=10_000)]
Read = Callable[[str], bytes]
"""Returns a file that a world refers to."""
M = TypeVar("M", bound="AnySignal")


class AnySignal(Model):
    """Base class of all signals: quantities with one of two keys each."""

    needs: ClassVar[tuple[str, ...]] = ()
    """Required quantities."""
    may_have: ClassVar[tuple[str, ...]] = ()

    @model_validator(mode="after")
    def _one_unit(self) -> Self:
        given = self.given()
        plain = next((key for key in given if not key.endswith("_deg")), None)
        degrees = next((key for key in given if key.endswith("_deg")), None)
        if plain is not None and degrees is not None:
            raise fault(
                Sentence(
                    "{plain} is not an angle, but {degrees} is; give all values with _deg, or none", plain, degrees
                ),
                plain,
            )
        for name in self.needs:
            if name not in given and f"{name}_deg" not in given:
                raise fault(Sentence("{name} is missing; add {name}, or {name}_deg for an angle", name))
        return self

    def given(self) -> list[str]:
        """Return the keys of its given quantities."""
        names = (*self.needs, *self.may_have)
        return [key for name in names for key in (name, f"{name}_deg") if getattr(self, key) is not None]

    @property
    def in_degrees(self) -> bool | None:
        """Whether its values are angles; None if its keys do not show it."""
        given = self.given()
        return given[0].endswith("_deg") if given else None

    def quantity(self, name: str) -> float:
        """Return a quantity, 0 by default; an angle in radians."""
        degrees, plain = getattr(self, f"{name}_deg"), getattr(self, name)
        return math.radians(degrees) if degrees is not None else plain or 0.0

    @abstractmethod
    def made(self, read: Read, rng: "Generator | None", *, angle: bool) -> "TimeSignal":
        """Return the signal; values of angles are in radians."""


def _with_from(kind: type[M]) -> type[M]:
    """Add the key `from`, which is a reserved word in Python."""
    text = "Value at the start; 0 unless given."
    extra: Any = {"from": (Value | None, Field(default=None, description=text))}
    return create_model(kind.__name__, __base__=kind, __module__=kind.__module__, __doc__=kind.__doc__, **extra)


class ConstantSignal(AnySignal):
    """A constant value."""

    needs = ("value",)
    value: Value | None = None
    """The value."""
    value_deg: Value | None = None
    """The same for an angle."""

    def made(self, read: Read, rng: "Generator | None", *, angle: bool) -> "TimeSignal":
        """Return the signal."""
        from mjsim.mechanics import Constant

        return Constant(level=self.quantity("value"))


@_with_from
class StepSignal(AnySignal):
    """One value before a time, another one from then on."""

    needs, may_have = ("to",), ("from",)
    from_deg: Value | None = None
    """The value before, for an angle; default: 0."""
    to: Value | None = None
    """The value after."""
    to_deg: Value | None = None
    """The same for an angle."""
    at: Time = 0.0
    """Time [s]."""

    def made(self, read: Read, rng: "Generator | None", *, angle: bool) -> "TimeSignal":
        """Return the signal."""
        from mjsim.mechanics import StepChange

        return StepChange(before=self.quantity("from"), after=self.quantity("to"), when=self.at)


@_with_from
class RampSignal(AnySignal):
    """A linear ramp, constant before the start and after the end."""

    needs, may_have = ("slope",), ("from",)
    from_deg: Value | None = None
    """Initial value, for an angle; default: 0."""
    slope: Value | None = None
    """Change per second."""
    slope_deg: Value | None = None
    """The same for an angle."""
    start: Time = 0.0
    """Start time [s]."""
    seconds: Duration | None = None
    """Duration; default: unlimited [s]."""

    def made(self, read: Read, rng: "Generator | None", *, angle: bool) -> "TimeSignal":
        """Return the signal."""
        from mjsim.mechanics import Ramp

        seconds = math.inf if self.seconds is None else self.seconds
        return Ramp(before=self.quantity("from"), slope=self.quantity("slope"), start=self.start, seconds=seconds)


class _Swing(AnySignal):
    """A periodic signal about a mean."""

    needs, may_have = ("amplitude",), ("offset",)
    amplitude: Value | None = None
    """Amplitude from the mean to the peak."""
    amplitude_deg: Value | None = None
    """The same for an angle."""
    offset: Value | None = None
    """Mean; default: 0."""
    offset_deg: Value | None = None
    """The same for an angle."""


class _Periodic(_Swing):
    frequency_hz: Rate
    """Frequency [Hz]."""
    phase_deg: Annotated[float, Field(ge=-3600, le=3600)] = 0.0
    """Phase at time 0."""


class SineSignal(_Periodic):
    """A sine: offset + amplitude sin(2 pi frequency t + phase)."""

    def made(self, read: Read, rng: "Generator | None", *, angle: bool) -> "TimeSignal":
        """Return the signal."""
        from mjsim.mechanics import Sine

        amplitude, offset = self.quantity("amplitude"), self.quantity("offset")
        phase = math.radians(self.phase_deg)
        return Sine(amplitude=amplitude, frequency=self.frequency_hz, phase=phase, offset=offset)


class SquareSignal(_Periodic):
    """A square wave: up by the amplitude for a fraction of each period, then down by it."""

    duty: Share = 0.5
    """Fraction of the period for which it is up."""

    def made(self, read: Read, rng: "Generator | None", *, angle: bool) -> "TimeSignal":
        """Return the signal."""
        from mjsim.mechanics import Square

        amplitude, offset = self.quantity("amplitude"), self.quantity("offset")
        phase = math.radians(self.phase_deg)
        return Square(amplitude=amplitude, frequency=self.frequency_hz, phase=phase, offset=offset, duty=self.duty)


class SawtoothSignal(_Periodic):
    """Rises linearly from the lowest to the highest value, then falls."""

    rise: Share = 1.0
    """Fraction of the period in which it rises: 1 falls at once, 0.5 is a triangle."""

    def made(self, read: Read, rng: "Generator | None", *, angle: bool) -> "TimeSignal":
        """Return the signal."""
        from mjsim.mechanics import Sawtooth

        amplitude, offset = self.quantity("amplitude"), self.quantity("offset")
        phase = math.radians(self.phase_deg)
        return Sawtooth(amplitude=amplitude, frequency=self.frequency_hz, phase=phase, offset=offset, rise=self.rise)


class PulseSignal(_Swing):
    """Higher by the amplitude for some time, once or repeatedly."""

    at: Time = 0.0
    """Start of the first pulse [s]."""
    width: Duration
    """Duration of a pulse [s]."""
    every: Duration | None = None
    """Period; default: a single pulse [s]."""

    @model_validator(mode="after")
    def _fits_its_period(self) -> Self:
        if self.every is not None and self.width > self.every:
            raise fault(
                Sentence(
                    "width is {width:g} s; a pulse every {every:g} s is at most that long", self.width, self.every
                ),
                "width",
            )
        return self

    def made(self, read: Read, rng: "Generator | None", *, angle: bool) -> "TimeSignal":
        """Return the signal."""
        from mjsim.mechanics import Pulse

        amplitude, offset = self.quantity("amplitude"), self.quantity("offset")
        return Pulse(amplitude=amplitude, when=self.at, width=self.width, every=self.every, offset=offset)


class ChirpSignal(_Swing):
    """A sine whose frequency sweeps from one value to another, and stays there."""

    from_hz: Rate
    """Frequency at time 0 [Hz]."""
    to_hz: Rate
    """Frequency at the end of the sweep and afterwards [Hz]."""
    seconds: Duration
    """Duration of the sweep [s]."""
    sweep: Literal["linear", "exponential"] = "linear"
    """Course of the frequency."""

    def made(self, read: Read, rng: "Generator | None", *, angle: bool) -> "TimeSignal":
        """Return the signal."""
        from mjsim.mechanics import Chirp

        return Chirp(
            amplitude=self.quantity("amplitude"),
            first=self.from_hz,
            last=self.to_hz,
            seconds=self.seconds,
            offset=self.quantity("offset"),
            sweep=self.sweep,
        )


class RandomSignal(AnySignal):
    """Random values, each held for some time; seeded by the run."""

    needs, may_have = ("deviation",), ("offset",)
    deviation: Annotated[float, Field(ge=0, le=1e9)] | None = None
    """Standard deviation of the values."""
    deviation_deg: Annotated[float, Field(ge=0, le=1e9)] | None = None
    """The same for an angle."""
    offset: Value | None = None
    """Mean; default: 0."""
    offset_deg: Value | None = None
    """The same for an angle."""
    hold: Annotated[float, Field(ge=1e-4, le=1e6)]
    """Time for which each value is held [s]."""
    shape: Literal["normal", "uniform", "binary"] = "normal"
    """Distribution; binary has only two values, which suits identification."""

    def made(self, read: Read, rng: "Generator | None", *, angle: bool) -> "TimeSignal":
        """Return the signal."""
        from numpy.random import default_rng

        from mjsim.mechanics import Random

        rng = default_rng(0) if rng is None else rng
        deviation, offset = self.quantity("deviation"), self.quantity("offset")
        return Random(deviation=deviation, hold=self.hold, offset=offset, shape=self.shape, rng=rng)


class TableSignal(AnySignal):
    """Values at times, from a CSV file or a list; the first and the last are held outside."""

    may_have = ("column", "points")
    file: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """CSV file, beside the world file or in the assets; times must increase."""
    time: Column = 1
    """Column of times, by name or number from 1 [s]."""
    column: Column | None = None
    """Column of values, by name or number; default: the second."""
    column_deg: Column | None = None
    """The same for an angle in degrees."""
    points: Points | None = None
    """Points, [time, value] each, instead of a file."""
    points_deg: Points | None = None
    """The same for an angle, [time, value] each."""
    between: Literal["linear", "hold", "cubic"] = "linear"
    """Interpolation: linear, hold (the earlier value), or cubic (a cubic spline)."""
    repeat: bool = False
    """Whether it repeats; the last row then coincides with the first."""

    @model_validator(mode="after")
    def _one_source(self, info: ValidationInfo) -> Self:
        points = next((key for key in ("points", "points_deg") if getattr(self, key) is not None), None)
        if (self.file is None) == (points is None):
            have = "neither" if points is None else "both"
            raise fault(
                Sentence("a table has a file or points; this one has {have}", have), *(("file",) if self.file else ())
            )
        if points is not None and (self.column is not None or self.column_deg is not None):
            raise fault("columns are those of a file; leave them out beside points", points)
        source = (info.context or {}).get("source", BUILT)
        if points is not None or source is not BUILT:
            try:
                self.made(lambda name: read_asset(name, source), None, angle=bool(self.in_degrees))
            except ValueError as error:
                raise fault(str(error), points or "file") from None
        return self

    def made(self, read: Read, rng: "Generator | None", *, angle: bool) -> "TimeSignal":
        """Return the signal; a table that drives an angle must be in degrees."""
        import numpy as np

        from mjsim.mechanics import Table

        if self.file is not None:
            column = self.column_deg or self.column or 2
            rows = read_columns(read(self.file), self.file, (self.time, column))
        else:
            rows = np.array(self.points if self.points is not None else self.points_deg, dtype=float)
        scale = math.pi / 180.0 if (angle if self.in_degrees is None else self.in_degrees) else 1.0
        return Table(times=rows[:, 0], values=scale * rows[:, 1], between=self.between, repeat=self.repeat)
