"""Depth packed by RVL, and colour at half the size, as drivers of ROS send them."""

import struct

import cv2
import numpy as np
import pytest

from mjsim.logs.bags.rvl import unpack_rvl
from tests.bags import START, new_bag
from tests.real_logs import imported


def _packed(picture: np.ndarray) -> bytes:
    """Return a picture as the paper packs it: pixel by pixel, with numbers in groups of 3 bits."""
    nibbles: list[int] = []

    def put(number: int) -> None:
        while True:
            rest = number >> 3
            nibbles.append((number & 7) | (8 if rest else 0))
            number = rest
            if not number:
                return

    values, at, last = picture.ravel().tolist(), 0, 0
    while at < len(values):
        first = next((k for k in range(at, len(values)) if values[k]), len(values))
        end = next((k for k in range(first, len(values)) if not values[k]), len(values))
        put(first - at)
        put(end - first)
        for value in values[first:end]:
            put(((value - last) << 1) ^ ((value - last) >> 31))
            last = value
        at = end
    nibbles += [0] * (-len(nibbles) % 8)
    words = (
        sum(nibble << 28 - 4 * k for k, nibble in enumerate(nibbles[n : n + 8])) for n in range(0, len(nibbles), 8)
    )
    return struct.pack("<II", picture.shape[1], picture.shape[0]) + b"".join(struct.pack("<I", word) for word in words)


def _depth() -> np.ndarray:
    rng = np.random.default_rng(0)
    depth = rng.integers(0, 65536, (24, 32)).astype(np.uint16)
    depth[rng.uniform(size=depth.shape) < 0.4] = 0
    depth[10:] = np.arange(500, 500 + depth[10:].size).reshape(depth[10:].shape)
    return depth


def test_depth_packed_by_rvl_is_unpacked():
    for picture in (_depth(), np.zeros((3, 5), dtype=np.uint16), np.full((2, 2), 65535, dtype=np.uint16)):
        np.testing.assert_array_equal(unpack_rvl(_packed(picture)), picture)


def test_damaged_rvl_is_refused():
    packed = _packed(_depth())
    for damaged in (b"", packed[:8], packed[:40], packed[:8] + b"\xff" * 400, packed[:8] + b"\x00" * 400):
        with pytest.raises(ValueError, match="a damaged depth picture"):
            unpack_rvl(damaged)


def test_bags_with_rvl_and_nv12_come_in(tmp_path):
    depth = _depth()
    colour = np.zeros((24, 32, 3), dtype=np.uint8)
    colour[:, :16], colour[:, 16:] = (200, 40, 40), (40, 40, 200)
    planes = cv2.cvtColor(colour, cv2.COLOR_RGB2YUV_I420)
    halves = planes[24:].reshape(2, -1)
    frames = {
        "nv12": np.vstack([planes[:24], halves.T.reshape(12, 32)]),
        "nv21": np.vstack([planes[:24], halves[::-1].T.reshape(12, 32)]),
    }
    with new_bag(tmp_path / "run") as bag:
        for k in range(5):
            at = START + 0.1 * k
            header = bag.header(at, "camera")
            packed = bytes(12) + _packed(depth)
            told = bag.compressed(bag.header(at, "depth"), "16UC1; compressedDepth rvl", packed)
            bag.put("/depth/image_raw/compressedDepth", at, told)
            for name, pixels in frames.items():
                told = bag.image(header, name, pixels, padding=8)
                # Both are seen: the height of the picture, and that of all rows.
                told.height = 24 if name == "nv12" else 36
                bag.put(f"/{name}/image_raw", at, told)
    run = imported(tmp_path / "run")
    _, found = next(run.depths("robot", "depth"))
    np.testing.assert_array_equal(found, depth)
    for name in frames:
        _, image = next(run.images("robot", name))
        # Limited range of brightness, and colour of 2 x 2 pixels.
        assert np.abs(image.astype(int) - colour).max() < 6, name


def test_damaged_depth_of_a_bag_is_left_out_with_the_reason(tmp_path):
    depth = _depth()
    png = cv2.imencode(".png", depth)[1].tobytes()
    noise = np.random.default_rng(1).integers(0, 256, (24, 32, 3)).astype(np.uint8)
    colour = cv2.imencode(".png", noise)[1].tobytes()
    with new_bag(tmp_path / "run") as bag:
        for k in range(6):
            at = START + 0.1 * k
            # Heads and ends are right.
            sent = {
                "rvl": _packed(depth)[: -40 if k == 3 else None],
                "png": png[:60] + bytes(9) + png[69:] if k == 3 else png,
            }
            for name, data in sent.items():
                told = bag.compressed(bag.header(at, name), f"16UC1; compressedDepth {name}", bytes(12) + data)
                bag.put(f"/{name}/image_raw/compressedDepth", at, told)
            told = bag.compressed(
                bag.header(at, "png"), "png", colour[:60] + bytes(9) + colour[69:] if k == 1 else colour
            )
            bag.put("/png/colour/compressed", at, told)
    run = imported(tmp_path / "run")
    assert len(list(run.depths("robot", "rvl"))) == 5
    assert run.metadata["damaged readings of rvl left out"] == "1"
    assert "a damaged depth picture (RVL)" in run.metadata["first of the damaged readings of rvl left out"]
    # Depth of the same frame belongs to the colour, which stays without it.
    assert len(list(run.pictures("robot", "png_colour"))) == 5
    assert len(list(run.depths("robot", "png_colour"))) == 4
    assert run.metadata["damaged depth of png_colour left out"] == "1"
    assert run.metadata["damaged readings of png_colour left out"] == "1"
