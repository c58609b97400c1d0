"""The kinds of signals, each with its keys.

Every quantity has two keys, such as `amplitude` and `amplitude_deg`: the second one is for angles and their rates. What
a signal drives says which of the two it takes.
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

from mjsim.world.files import BUILT, read_asset, read_columns
from mjsim.world.ground import Model, Rate, fault

if TYPE_CHECKING:  # worlds without signals start without it
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
"""Returns a file that a world names."""
M = TypeVar("M", bound="AnySignal")


class AnySignal(Model):
    """What all kinds of signals share: quantities in one of two keys each."""

    needs: ClassVar[tuple[str, ...]] = ()
    """Quantities that must be given."""
    may_have: ClassVar[tuple[str, ...]] = ()

    @model_validator(mode="after")
    def _one_unit(self) -> Self:
        given = self.given()
        plain = next((key for key in given if not key.endswith("_deg")), None)
        degrees = next((key for key in given if key.endswith("_deg")), None)
        if plain is not None and degrees is not None:
            raise fault(f"{plain} is no angle and {degrees} is one; give all values with _deg, or none", plain)
        for name in self.needs:
            if name not in given and f"{name}_deg" not in given:
                raise fault(f"{name} is missing; add {name}, or {name}_deg for an angle")
        return self

    def given(self) -> list[str]:
        """Return the keys of its quantities that are given."""
        names = (*self.needs, *self.may_have)
        return [key for name in names for key in (name, f"{name}_deg") if getattr(self, key) is not None]

    @property
    def in_degrees(self) -> bool | None:
        """Whether its values are angles; None when its keys leave that open."""
        given = self.given()
        return given[0].endswith("_deg") if given else None

    def quantity(self, name: str) -> float:
        """Return a quantity, 0 unless given; an angle in radians."""
        degrees, plain = getattr(self, f"{name}_deg"), getattr(self, name)
        return math.radians(degrees) if degrees is not None else plain or 0.0

    @abstractmethod
    def made(self, read: Read, rng: "Generator | None", *, angle: bool) -> "TimeSignal":
        """Return the signal itself, its values in radians where they are angles."""


def _with_from(kind: type[M]) -> type[M]:
    """Add the key `from`, which no class can define as it is a word of Python's own."""
    text = "Value at the start; 0 unless given."
    extra: Any = {"from": (Value | None, Field(default=None, description=text))}
    return create_model(kind.__name__, __base__=kind, __module__=kind.__module__, __doc__=kind.__doc__, **extra)


class ConstantSignal(AnySignal):
    """Always the same value."""

    needs = ("value",)
    value: Value | None = None
    """The value."""
    value_deg: Value | None = None
    """The same of an angle."""

    def made(self, read: Read, rng: "Generator | None", *, angle: bool) -> "TimeSignal":
        """Return the signal itself."""
        from mjsim.mechanics import Constant

        return Constant(level=self.quantity("value"))


@_with_from
class StepSignal(AnySignal):
    """One value before a time, another from it on."""

    needs, may_have = ("to",), ("from",)
    from_deg: Value | None = None
    """The value before, of an angle; 0 unless given."""
    to: Value | None = None
    """The value after."""
    to_deg: Value | None = None
    """The same of an angle."""
    at: Time = 0.0
    """When [s]."""

    def made(self, read: Read, rng: "Generator | None", *, angle: bool) -> "TimeSignal":
        """Return the signal itself."""
        from mjsim.mechanics import StepChange

        return StepChange(before=self.quantity("from"), after=self.quantity("to"), when=self.at)


@_with_from
class RampSignal(AnySignal):
    """A straight line; the value stays as it is before the start and after the end."""

    needs, may_have = ("slope",), ("from",)
    from_deg: Value | None = None
    """The value at the start, of an angle; 0 unless given."""
    slope: Value | None = None
    """Change of the value in a second."""
    slope_deg: Value | None = None
    """The same of an angle."""
    start: Time = 0.0
    """When it begins [s]."""
    seconds: Duration | None = None
    """How long it goes on; for ever unless given [s]."""

    def made(self, read: Read, rng: "Generator | None", *, angle: bool) -> "TimeSignal":
        """Return the signal itself."""
        from mjsim.mechanics import Ramp

        seconds = math.inf if self.seconds is None else self.seconds
        return Ramp(before=self.quantity("from"), slope=self.quantity("slope"), start=self.start, seconds=seconds)


class _Swing(AnySignal):
    """What goes up and down about a mean."""

    needs, may_have = ("amplitude",), ("offset",)
    amplitude: Value | None = None
    """From the mean to the peak."""
    amplitude_deg: Value | None = None
    """The same of an angle."""
    offset: Value | None = None
    """The mean; 0 unless given."""
    offset_deg: Value | None = None
    """The same of an angle."""


class _Periodic(_Swing):
    frequency_hz: Rate
    """How often it repeats in a second."""
    phase_deg: Annotated[float, Field(ge=-3600, le=3600)] = 0.0
    """Where in its period it is at time 0; 360 is a whole period."""


class SineSignal(_Periodic):
    """A sine: offset + amplitude sin(2 pi frequency t + phase)."""

    def made(self, read: Read, rng: "Generator | None", *, angle: bool) -> "TimeSignal":
        """Return the signal itself."""
        from mjsim.mechanics import Sine

        amplitude, offset = self.quantity("amplitude"), self.quantity("offset")
        phase = math.radians(self.phase_deg)
        return Sine(amplitude=amplitude, frequency=self.frequency_hz, phase=phase, offset=offset)


class SquareSignal(_Periodic):
    """Up by the amplitude for a share of each period, then down by it."""

    duty: Share = 0.5
    """The share of a period for which it is up."""

    def made(self, read: Read, rng: "Generator | None", *, angle: bool) -> "TimeSignal":
        """Return the signal itself."""
        from mjsim.mechanics import Square

        amplitude, offset = self.quantity("amplitude"), self.quantity("offset")
        phase = math.radians(self.phase_deg)
        return Square(amplitude=amplitude, frequency=self.frequency_hz, phase=phase, offset=offset, duty=self.duty)


class SawtoothSignal(_Periodic):
    """Rises from the lowest to the highest value along a straight line, then falls."""

    rise: Share = 1.0
    """The share of a period in which it rises: 1 falls at once, 0.5 is a triangle."""

    def made(self, read: Read, rng: "Generator | None", *, angle: bool) -> "TimeSignal":
        """Return the signal itself."""
        from mjsim.mechanics import Sawtooth

        amplitude, offset = self.quantity("amplitude"), self.quantity("offset")
        phase = math.radians(self.phase_deg)
        return Sawtooth(amplitude=amplitude, frequency=self.frequency_hz, phase=phase, offset=offset, rise=self.rise)


class PulseSignal(_Swing):
    """Higher by the amplitude for a while, once or again and again."""

    at: Time = 0.0
    """When the first one begins [s]."""
    width: Duration
    """How long it lasts [s]."""
    every: Duration | None = None
    """Time from one to the next; a single one unless given [s]."""

    @model_validator(mode="after")
    def _fits_its_period(self) -> Self:
        if self.every is not None and self.width > self.every:
            raise fault(f"width is {self.width:g} s; a pulse every {self.every:g} s is at most that long", "width")
        return self

    def made(self, read: Read, rng: "Generator | None", *, angle: bool) -> "TimeSignal":
        """Return the signal itself."""
        from mjsim.mechanics import Pulse

        amplitude, offset = self.quantity("amplitude"), self.quantity("offset")
        return Pulse(amplitude=amplitude, when=self.at, width=self.width, every=self.every, offset=offset)


class ChirpSignal(_Swing):
    """A sine whose frequency goes from one to another, and stays there."""

    from_hz: Rate
    """Frequency at time 0."""
    to_hz: Rate
    """Frequency at the end of the sweep, and from then on."""
    seconds: Duration
    """How long the sweep takes [s]."""
    sweep: Literal["linear", "exponential"] = "linear"
    """How the frequency goes."""

    def made(self, read: Read, rng: "Generator | None", *, angle: bool) -> "TimeSignal":
        """Return the signal itself."""
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
    """A new value drawn now and then from the run's seed, and kept in between."""

    needs, may_have = ("deviation",), ("offset",)
    deviation: Annotated[float, Field(ge=0, le=1e9)] | None = None
    """Standard deviation of the values."""
    deviation_deg: Annotated[float, Field(ge=0, le=1e9)] | None = None
    """The same of an angle."""
    offset: Value | None = None
    """The mean; 0 unless given."""
    offset_deg: Value | None = None
    """The same of an angle."""
    hold: Annotated[float, Field(ge=1e-4, le=1e6)]
    """How long each value is kept [s]."""
    shape: Literal["normal", "uniform", "binary"] = "normal"
    """How they are distributed; binary takes two values only, as identification likes it."""

    def made(self, read: Read, rng: "Generator | None", *, angle: bool) -> "TimeSignal":
        """Return the signal itself."""
        from numpy.random import default_rng

        from mjsim.mechanics import Random

        rng = default_rng(0) if rng is None else rng
        deviation, offset = self.quantity("deviation"), self.quantity("offset")
        return Random(deviation=deviation, hold=self.hold, offset=offset, shape=self.shape, rng=rng)


class TableSignal(AnySignal):
    """Values at times, from a file of CSV or written out; the first and the last hold outside."""

    may_have = ("column", "points")
    file: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """CSV, looked for beside the world file, then in assets; its times increase."""
    time: Column = 1
    """The file's column of times, by name or by number from 1 [s]."""
    column: Column | None = None
    """The file's column of values, by name or by number; the second unless given."""
    column_deg: Column | None = None
    """The same of an angle in degrees."""
    points: Points | None = None
    """[time, value] each, in place of a file."""
    points_deg: Points | None = None
    """The same of an angle, [time, value] each."""
    between: Literal["linear", "hold", "cubic"] = "linear"
    """What is between two rows: a straight line, the value of the first, or a smooth curve (a cubic spline)."""
    repeat: bool = False
    """Whether it begins again when it is over; the last row then stands for the first."""

    @model_validator(mode="after")
    def _one_source(self, info: ValidationInfo) -> Self:
        points = next((key for key in ("points", "points_deg") if getattr(self, key) is not None), None)
        if (self.file is None) == (points is None):
            have = "neither" if points is None else "both"
            raise fault(f"a table has a file or points; this one has {have}", *(("file",) if self.file else ()))
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
        """Return the signal itself; a table that does not say it is in degrees where it drives an angle."""
        import numpy as np

        from mjsim.mechanics import Table

        if self.file is not None:
            column = self.column_deg or self.column or 2
            rows = read_columns(read(self.file), self.file, (self.time, column))
        else:
            rows = np.array(self.points if self.points is not None else self.points_deg, dtype=float)
        scale = math.pi / 180.0 if (angle if self.in_degrees is None else self.in_degrees) else 1.0
        return Table(times=rows[:, 0], values=scale * rows[:, 1], between=self.between, repeat=self.repeat)
