"""The size of a picture of any kind that a log may hold, without decoding it."""

import struct

import cv2
import numpy as np
import pytest

from mjsim.models import any_picture_size

WIDE = np.random.default_rng(0).integers(0, 255, (37, 311, 3), dtype=np.uint8)


@pytest.mark.parametrize("kind", [".png", ".jpg", ".bmp", ".tiff", ".webp"])
def test_the_head_tells_the_size_that_a_decoder_finds(kind):
    data = cv2.imencode(kind, WIDE)[1].tobytes()
    assert any_picture_size(data) == (311, 37)
    assert cv2.imdecode(np.frombuffer(data, dtype=np.uint8), cv2.IMREAD_COLOR).shape[:2] == (37, 311)


def test_the_size_of_a_lossy_webp_is_read():
    data = cv2.imencode(".webp", WIDE, [cv2.IMWRITE_WEBP_QUALITY, 80])[1].tobytes()
    assert data[12:16] == b"VP8 "
    assert any_picture_size(data) == (311, 37)


def test_the_canvas_size_of_an_extended_webp_is_read():
    data = b"RIFF\0\0\0\0WEBPVP8X" + struct.pack("<II", 10, 0) + b"\x36\x01\x00\x24\x00\x00"
    assert any_picture_size(data) == (311, 37)


@pytest.mark.parametrize(
    ("data", "why"),
    [
        (b"BM" + bytes(16) + struct.pack("<ii", 1 << 16, -(1 << 16)), "4295 megapixels"),
        (b"II*\0" + struct.pack("<IHHHIIHHII", 8, 2, 256, 4, 1, 1 << 20, 257, 4, 1, 1 << 20), "megapixels"),
        (b"MM\0*" + struct.pack(">IHHHIHH", 8, 1, 256, 3, 1, 5, 0), "5 x 0 pixels"),
        (b"RIFF\0\0\0\0WEBPVP8X" + bytes(8) + b"\xff" * 6, "megapixels"),
        (b"RIFF\0\0\0\0WEBPjunk", "damaged WebP"),
        (b"RIFF\0\0\0\0WEBPVP8 ", "truncated"),
        (b"BM", "truncated"),
        (b"II*\0\xff\xff\xff\xff", "truncated"),
        (b"", "not a PNG or JPEG"),
    ],
)
def test_what_is_too_large_or_cut_short_is_refused_without_decoding_it(data, why):
    with pytest.raises(ValueError, match=why):
        any_picture_size(data)
