"""Pictures as newcomers bring them, as files: plain, striped, repetitive, tiny, long, of every kind of pixel."""

import io
import struct
from collections.abc import Mapping
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from mjsim.interface import Picture

Y, X = np.mgrid[:320, :240]
EXIF_ROTATED = b"\xff\xe1\x00\x22Exif\0\0II*\0" + struct.pack("<IHHHIHHI", 8, 1, 0x0112, 3, 1, 6, 0, 0)
"""The segment of a JPEG file by which it is shown turned by a quarter clockwise."""


def odd_pictures() -> dict[str, bytes]:
    """Return files of pictures that no camera can recognise or that decoders treat in their own way, by name."""
    return {
        **{f"{name}.png": png(values) for name, values in {**plain(), **one_way(), **repeated(), **small()}.items()},
        **other_pixels(),
    }


def plain() -> Mapping[str, NDArray]:
    """Return pictures with little or nothing on them."""
    rng = np.random.default_rng(1)
    corner = np.full((320, 240), 240)
    corner[:24, :18] = rng.integers(0, 255, (24, 18))
    return {
        "white": np.full((320, 240), 255),
        "black": np.zeros((320, 240)),
        "red": np.tile(np.uint8([200, 20, 20]), (320, 240, 1)),
        "half": np.where(X < 120, 40, 220),
        "disc": np.where(np.hypot(X - 120, Y - 160) < 80, 60, 220),
        "faint": drawing(2) // 40 + 120,
        "dim-noise": rng.normal(128, 3, (320, 240)),
        "corner-only": corner,
        "cross": np.where((abs(X - 120) < 20) | (abs(Y - 160) < 20), 30, 230),
    }


def one_way() -> Mapping[str, NDArray]:
    """Return pictures that look the same after a shift or a turn."""
    return {
        "gradient": X,
        "gradient-down": Y * 0.7,
        "gradient-slanted": (X + Y) * 0.4,
        "stripes": X // 20 % 2 * 200 + 20,
        "stripes-across": Y // 20 % 2 * 200 + 20,
        "stripes-slanted": (X + Y) // 20 % 2 * 200 + 20,
        "rings": np.sin(np.hypot(X - 120, Y - 160) / 4) * 100 + 128,
        "barcode": np.tile(np.random.default_rng(3).integers(0, 2, 60).repeat(4) * 220 + 20, (320, 1)),
    }


def repeated() -> Mapping[str, NDArray]:
    """Return pictures whose parts look alike."""
    return {
        "checkerboard": (X // 20 + Y // 20) % 2 * 255,
        "fine-checkerboard": (X // 2 + Y // 2) % 2 * 255,
        "bricks": np.where((Y % 32 < 3) | ((X + Y // 32 % 2 * 30) % 60 < 3), 220, 110),
        "dots": np.where(np.hypot(X % 24 - 12, Y % 24 - 12) < 7, 40, 230),
        "tiles-of-one-motif": np.tile(cv2.resize(drawing(4), (60, 80), interpolation=cv2.INTER_AREA), (4, 4)),
        "noise": np.random.default_rng(5).integers(0, 256, (320, 240)),
    }


def small() -> Mapping[str, NDArray]:
    """Return pictures of few pixels, or of few in one direction."""
    rng = np.random.default_rng(6)
    sizes = ((1, 1), (2, 2), (6, 8), (7, 7), (15, 9), (24, 16), (1, 1000), (1000, 1), (3, 900), (900, 20), (40, 1200))
    return {f"{columns}x{rows}": rng.integers(0, 256, (rows, columns)) for rows, columns in sizes}


def borderline() -> dict[str, Picture]:
    """Return pictures between bad and good, RGB, by name: of few shapes, faint, blurred, coarse, repeated in part."""
    # Of different drawings, so that none is taken for another.
    grays = {f"{count}-shapes": drawing(50 + count, shapes=count) for count in (1, 2, 3, 4, 6, 8, 12)}
    for seed, share in enumerate((0.02, 0.05, 0.1, 0.2, 0.4)):
        grays[f"contrast-{share}"] = 128 + (drawing(20 + seed) - 128.0) * share
    for sigma in (3, 6, 10, 16, 24):
        grays[f"blur-{sigma}"] = cv2.GaussianBlur(drawing(70 + sigma), (0, 0), sigma)
    for columns in (9, 12, 18, 27, 40):
        small = cv2.resize(drawing(100 + columns), (columns, columns * 4 // 3), interpolation=cv2.INTER_AREA)
        grays[f"{columns}-columns"] = small
    grays |= {name: repeated()[name] for name in ("bricks", "tiles-of-one-motif", "noise", "checkerboard")}
    grays |= {"disc": plain()["disc"], "cross": plain()["cross"], "rings": one_way()["rings"]}
    grays["logo-on-bricks"] = grays["bricks"].copy()
    grays["logo-on-bricks"][100:220, 70:170] = drawing(11)[100:220, 70:170]
    return {name: colored(gray) for name, gray in grays.items()}


def colored(gray: NDArray) -> Picture:
    """Return an RGB picture of gray values."""
    return np.repeat(np.clip(np.rint(gray), 0, 255).astype(np.uint8)[..., None], 3, axis=2)


def other_pixels() -> dict[str, bytes]:
    """Return files of one good drawing in the forms that files have: depths, channels, palettes, orientations."""
    gray = drawing(7)
    color = np.dstack([gray, np.roll(gray, 20), 255 - gray])
    jpeg = encoded(".jpg", color)
    return {
        "gray.png": png(gray),
        "sixteen-bit.png": encoded(".png", gray.astype(np.uint16) * 257),
        "alpha.png": encoded(".png", np.dstack([color, np.where(X < 200, 255, 0).astype(np.uint8)])),
        "transparent.png": encoded(".png", np.dstack([color, np.zeros_like(gray)])),
        "sixteen-bit-alpha.png": encoded(".png", np.dstack([color, gray]).astype(np.uint16) * 257),
        "one-bit.png": saved(Image.fromarray(gray).convert("1"), "PNG"),
        "palette.png": saved(Image.fromarray(color).convert("P"), "PNG"),
        "cmyk.jpg": saved(Image.fromarray(color).convert("CMYK"), "JPEG"),
        "animated.png": saved(Image.fromarray(color), "PNG", save_all=True, append_images=[Image.fromarray(gray)]),
        "gray.jpg": encoded(".jpg", gray),
        "turned.jpg": jpeg[:2] + EXIF_ROTATED + jpeg[2:],
        "progressive.jpg": encoded(".jpg", color, cv2.IMWRITE_JPEG_PROGRESSIVE, 1),
        "coarse.jpg": encoded(".jpg", color, cv2.IMWRITE_JPEG_QUALITY, 3),
        "large.jpg": encoded(".jpg", cv2.resize(gray, (1200, 1600), interpolation=cv2.INTER_NEAREST)),
    }


def drawing(seed: int, *, shapes: int = 40) -> NDArray:
    """Return a poster with clear shapes, shape (320, 240)."""
    rng, picture = np.random.default_rng(seed), np.full((320, 240), 225, dtype=np.uint8)
    for _ in range(shapes):
        corners = rng.integers(0, (240, 320), 2) + rng.integers(-45, 45, (int(rng.integers(3, 6)), 2))
        cv2.fillPoly(picture, [corners.astype(np.int32)], int(rng.integers(0, 256)))
    return picture


def png(values: NDArray) -> bytes:
    """Return a PNG file of values from 0 to 255."""
    return encoded(".png", np.clip(np.rint(values), 0, 255).astype(np.uint8))


def saved(image: Image.Image, kind: str, **settings: Any) -> bytes:
    """Return a file of an image in modes that OpenCV does not write."""
    file = io.BytesIO()
    image.save(file, kind, **settings)
    return file.getvalue()


def encoded(suffix: str, values: NDArray, *settings: int) -> bytes:
    done, data = cv2.imencode(suffix, values, settings)
    assert done
    return data.tobytes()
