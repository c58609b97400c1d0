"""Random changes that turn valid files into broken ones."""

import bz2
import gzip
import lzma
import re
import struct
import zlib
from collections.abc import Iterator
from random import Random

Files = dict[str, bytes]
"""Path in a folder -> content; the first is the one that is read, and names the others."""
SIGNATURE = b"\x89PNG\r\n\x1a\n"
NUMBER, VALUE = re.compile(rb"[-+]?\d+(?:\.\d+)?"), re.compile(rb'"([^"]*)"|[ <](\w+)[= />]')
WILD = (
    *(b"", b"0", b"-1", b"1e9", b"1e308", b"-1e-308", b"5e-324", b"nan", b"inf", b"9" * 30, b"4294967295", b"1 2 3"),
    *(b"a", b"..", b"../up", b"/etc/passwd", b"/dev/zero", b"\xff", b"\xff\xfe", b"\x00", b"#", b'"', b"\r", b",,,,"),
    *(b"[" * 60, b"&a *a", b"&amp;", b"&x;", b"<!DOCTYPE a>", b"<x>", b"</x>", b"<geom/>", b"<body>", b"</body>"),
    *(b"mesh", b"sphere", b"capsule", b"plane", b"hfield", b"free", b"true", b"part.xml", b"<frame>", b"$(", b"${"),
    b'<joint type="free"/>',
)
"""Replacements for numbers, values and names."""
SIZES = (b"\xff" * 4, b"\x00" * 4, b"\xff\xff\xff\x7f", b"\x00\x00\x00\x80", b"\x01\x00\x00\x00", b"\x00\xca\x9a\x3b")
"""Replacements for four bytes that may be a size."""
PACKERS = (gzip.compress, lzma.compress, bz2.compress)


def changed_files(files: Files, rng: Random) -> Files:
    """Return files with one or two changed, or one of several removed."""
    names = [rng.choice(list(files)) for _ in range(rng.choice((1, 1, 2)))]
    new = files | {name: changed(files[name], rng) for name in names}
    return {name: data for name, data in new.items() if name != names[0] or len(new) == 1 or rng.random() > 0.02}


def changed(data: bytes, rng: Random) -> bytes:
    """Return a file with a few changes: those of a PNG file mostly below its checksums."""
    if data.startswith(SIGNATURE) and rng.random() < 0.8:
        return _changed_png(data, rng)
    is_text = b"\x00" not in data[:200]
    for _ in range(rng.choice((1, 1, 1, 2, 3, 6))):
        data = _with_word(data, rng) if is_text and rng.random() < 0.7 else _with_bytes(data, rng)
    return rng.choice(PACKERS)(data)[: rng.choice((None, None, -9))] if rng.random() < 0.02 else data


def _with_word(data: bytes, rng: Random) -> bytes:
    """Return a text with a number, or a value or name of XML, replaced."""
    pattern = rng.choice((NUMBER, VALUE))
    places = [each.span(each.lastindex or 0) for each in pattern.finditer(data)] or [(0, 0)]
    (start, end), (other, last) = rng.choice(places), rng.choice(places)
    return data[:start] + rng.choice((rng.choice(WILD), rng.choice(WILD), data[other:last])) + data[end:]


def _with_bytes(data: bytes, rng: Random) -> bytes:
    """Return a file with bytes changed, sizes randomised, or a piece removed, doubled or overwritten."""
    at, length = rng.randrange(len(data) + 1), rng.choice((1, 1, 4, 8, 40, 400))
    piece = rng.randrange(len(data) + 1)
    return rng.choice(
        (
            data[:at] + bytes([rng.randrange(256)]) + data[at + 1 :],
            data[:at] + rng.choice(SIZES) + data[at + 4 :],
            data[:at] + rng.choice(SIZES) + bytes(4) + data[at + 8 :],
            data[:at] + data[at + length :],
            data[:at] + data[piece : piece + length] + data[at:],
            data[:at] + data[piece : piece + length] + data[at + length :],
            data[:at] if rng.random() < 0.3 else data[:at] + rng.choice(WILD) + data[at:],
        )
    )


def _changed_png(data: bytes, rng: Random) -> bytes:
    """Return a PNG file in which a chunk or the pixels are changed, with correct checksums."""
    chunks = list(_chunks_of(data))
    at = rng.randrange(len(chunks))
    kind, content = chunks[at]
    if kind == b"IDAT" and rng.random() < 0.8:
        pixels = zlib.decompress(b"".join(part for name, part in chunks if name == b"IDAT"))
        chunks = [each for each in chunks if each[0] != b"IDAT"]
        chunks.insert(-1, (b"IDAT", zlib.compress(_with_bytes(pixels, rng), 1)))
    else:
        chunks[at] = kind, _with_bytes(content, rng)
    return SIGNATURE + b"".join(
        struct.pack(">I", len(part)) + name + part + struct.pack(">I", zlib.crc32(name + part)) for name, part in chunks
    )


def _chunks_of(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Yield kind and content of the chunks of a whole PNG file."""
    place = len(SIGNATURE)
    while place < len(data):
        length, kind = struct.unpack(">I4s", data[place : place + 8])
        yield kind, data[place + 8 : place + 8 + length]
        place += 12 + length
