"""Pictures in bags: encodings, orders of bytes, sizes."""

import struct
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from mjsim.interface import Intrinsics
from mjsim.logs.bags.bag_messages import intrinsics_of, unread_lens
from mjsim.logs.bags.bag_pictures import depth_of, frame_of, size_of
from mjsim.record import filed_frame
from mjsim.record.drawn.logged_frame import decode_picture


class _Image:
    """A `sensor_msgs/Image` of an array."""

    def __init__(self, encoding: str, pixels: np.ndarray, *, big: bool = False) -> None:
        pixels = pixels.astype(pixels.dtype.newbyteorder(">")) if big else pixels
        self.height, self.width = pixels.shape[:2]
        self.encoding, self.is_bigendian = encoding, int(big)
        self.step = pixels.nbytes // self.height + 3
        rows = np.frombuffer(pixels.tobytes(), dtype=np.uint8).reshape(self.height, -1)
        self.data = np.hstack([rows, np.full((self.height, 3), 9, dtype=np.uint8)]).ravel()


def test_pictures_of_every_encoding_show_the_same():
    size = Intrinsics(16, 16, 10.0, 10.0, 7.5, 7.5)
    rgb = np.zeros((16, 16, 3), dtype=np.uint8)
    rgb[:] = 200, 120, 40
    clear = np.full((16, 16, 1), 255, dtype=np.uint8)
    grey = np.full((16, 16), 77, dtype=np.uint8)
    mosaic = np.empty((16, 16), dtype=np.uint8)
    mosaic[::2, ::2], mosaic[1::2, 1::2] = 200, 40
    mosaic[::2, 1::2] = mosaic[1::2, ::2] = 120
    for encoding, pixels in (
        ("rgb8", rgb),
        ("bgr8", rgb[..., ::-1]),
        ("rgba8", np.concatenate([rgb, clear], axis=2)),
        ("bgra8", np.concatenate([rgb[..., ::-1], clear], axis=2)),
        ("bgr16", rgb[..., ::-1].astype(np.uint16) << 8),
        ("16UC3", rgb[..., ::-1].astype(np.uint16) << 8),
        ("rgba16", np.concatenate([rgb, clear], axis=2).astype(np.uint16) << 8),
        ("bgra16", np.concatenate([rgb[..., ::-1], clear], axis=2).astype(np.uint16) << 8),
        ("bayer_rggb8", mosaic),
        ("bayer_bggr8", np.roll(mosaic, (1, 1), axis=(0, 1))),
    ):
        frame = frame_of(_Image(encoding, np.ascontiguousarray(pixels)), 1.0, size)
        np.testing.assert_array_equal(frame.image[4:12, 4:12], rgb[4:12, 4:12], err_msg=encoding)
        assert frame.form == "png"
    for encoding, pixels in (("mono8", grey), ("8UC1", grey), ("mono16", grey.astype(np.uint16) << 8)):
        for big in (False, True):
            frame = frame_of(_Image(encoding, pixels, big=big), 1.0, size)
            assert (frame.image == 77).all()
    with pytest.raises(ValueError, match="encoding 'yuv999' are not supported"):
        frame_of(_Image("yuv999", grey), 1.0, size)
    metres = np.full((16, 16), 1.25, dtype=np.float32)
    metres[0, :2] = np.nan, 0.0
    assert np.isinf(depth_of(_Image("32FC1", metres), size)[0, :2]).all()
    counts = np.full((16, 16), 1250, dtype=np.uint16)
    counts[0, 0] = 0
    far = depth_of(_Image("16UC1", counts, big=True), size)
    assert far[1, 1] == np.float32(1.25)
    assert far[0, 0] == np.inf


def test_a_jpeg_that_says_it_was_turned_keeps_its_rows():
    pixels = np.zeros((16, 32, 3), dtype=np.uint8)
    pixels[:, :16] = 250
    data = cv2.imencode(".jpg", pixels)[1].tobytes()
    # EXIF with one entry: orientation 6, a quarter turn; behind the mark that a JPEG begins with.
    exif = b"Exif\0\0" + struct.pack("<2sHIHHHIHHI", b"II", 42, 8, 1, 0x0112, 3, 1, 6, 0, 0)
    turned = data[:2] + struct.pack(">2sH", b"\xff\xe1", len(exif) + 2) + exif + data[2:]
    assert cv2.imdecode(np.frombuffer(turned, dtype=np.uint8), cv2.IMREAD_COLOR).shape == (32, 16, 3)
    frame = filed_frame(turned, 0.0, Intrinsics(32, 16, 10.0, 10.0, 15.5, 7.5))
    assert frame.encoded == turned
    np.testing.assert_array_equal(frame.image, decode_picture(data))


def test_a_picture_that_claims_to_be_huge_is_not_decoded():
    plain = cv2.imencode(".png", np.zeros((16, 32), dtype=np.uint8))[1].tobytes()
    size = Intrinsics(32, 16, 10.0, 10.0, 15.5, 7.5)
    assert filed_frame(plain, 0.0, size).image.shape == (16, 32, 3)
    for width, height, said in (
        (9000, 2, "a picture of 9000 x 2 pixels among pictures of another size"),
        (40000, 40000, "megapixels"),
    ):
        # Its checksum is wrong too: who decoded it would call it broken.
        with pytest.raises(ValueError, match=said):
            filed_frame(plain[:16] + struct.pack(">II", width, height) + plain[24:], 0.0, size)


@pytest.mark.parametrize("binning", [1, 2])
def test_a_part_of_the_calibrated_picture_keeps_its_rays(binning):
    K = np.array([[400.0, 0.0, 320.3], [0.0, 410.0, 235.1], [0.0, 0.0, 1.0]])
    info = SimpleNamespace(
        width=640,
        height=480,
        distortion_model="plumb_bob",
        k=K.ravel(),
        p=np.zeros(12),
        d=np.zeros(5),
        binning_x=binning,
        binning_y=binning,
        roi=SimpleNamespace(x_offset=100, y_offset=60, width=320, height=240),
    )
    size = 320 // binning, 240 // binning
    found = intrinsics_of(info, width=size[0], height=size[1], rectified=False)
    # The ray of each corner of the part, in pixels of the whole picture and of the part.
    for u, v in ((0, 0), (size[0], size[1])):
        whole = np.linalg.solve(K, [100 + binning * u - 0.5, 60 + binning * v - 0.5, 1.0])
        part = np.linalg.solve(found.matrix(), [u - 0.5, v - 0.5, 1.0])
        np.testing.assert_allclose(part, whole, atol=1e-12)
    # Without a part, a smaller picture shows the whole.
    info.roi = SimpleNamespace(x_offset=0, y_offset=0, width=0, height=0)
    found = intrinsics_of(info, width=320, height=240, rectified=False)
    assert found.cx == pytest.approx((320.3 + 0.5) / 2 - 0.5)


@pytest.mark.parametrize(
    ("model", "numbers", "lens", "said"),
    [
        ("plumb_bob", [0.1, 0.01, 0.0, 0.0, 0.0], "brown", ""),
        ("equidistant", [0.1, 0.01, 0.0, 0.0], "fisheye", ""),
        ("division", [0.1], "pinhole", "lens of model 'division' taken for a pinhole"),
        ("rational_polynomial", [0.1] * 14, "brown", "coefficients after the eighth"),
        ("plumb_bob", [float("nan")] * 5, None, ""),
    ],
)
def test_lenses_that_are_not_supported_are_said(model, numbers, lens, said):
    info = SimpleNamespace(
        width=64,
        height=48,
        distortion_model=model,
        k=np.array([50.0, 0.0, 32.0, 0.0, 50.0, 24.0, 0.0, 0.0, 1.0]),
        p=np.zeros(12),
        d=np.array(numbers),
        binning_x=0,
        binning_y=0,
        roi=SimpleNamespace(x_offset=0, y_offset=0, width=0, height=0),
    )
    found = intrinsics_of(info, width=64, height=48, rectified=False)
    assert (None if found is None else found.lens) == lens
    if found is not None:
        assert unread_lens(info).startswith(said)
        assert bool(unread_lens(info)) == bool(said)


def test_a_picture_that_is_not_all_there_is_found_before_it_is_read():
    for encoding, pixels in (
        ("rgb8", np.zeros((16, 16, 3), dtype=np.uint8)),
        ("mono16", np.zeros((16, 16), dtype=np.uint16)),
        ("32FC1", np.zeros((16, 16), dtype=np.float32)),
        ("uyvy", np.zeros((16, 16, 2), dtype=np.uint8)),
        ("bayer_rggb16", np.zeros((16, 16), dtype=np.uint16)),
        ("nv12", np.zeros((24, 16), dtype=np.uint8)),
    ):
        image = _Image(encoding, pixels)
        assert size_of(image) == (16, 16)
        image.data = image.data[:-1]
        with pytest.raises(ValueError, match="a picture of 16 x"):
            size_of(image)
        image.data, image.width = np.append(image.data, [0]).astype(np.uint8), 4000
        with pytest.raises(ValueError, match="a picture of 4000 x"):
            size_of(image)
