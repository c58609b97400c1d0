"""Form of the values that a child hands back: JSON and the raw bytes of arrays. Reading it runs no code of the sender.

A message is the length of its head (8 bytes, little-endian), the head (JSON in ASCII), and buffers one after another:
the head has their lengths. Values that JSON lacks are objects in it with one key, which says their type.
"""

import json
import math
import struct
from collections.abc import Callable, Mapping, Sequence
from typing import IO, TYPE_CHECKING, Any, TypeAlias

from mjsim.sentences import Sentence

if TYPE_CHECKING:
    from numpy.typing import NDArray

Plain: TypeAlias = "bool | int | float | str | bytes | NDArray[Any] | Sequence[Plain] | Mapping[str, Plain] | None"
"""Types that a child may return."""
KINDS = "biuf"
"""Kinds of the numbers in arrays, as in `numpy.dtype.kind`: bool, int, unsigned and float."""
HEAD_DIVISOR = 16
"""A head has at most the limit of a message divided by this: in memory, JSON takes many times its length."""
_LENGTH = struct.Struct("<Q")


class WireError(Exception):
    """A message is invalid, truncated or too long."""


def send(file: IO[bytes], value: Plain) -> None:
    """Write a value.

    Raises:
        TypeError: It holds a type that cannot be sent.
    """
    buffers: list[memoryview | bytes] = []
    written = _written(value, buffers)
    head = json.dumps({"value": written, "buffers": [len(each) for each in buffers]}, separators=(",", ":")).encode()
    file.write(_LENGTH.pack(len(head)))
    file.write(head)
    for each in buffers:
        file.write(each)
    file.flush()


def receive(file: IO[bytes], *, limit: int) -> Any:
    """Return the next value.

    Args:
        file: Where it is read.
        limit: Maximum length of its buffers together; its head has a fraction of that [bytes].

    Raises:
        EOFError: The sender ended before the end of the message.
        WireError: It is not a message, or is too long.
    """
    (length,) = _LENGTH.unpack(_exactly(file, _LENGTH.size))
    if length > limit // HEAD_DIVISOR:
        raise WireError(f"a head of {length} bytes")
    try:
        head = json.loads(_exactly(file, length))
        sizes = [_size(each) for each in head["buffers"]]
        if sum(sizes) > limit:
            raise WireError(f"{sum(sizes)} bytes; {limit} were allowed")
        return _read(head["value"], [_exactly(file, size) for size in sizes])
    except (ValueError, TypeError, LookupError, RecursionError) as error:
        raise WireError(f"{type(error).__name__}: {error}") from error


def _written(value: Any, buffers: list[memoryview | bytes]) -> Any:
    """Return a value in its JSON form; the bytes of arrays are added to the buffers."""
    if isinstance(value, Sentence):
        return {"sentence": [value.template, _written(dict(value.values), buffers)]}
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, list):
        return [_written(each, buffers) for each in value]
    if isinstance(value, tuple):
        return {"tuple": [_written(each, buffers) for each in value]}
    if isinstance(value, Mapping):
        return {"dict": [[_written(key, buffers), _written(each, buffers)] for key, each in value.items()]}
    if isinstance(value, bytes):
        buffers.append(value)
        return {"bytes": len(buffers) - 1}
    if getattr(getattr(value, "dtype", None), "kind", None) in tuple(KINDS):
        return {"array": [_added(value, buffers), value.dtype.newbyteorder("<").str, list(value.shape)]}
    raise TypeError(f"a {type(value).__name__} cannot be handed back; make it text, numbers or an array")


def _added(array: Any, buffers: list[memoryview | bytes]) -> int:
    """Add the elements of an array to the buffers, in C order and little-endian; return the number of the buffer."""
    import numpy as np

    straight = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
    buffers.append(straight.reshape(-1).view(np.uint8).data if straight.size else b"")
    return len(buffers) - 1


def _read(value: Any, buffers: Sequence[bytearray]) -> Any:
    if isinstance(value, list):
        return [_read(each, buffers) for each in value]
    if not isinstance(value, dict):
        return value
    ((kind, content),) = value.items()
    return _READERS[kind](content, buffers)


def _sentence(content: Any, buffers: Sequence[bytearray]) -> Sentence:
    template, values = content
    read = _read(values, buffers)
    if not isinstance(template, str) or not all(isinstance(each, str) for pair in read.items() for each in pair):
        raise WireError("a sentence of other things than text")
    return Sentence.received(template, read)


def _array(content: Any, buffers: Sequence[bytearray]) -> Any:
    """Return an array, whose shape must be that of its buffer."""
    import numpy as np

    number, kind, shape = content
    dtype = np.dtype(str(kind))
    if dtype.kind not in KINDS or dtype.hasobject:
        raise WireError(f"an array of {kind!r:.40}")
    sides = [_size(side) for side in shape]
    data = buffers[_size(number)]
    if len(sides) > 32 or math.prod(sides) * dtype.itemsize != len(data):
        raise WireError(f"an array of {len(data)} bytes with the shape {sides!r:.60}")
    return np.frombuffer(data, dtype=dtype).reshape(sides).astype(dtype.newbyteorder("="), copy=False)


_READERS: Mapping[str, Callable[[Any, Sequence[bytearray]], Any]] = {
    "tuple": lambda content, buffers: tuple(_read(content, buffers)),
    "dict": lambda content, buffers: {_read(key, buffers): _read(each, buffers) for key, each in content},
    "bytes": lambda content, buffers: bytes(buffers[_size(content)]),
    "array": _array,
    "sentence": _sentence,
}


def _size(value: Any) -> int:
    if not isinstance(value, int) or value < 0:
        raise WireError(f"{value!r:.40} as a size")
    return value


def _exactly(file: IO[bytes], size: int) -> bytearray:
    """Return the next bytes.

    Raises:
        EOFError: There are fewer.
    """
    data = bytearray(size)
    view, place = memoryview(data), 0
    while place < size:
        count = file.readinto(view[place:])  # type: ignore[attr-defined]
        if not count:
            raise EOFError
        place += count
    return data
