"""Signals of a world file: numbers that change with time."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, ValidationError, model_validator

from mjsim.sentences import Sentence
from mjsim.world.ground import Model, fault, path_of, sentence
from mjsim.world.items.timeline.signal_kinds import (
    AnySignal,
    ChirpSignal,
    ConstantSignal,
    PulseSignal,
    RampSignal,
    RandomSignal,
    Read,
    SawtoothSignal,
    SineSignal,
    SquareSignal,
    StepSignal,
    TableSignal,
)

if TYPE_CHECKING:  # Imported where it is used: worlds without signals load faster.
    from numpy.random import Generator

    from mjsim.mechanics import TimeSignal


class Signal(Model):
    """A number that changes with time: exactly one of these keys."""

    constant: ConstantSignal | None = None
    """A constant value."""
    step: StepSignal | None = None
    """A jump from one value to another."""
    ramp: RampSignal | None = None
    """A linear ramp."""
    sine: SineSignal | None = None
    """A sine."""
    square: SquareSignal | None = None
    """A square wave."""
    sawtooth: SawtoothSignal | None = None
    """A sawtooth or triangle wave."""
    pulse: PulseSignal | None = None
    """A pulse."""
    chirp: ChirpSignal | None = None
    """A sine with changing frequency."""
    random: RandomSignal | None = None
    """Random values, from the seed of the run."""
    table: TableSignal | None = None
    """Values from a CSV file or a list of points."""

    @model_validator(mode="before")
    @classmethod
    def _one_kind(cls, keys: Any) -> Any:
        if isinstance(keys, Mapping):
            given = [key for key in cls.model_fields if keys.get(key) is not None]
            if len(given) > 1:
                raise fault(Sentence("a signal is of one kind; this one has {given}", " and ".join(given)), given[1])
            if not given and not set(keys) - set(cls.model_fields):
                kinds = ", ".join(cls.model_fields)
                raise fault(Sentence("a signal is one of {kinds}; write constant: {{value: 1}} or another", kinds))
        return keys

    @property
    def kind(self) -> str:
        """Its key: `step`, `ramp` and so on."""
        return next(key for key in type(self).model_fields if getattr(self, key) is not None)

    @property
    def shape(self) -> AnySignal:
        """The value of its key."""
        found: AnySignal = getattr(self, self.kind)
        return found

    def misfit(self, *, angle: bool) -> tuple[str, tuple[str, ...]] | None:
        """Return why it cannot drive an angle, or another quantity: a message and the path of the value."""
        given = self.shape.in_degrees
        if given is None or given == angle:
            return None
        key = next(key for key in self.shape.given() if key.endswith("_deg") == given)
        right = f"{key}_deg" if angle else key.removesuffix("_deg")
        statement = "this is an angle, in degrees" if angle else "this is not an angle"
        return Sentence("{statement}; write {right} for {key}", statement, right, key), (self.kind, key)

    def made(self, read: Read, rng: "Generator | None" = None, *, angle: bool = False) -> "TimeSignal":
        """Return the signal, with its value and derivatives at any time.

        Args:
            read: Returns the file of a table, such as `World.read_asset`.
            rng: Random generator of a random signal; by default one with a fixed seed.
            angle: Whether it drives an angle; its values are then in radians.

        Raises:
            ValueError: Its keys do not match `angle`, or its file is missing.
        """
        if (wrong := self.misfit(angle=angle)) is not None:
            raise ValueError(wrong[0])
        return self.shape.made(read, rng, angle=angle)


def signal_of(keys: Mapping[str, Any], *, angle: bool = False, rng: "Generator | None" = None) -> "TimeSignal":
    """Return a signal from its keys in a world file; tables must be given as points, not files.

    Args:
        keys: Such as {"sine": {"amplitude": 0.3, "frequency_hz": 0.5}}.
        angle: Whether it is an angle or its rate: keys then end in _deg, and values are in radians.
        rng: Generator for a random signal.

    Raises:
        ValueError: A key is invalid; the message says which.
    """
    if not isinstance(keys, Mapping):
        raise ValueError(
            Sentence("a signal is {given}; it must be a mapping, such as {{'constant': 0.3}}", str(keys)[:60])
        )
    try:
        signal = Signal.model_validate(keys)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        path = path_of(first)
        place = "".join(f"{step}: " for step in path[:1])
        raise ValueError(place + sentence(first, path, Signal)) from None
    return signal.made(_no_file, rng, angle=angle)


def _no_file(name: str) -> bytes:
    raise ValueError(Sentence("file '{name}' cannot be read here; give the table's points instead", name))


def table_files(part: Any) -> Iterator[str]:
    """Yield the files of all tables in a part of a world, nested items included."""
    if isinstance(part, TableSignal):
        if part.file is not None:
            yield part.file
    elif isinstance(part, BaseModel):
        for key in type(part).model_fields:
            yield from table_files(getattr(part, key))
    elif isinstance(part, (tuple, list)):
        for item in part:
            yield from table_files(item)
    elif isinstance(part, Mapping):
        for item in part.values():
            yield from table_files(item)
