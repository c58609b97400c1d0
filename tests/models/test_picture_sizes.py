"""Size and orientation of a picture from its header: those of the decoded picture, for every form of file."""

import struct
import zlib

import numpy as np
import pytest

from mjsim.bench.odd_pictures import encoded, odd_pictures
from mjsim.models import picture_size, read_picture, shown_size
from mjsim.record.drawn.map import map_update
from mjsim.world import Source, parse_world

BENT = np.random.default_rng(1).integers(0, 255, (8, 12, 3), dtype=np.uint8)
"""A picture without symmetry."""
OTHER_DATA = b"\xff\xe1\x00\x10http://ns.ado\0"
ODD = odd_pictures()


def exif(orientation: int, order: str = "<") -> bytes:
    width = struct.pack(f"{order}HHII", 256, 4, 1, 77)
    turned = struct.pack(f"{order}HHIHH", 274, 3, 1, orientation, 0)
    return (b"II" if order == "<" else b"MM") + struct.pack(f"{order}HIH", 42, 8, 2) + width + turned + bytes(4)


def jpeg_with(tiff: bytes) -> bytes:
    plain, head = encoded(".jpg", BENT), b"Exif\0\0" + tiff
    return plain[:2] + OTHER_DATA + b"\xff\xe1" + struct.pack(">H", len(head) + 2) + head + plain[2:]


def png_with(tiff: bytes, pixels: np.ndarray = BENT) -> bytes:
    plain = encoded(".png", pixels)
    return (
        plain[:-12]
        + struct.pack(">I", len(tiff))
        + b"eXIf"
        + tiff
        + struct.pack(">I", zlib.crc32(b"eXIf" + tiff))
        + plain[-12:]
    )


@pytest.mark.parametrize("name", sorted(ODD))
def test_the_size_in_the_head_is_that_of_the_decoded_picture(name: str):
    rows, columns = read_picture(ODD[name]).shape[:2]
    assert shown_size(ODD[name]) == (columns, rows)


@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize("orientation", range(10))
def test_a_turned_picture_has_the_size_in_which_it_is_shown(orientation: int, order: str):
    tiff = exif(orientation, order)
    opaque = np.dstack([BENT, np.full(BENT.shape[:2], 255, dtype=np.uint8)])
    for data in (jpeg_with(tiff), png_with(tiff), png_with(tiff, opaque)):
        rows, columns = read_picture(data).shape[:2]
        assert shown_size(data) == (columns, rows)
        assert (rows < columns) == (orientation not in (5, 6, 7, 8))
    # Decoded in two ways: by OpenCV with its orientation, and with transparency and turned by mjsim.
    np.testing.assert_array_equal(read_picture(png_with(tiff, opaque)), read_picture(png_with(tiff)))


@pytest.mark.parametrize("tiff", [b"", b"II", b"II*\0\xff\xff\xff\xff", b"XX*\0" + exif(6)[4:], exif(6)[:20]])
def test_damaged_exif_data_leave_a_picture_upright(tiff: bytes):
    assert shown_size(jpeg_with(tiff)) == picture_size(jpeg_with(tiff)) == (12, 8)
    assert read_picture(jpeg_with(tiff)).shape == (8, 12, 3)


@pytest.mark.parametrize("name", ["8x6.png", "9x15.png", "1000x1.png", "turned.jpg", "large.jpg"])
def test_a_picture_in_the_map_has_its_own_shape(name: str):
    text = f"mjsim: 1\nbeacons: [{{name: mine, at: [0, 0], image: {name}, width: 0.6}}]\n"
    world = parse_world(text, source=Source(attached={name: ODD[name]}))
    rows, columns = read_picture(ODD[name]).shape[:2]
    # A message holds its numbers as doubles.
    assert np.float64(0.6 * rows / columns).tobytes() in map_update(world, {name: ODD[name]}).encode()
