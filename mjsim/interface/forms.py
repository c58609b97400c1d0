"""How readings are written: declared once, beside each of their fields.

The type of a field says most; `Annotated[TYPE, Form(...)]` adds what it cannot. Recordings, tables, trees for programs
and Octave, logs on another clock and arrays for learning follow from these declarations. A field without a `Form` is in
no file, such as the pixels of a picture.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields, is_dataclass, replace
from functools import cache
from types import NoneType
from typing import Annotated, Any, TypeVar, cast, get_args, get_origin, get_type_hints

import numpy as np

from mjsim.geometry import Array

_T = TypeVar("_T")
ReadingType = Any
"""A class of readings; `type[Any]` is not hashable for type checkers."""


@dataclass(frozen=True, slots=True)
class Form:
    """Properties of a field that its type does not state."""

    about: str
    """Meaning, unit and frame, for schemas."""
    shape: tuple[int, ...] = (-1,)
    """Shape of an array; -1 for a size that varies."""
    packed: str = ""
    """NumPy type of an array that recordings hold as base64; '' for a list of numbers."""
    names: str = ""
    """Key under which recordings list the names of a mapping; its numbers have the key of the field."""
    bounds: tuple[float, float] | None = None
    """Lowest and highest value, for arrays of fixed bounds."""
    is_fixed: bool = False
    """Whether it is a property of the sensor, equal in all readings."""
    is_distance: bool = False
    """Whether +infinity, which JSON lacks, means that nothing is near."""


CLOCK_TIME = "time by the robot's clock [s]"
"""Marks a field that is such a time, whether it is in files or not."""
Stamp = Annotated[float, Form("When it was taken, simulated time [s]"), CLOCK_TIME]
"""When a reading was taken [s]."""


@dataclass(frozen=True, slots=True)
class FormField:
    """A field of a reading, or of an observation."""

    name: str
    kind: Any
    """Its type; if it may be None, that of its other values."""
    form: Form | None
    """None for a field that is in no file."""
    is_time: bool
    is_optional: bool
    """Whether it may be None; then it is left out."""
    is_required: bool
    """Whether it has no default."""

    @property
    def item(self) -> ReadingType:
        """Type of its items; its own type if it holds a single value."""
        inner = [each for each in get_args(self.kind) if each is not Ellipsis]
        return inner[-1] if inner else self.kind

    @property
    def has_readings(self) -> bool:
        """Whether it holds a reading, or several."""
        return is_dataclass(self.item)

    @property
    def is_mapping(self) -> bool:
        """Whether it is a mapping: values by names, such as readings by sensor."""
        return get_origin(self.kind) is Mapping

    @property
    def is_tuple(self) -> bool:
        """Whether it is a tuple."""
        return get_origin(self.kind) is tuple

    @property
    def is_batch(self) -> bool:
        """Whether sensors give several readings per tick; in files each has its sensor's name beside its numbers."""
        return (
            self.is_tuple
            and self.has_readings
            and any(each.name == "name" and not each.form for each in all_fields(self.item))
        )


@cache
def all_fields(kind: ReadingType) -> tuple[FormField, ...]:
    """Return all fields of a class, in order."""
    hints = get_type_hints(kind, include_extras=True)
    return tuple(
        _part(each.name, hints[each.name], is_required=each.default is MISSING and each.default_factory is MISSING)
        for each in fields(kind)
    )


@cache
def form_fields(kind: ReadingType) -> tuple[tuple[FormField, Form], ...]:
    """Return the fields of a class that are in files, with their forms, in order."""
    return tuple((part, part.form) for part in all_fields(kind) if part.form is not None)


def _part(name: str, hint: Any, *, is_required: bool) -> FormField:
    kind, *marks = get_args(hint) if get_origin(hint) is Annotated else (hint,)
    inner = [each for each in get_args(kind) if each is not NoneType]
    optional = NoneType in get_args(kind)
    form = next((mark for mark in marks if isinstance(mark, Form)), None)
    return FormField(name, inner[0] if optional else kind, form, CLOCK_TIME in marks, optional, is_required)


def named(readings: Any) -> Iterable[tuple[str, Any]]:
    """Return the readings in a field of an observation with the names of their sensors."""
    return readings.items() if isinstance(readings, Mapping) else ((each.name, each) for each in readings)


def width_of(part: FormField, form: Form) -> int:
    """Return how many numbers a field of a batch holds."""
    return 1 if part.kind is float else math.prod(form.shape)


def batch_rows(kind: ReadingType, readings: Sequence[Any]) -> Array:
    """Return the numbers of readings of a batch, one row per reading, shape (n, numbers)."""
    columns = [
        np.array([getattr(each, part.name) for each in readings], dtype=float).reshape(
            len(readings), width_of(part, form)
        )
        for part, form in form_fields(kind)
    ]
    return np.column_stack(columns)


def retimed(value: _T, moved: Callable[[float], float]) -> _T:
    """Return a reading, or an observation, with its stamps moved to another clock; `time` of an observation stays."""
    kind: ReadingType = type(value)
    changed = {part.name: _moved(part, getattr(value, part.name), moved) for part in _timed(kind)}
    return cast(_T, replace(cast(Any, value), **changed))


@cache
def _timed(kind: ReadingType) -> tuple[FormField, ...]:
    """Return the fields that are times, or hold readings with times."""
    return tuple(part for part in all_fields(kind) if part.is_time or (part.has_readings and _timed(part.item)))


def _moved(part: FormField, value: Any, moved: Callable[[float], float]) -> Any:
    if part.is_time or value is None:
        return None if value is None else moved(value)
    if part.is_mapping:
        return {name: retimed(each, moved) for name, each in value.items()}
    return tuple(retimed(each, moved) for each in value) if part.is_tuple else retimed(value, moved)
