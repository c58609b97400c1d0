"""Signals: numbers that change with time, with their first and second derivatives in closed form.

A signal has the unit of the quantity it drives: rad, m, N m and so on. At a jump the value is the one after it;
derivatives ignore jumps.

References:
    The shapes are those of Simulink's sources and of scipy.signal (square, sawtooth, chirp).
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike

from mjsim.geometry import Array
from mjsim.sentences import Sentence

if TYPE_CHECKING:  # Slow to load, and few signals need it.
    from scipy.interpolate import CubicSpline

JUMP_TOLERANCE = 1e-9
"""A time this close before a jump counts as after it, since times of steps have rounding errors [s, periods]."""


class TimeSignal(ABC):
    """A value as a function of time."""

    def value(self, time: ArrayLike) -> Array:
        """Return the values at times [s], with the same shape."""
        return self._at(np.asarray(time, dtype=float), 0)

    def rate(self, time: ArrayLike) -> Array:
        """Return the derivatives at times [s], with the same shape [1/s]."""
        return self._at(np.asarray(time, dtype=float), 1)

    def second(self, time: ArrayLike) -> Array:
        """Return the second derivatives at times [s], with the same shape [1/s^2]."""
        return self._at(np.asarray(time, dtype=float), 2)

    @property
    def jumps(self) -> bool:
        """Whether its value jumps, so that no joint with a mass can follow it."""
        return False

    @abstractmethod
    def _at(self, time: Array, order: int) -> Array:
        """Return the derivative of an order from 0 to 2."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Constant(TimeSignal):
    """A constant."""

    level: float

    def _at(self, time: Array, order: int) -> Array:
        return np.full(time.shape, self.level if order == 0 else 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class StepChange(TimeSignal):
    """One value before a time, another from then on."""

    before: float = 0.0
    after: float
    when: float = 0.0
    """[s]"""

    @property
    def jumps(self) -> bool:
        """Whether its value jumps."""
        return self.before != self.after

    def _at(self, time: Array, order: int) -> Array:
        levels = (self.before, self.after) if order == 0 else (0.0, 0.0)
        return np.where(time >= self.when - JUMP_TOLERANCE, levels[1], levels[0])


@dataclass(frozen=True, slots=True, kw_only=True)
class Ramp(TimeSignal):
    """A straight line between two times, constant before and after."""

    before: float = 0.0
    slope: float
    """[1/s]"""
    start: float = 0.0
    """[s]"""
    seconds: float = np.inf
    """Duration [s]."""

    def _at(self, time: Array, order: int) -> Array:
        since = time - self.start
        if order == 0:
            return np.asarray(self.before + self.slope * np.clip(since, 0.0, self.seconds))
        during = (since >= -JUMP_TOLERANCE) & (since < self.seconds - JUMP_TOLERANCE)
        return np.where(during, self.slope, 0.0) if order == 1 else np.zeros(time.shape)


@dataclass(frozen=True, slots=True, kw_only=True)
class Periodic(TimeSignal):
    """Base class of periodic signals."""

    amplitude: float
    frequency: float
    """[Hz]"""
    phase: float = 0.0
    """Phase at time 0 [rad]."""
    offset: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Sine(Periodic):
    """A sine about a mean."""

    def _at(self, time: Array, order: int) -> Array:
        speed = 2.0 * np.pi * self.frequency
        angle = speed * time + self.phase + order * 0.5 * np.pi
        return np.asarray(self.amplitude * speed**order * np.sin(angle) + (self.offset if order == 0 else 0.0))


@dataclass(frozen=True, slots=True, kw_only=True)
class Square(Periodic):
    """Offset + amplitude for the first part of each period, then offset - amplitude."""

    duty: float = 0.5
    """The high part of a period, 0 to 1."""

    @property
    def jumps(self) -> bool:
        """Whether its value jumps."""
        return self.amplitude != 0.0

    def _at(self, time: Array, order: int) -> Array:
        if order > 0:
            return np.zeros(time.shape)
        up = _share(time, self.frequency, self.phase) < self.duty
        return self.offset + self.amplitude * np.where(up, 1.0, -1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Sawtooth(Periodic):
    """Rises linearly during the first part of each period, then falls linearly; at phase 0 it starts to rise."""

    rise: float = 1.0
    """The rising part of a period, 0 to 1; 0.5 is a triangle."""

    @property
    def jumps(self) -> bool:
        """Whether its value jumps."""
        return self.amplitude != 0.0 and self.rise in (0.0, 1.0)

    def _at(self, time: Array, order: int) -> Array:
        share = _share(time, self.frequency, self.phase)
        fall = 1.0 - self.rise
        rising = share < self.rise
        if order == 2:
            return np.zeros(time.shape)
        if order == 1:
            up, down = self._slope(self.rise), -self._slope(fall)
            return np.where(rising, up, down)
        climbing = -1.0 + 2.0 * share / (self.rise or 1.0)
        falling = 1.0 - 2.0 * (share - self.rise) / (fall or 1.0)
        return self.offset + self.amplitude * np.where(rising, climbing, falling)

    def _slope(self, share: float) -> float:
        return 2.0 * self.amplitude * self.frequency / share if share else 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Pulse(TimeSignal):
    """A pulse, once or periodically."""

    amplitude: float
    when: float = 0.0
    """[s]"""
    width: float
    """[s]"""
    every: float | None = None
    """Time from one to the next [s]; None for a single one."""
    offset: float = 0.0

    @property
    def jumps(self) -> bool:
        """Whether its value jumps."""
        return self.amplitude != 0.0

    def _at(self, time: Array, order: int) -> Array:
        if order > 0:
            return np.zeros(time.shape)
        since = time - self.when + JUMP_TOLERANCE
        within = since if self.every is None else np.mod(since, self.every)
        return np.asarray(self.offset + self.amplitude * ((since >= 0.0) & (within < self.width)), dtype=float)


@dataclass(frozen=True, slots=True, kw_only=True)
class Chirp(TimeSignal):
    """A sine whose frequency changes from one value to another, and stays there; phase 0 at time 0."""

    amplitude: float
    first: float
    """Frequency at time 0 [Hz]."""
    last: float
    """Frequency from the end of the sweep on [Hz]."""
    seconds: float
    """Duration of the sweep [s]."""
    offset: float = 0.0
    sweep: Literal["linear", "exponential"] = "linear"

    def _at(self, time: Array, order: int) -> Array:
        angle, speed, change = self._phase(time)
        if order == 0:
            return np.asarray(self.offset + self.amplitude * np.sin(angle))
        if order == 1:
            return np.asarray(self.amplitude * speed * np.cos(angle))
        return np.asarray(self.amplitude * (change * np.cos(angle) - speed**2 * np.sin(angle)))

    def _phase(self, time: Array) -> tuple[Array, Array, Array]:
        """Return phase, its rate and its second derivative [rad, rad/s, rad/s^2]."""
        within = np.clip(time, 0.0, self.seconds)
        outside = time - within
        sweeping = outside == 0.0
        ratio = self.last / self.first
        turns: Array
        change: Array
        if self.sweep == "exponential" and abs(ratio - 1.0) > 1e-9:
            growth = float(np.log(ratio)) / self.seconds
            frequency = np.asarray(self.first * np.exp(growth * within))
            turns, change = (frequency - self.first) / growth, growth * frequency
        else:
            slope = (self.last - self.first) / self.seconds
            frequency = np.asarray(self.first + slope * within)
            turns, change = within * (self.first + 0.5 * slope * within), np.full(time.shape, slope)
        full = 2.0 * np.pi
        return full * (turns + frequency * outside), full * frequency, full * np.where(sweeping, change, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Random(TimeSignal):
    """A new random value at regular times, held in between; before time 0 the offset."""

    deviation: float
    """Standard deviation of the values about the offset."""
    hold: float
    """Time for which each value is held [s]."""
    offset: float = 0.0
    shape: Literal["normal", "uniform", "binary"] = "normal"
    rng: Generator
    """Its own random stream: the same stream gives the same signal, in whatever order times are requested."""
    _drawn: list[Array] = field(default_factory=lambda: [np.zeros(0)])

    @property
    def jumps(self) -> bool:
        """Whether its value jumps."""
        return self.deviation != 0.0

    def _at(self, time: Array, order: int) -> Array:
        if order > 0:
            return np.zeros(time.shape)
        number = np.floor(time / self.hold + JUMP_TOLERANCE).astype(np.int64)
        held = self._levels(int(number.max(initial=0)) + 1)[np.maximum(number, 0)]
        return self.offset + self.deviation * np.where(number >= 0, held, 0.0)

    def _levels(self, count: int) -> Array:
        """Return at least this many values of deviation 1; they are drawn in blocks, once each."""
        while len(self._drawn[0]) < count:
            self._drawn[0] = np.concatenate([self._drawn[0], self._block()])
        return self._drawn[0]

    def _block(self, size: int = 1024) -> Array:
        if self.shape == "normal":
            return np.asarray(self.rng.standard_normal(size))
        if self.shape == "uniform":
            return self.rng.uniform(-np.sqrt(3.0), np.sqrt(3.0), size)
        return np.asarray(np.where(self.rng.random(size) < 0.5, -1.0, 1.0), dtype=float)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Table(TimeSignal):
    """Values at times, interpolated; the first and the last apply outside."""

    times: Array
    """Increasing, shape (n,) [s]."""
    values: Array
    """Shape (n,)."""
    between: Literal["linear", "hold", "cubic"] = "linear"
    repeat: bool = False
    """Whether it repeats after the last time, which then coincides with the first."""
    _spline: "list[CubicSpline]" = field(default_factory=list)

    def __post_init__(self) -> None:
        """Check that the times increase."""
        if self.times.ndim != 1 or self.times.shape != self.values.shape or not len(self.times):
            raise ValueError(
                Sentence(
                    "times and values have shapes {shape} and {other_shape}; give (n,) each",
                    self.times.shape,
                    self.values.shape,
                )
            )
        if not (np.isfinite(self.times).all() and np.isfinite(self.values).all()):
            raise ValueError("times and values must be finite")
        if (np.diff(self.times) <= 0.0).any():
            row = int(np.argmax(np.diff(self.times) <= 0.0))
            raise ValueError(
                Sentence(
                    "time {times:g} follows {other_times:g}; times must increase", self.times[row + 1], self.times[row]
                )
            )
        if self.repeat and len(self.times) < 2:
            raise ValueError("a table of one time cannot repeat; give two or more")
        if self.between == "cubic" and len(self.times) > 1:
            from scipy.interpolate import CubicSpline

            closed = self.repeat and self.values[0] == self.values[-1]
            kind = "periodic" if closed else "natural"
            self._spline.append(CubicSpline(self.times, self.values, bc_type=kind))

    @property
    def jumps(self) -> bool:
        """Whether its value jumps."""
        steps = self.between == "hold" and bool((np.diff(self.values) != 0.0).any())
        return steps or (self.repeat and bool(self.values[0] != self.values[-1]))

    def _at(self, time: Array, order: int) -> Array:
        first, last = float(self.times[0]), float(self.times[-1])
        if len(self.times) == 1:
            return np.full(time.shape, self.values[0] if order == 0 else 0.0)
        if self.repeat:
            time = first + np.mod(time - first + JUMP_TOLERANCE, last - first)
        found = self._inside(np.clip(time, first, last), order)
        moving = (time >= first - JUMP_TOLERANCE) & (time < last - JUMP_TOLERANCE)
        return found if order == 0 else np.where(moving, found, 0.0)

    def _inside(self, time: Array, order: int) -> Array:
        if self._spline:
            return np.asarray(self._spline[0](time, order), dtype=float)
        row = np.searchsorted(self.times, time + JUMP_TOLERANCE, side="right") - 1
        if self.between == "hold":
            return np.asarray(self.values[row]) if order == 0 else np.zeros(time.shape)
        if order == 0:
            return np.asarray(np.interp(time, self.times, self.values))
        slopes = np.diff(self.values) / np.diff(self.times)
        return np.asarray(slopes[np.minimum(row, len(slopes) - 1)]) if order == 1 else np.zeros(time.shape)


def _share(time: Array, frequency: float, phase: float) -> Array:
    """Return the position of a signal within its period, from 0 to 1."""
    return np.asarray(np.mod(frequency * time + phase / (2.0 * np.pi) + JUMP_TOLERANCE, 1.0))
