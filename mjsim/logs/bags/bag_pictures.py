"""Converts pictures of ROS to camera frames: JPEG and PNG are kept, everything else becomes lossless PNG.

rgb8 bgr8 rgba8 bgra8 8UC3 8UC4 mono8 8UC1   unchanged; transparency is ignored
mono16 rgb16 bgr16 rgba16 bgra16 16UC3 16UC4 the upper 8 bits
bayer_rggb8 and so on, 8 and 16 bits         converted to RGB
yuv422 (UYVY), uyvy, yuv422_yuy2, yuyv       converted to RGB
nv12, nv21                                   converted to RGB; rows of brightness, then rows of colour at half the size
16UC1                                        depth [mm], 0 for none (ROS REP 118)
32FC1                                        depth [m], NaN for none
compressedDepth                              both of these as PNG or RVL
"""

import re
import struct
from typing import Any

import cv2
import numpy as np

from mjsim.geometry import Array
from mjsim.interface import CameraFrame, Intrinsics, Picture
from mjsim.logs.bags.rvl import rvl_size, unpack_rvl
from mjsim.logs.files import require_sound
from mjsim.models import any_picture_size
from mjsim.record import LoggedFrame, filed_frame, logged_frame, require_size

PLAIN = {
    "rgb8": ("RGB", 1),
    "8uc3": ("BGR", 1),
    "bgr8": ("BGR", 1),
    "rgba8": ("RGBA", 1),
    "bgra8": ("BGRA", 1),
    "8uc4": ("BGRA", 1),
    "mono8": ("GRAY", 1),
    "8uc1": ("GRAY", 1),
    "mono16": ("GRAY", 2),
    "rgb16": ("RGB", 2),
    "bgr16": ("BGR", 2),
    "16uc3": ("BGR", 2),
    "rgba16": ("RGBA", 2),
    "bgra16": ("BGRA", 2),
    "16uc4": ("BGRA", 2),
}
"""Encoding -> order of channels, and bytes per channel."""
CHANNELS = {"GRAY": 1, "RGBA": 4, "BGRA": 4}
YUV = {"yuv422": "UYVY", "uyvy": "UYVY", "yuv422_yuy2": "YUY2", "yuyv": "YUY2"}
HALVED = {"nv12": "NV12", "nv21": "NV21"}
"""Encodings whose colour has half the width and height of the picture, below its brightness."""
BAYER = re.compile(r"bayer_(rggb|bggr|gbrg|grbg)(8|16)")
DEPTH_ENCODINGS = ("16UC1", "32FC1")
COMPRESSED_DEPTH = struct.Struct("<iff")
"""Header of a compressed depth picture: its kind, and the scaling of its values."""
MAX_SHOWN_DEPTH = 10.0
"""Distance shown as black in the picture of a camera that only has depth [m]."""


def is_depth(message: Any, topic: str) -> bool:
    """Return whether a picture contains depth."""
    if hasattr(message, "encoding"):
        return message.encoding in DEPTH_ENCODINGS or (message.encoding == "mono16" and "depth" in topic)
    return "compressedDepth" in message.format or any(message.format.startswith(kind) for kind in DEPTH_ENCODINGS)


def is_read(encoding: str) -> bool:
    """Return whether the pictures of a `sensor_msgs/Image` of an encoding can be read."""
    known = encoding.lower()
    return (
        encoding in DEPTH_ENCODINGS or known in PLAIN or known in YUV or known in HALVED or bool(BAYER.fullmatch(known))
    )


def size_of(message: Any) -> tuple[int, int]:
    """Return width and height of a picture [px].

    Raises:
        ValueError: It is broken, or of an unknown encoding.
    """
    if hasattr(message, "encoding"):
        if not is_read(message.encoding):
            raise ValueError(f"pictures with the encoding '{message.encoding}' are not supported")
        height = _height(message)
        _require_rows(message, height * 3 // 2 if message.encoding.lower() in HALVED else height, _row_bytes(message))
        return int(message.width), height
    try:
        return _packed_size(message, _unpacked(message)[1])
    except ValueError as error:
        raise ValueError(f"a picture of format '{message.format[:40]}' {error}") from None


def frame_of(message: Any, stamp: float, intrinsics: Intrinsics) -> LoggedFrame:
    """Return the picture of a `sensor_msgs/Image` or `CompressedImage`.

    Args:
        message: As ROS defines it.
        stamp: When it was taken [s].
        intrinsics: Intrinsics of the camera; pictures have its size.

    Raises:
        ValueError: It is broken, of an unknown encoding or of another size.
    """
    if not hasattr(message, "encoding"):
        data = bytes(message.data)
        require_sound(data)
        return filed_frame(data, stamp, intrinsics)
    require_size(size_of(message), intrinsics)
    return logged_frame(CameraFrame(stamp, _picture(message), intrinsics))


def depth_of(message: Any, intrinsics: Intrinsics) -> Array:
    """Return the depth in a `sensor_msgs/Image` or `CompressedImage`, shape (height, width) [m]; +inf for none.

    Raises:
        ValueError: It is broken, of an unknown encoding or of another size.
    """
    if hasattr(message, "encoding"):
        values = _channels(message, 1, "f4" if message.encoding == "32FC1" else "u2")[:, :, 0]
        scaled = values.astype(np.float32) / np.float32(1.0 if message.encoding == "32FC1" else 1000.0)
    else:
        (scale, offset), data = _unpacked(message)
        require_size(_packed_size(message, data), intrinsics)
        values = unpack_rvl(data) if _is_rvl(message) else _decoded(data)
        if "32FC1" in message.format and scale:
            # Inverse depth, as the plug-in compressed_depth_image_transport scales it.
            with np.errstate(divide="ignore"):
                scaled = np.where(values > 0, scale / (values.astype(np.float32) - offset), 0.0)
        else:
            scaled = values.astype(np.float32) / np.float32(1000.0)
    height, width = scaled.shape[:2]
    require_size((width, height), intrinsics)
    return np.where(scaled > 0.0, scaled, np.inf).astype(float)


def shown_depth(depth: Array) -> Picture:
    """Return depth as a grey picture: near things are bright, missing depth is black."""
    grey = np.where(np.isfinite(depth), 255.0 * (1.0 - np.minimum(depth, MAX_SHOWN_DEPTH) / MAX_SHOWN_DEPTH), 0.0)
    return np.repeat(grey.astype(np.uint8)[:, :, None], 3, axis=2)


def _picture(message: Any) -> Picture:
    """Return the RGB picture of a `sensor_msgs/Image`."""
    encoding = message.encoding.lower()
    if encoding in PLAIN:
        order, size = PLAIN[encoding]
        channels = _channels(message, CHANNELS.get(order, 3), f"u{size}")
        picture = _upper(channels)
        return np.asarray(picture if order == "RGB" else cv2.cvtColor(picture, getattr(cv2, f"COLOR_{order}2RGB")))
    if BAYER.fullmatch(encoding):
        size = 2 if encoding.endswith("16") else 1
        mosaic = _upper(_channels(message, 1, f"u{size}"))[:, :, 0]
        return np.asarray(cv2.cvtColor(mosaic, getattr(cv2, f"COLOR_Bayer{encoding[6:10].upper()}2RGB")))
    if encoding in HALVED:
        planes = _rows(message, _height(message) * 3 // 2, int(message.width))
        return np.asarray(cv2.cvtColor(planes, getattr(cv2, f"COLOR_YUV2RGB_{HALVED[encoding]}")))
    if encoding in YUV:
        pairs = _channels(message, 2, "u1")
        return np.asarray(cv2.cvtColor(pairs, getattr(cv2, f"COLOR_YUV2RGB_{YUV[encoding]}")))
    raise ValueError(f"pictures with the encoding '{message.encoding}' are not supported")


def _channels(message: Any, count: int, kind: str) -> Any:
    """Return the channels of a picture, shape (height, width, count)."""
    number = np.dtype(kind).newbyteorder(">" if message.is_bigendian else "<")
    height, width = int(message.height), int(message.width)
    return _rows(message, height, width * count * number.itemsize).view(number).reshape(height, width, count)


def _rows(message: Any, count: int, used: int) -> Any:
    """Return the bytes that are used in each row of a picture, shape (count, used)."""
    _require_rows(message, count, used)
    step, data = int(message.step), np.asarray(message.data, dtype=np.uint8)
    return np.ascontiguousarray(data[: step * count].reshape(count, step)[:, :used])


def _require_rows(message: Any, count: int, used: int) -> None:
    """Check that a picture has some rows, of which some bytes are used."""
    step, size = int(message.step), len(message.data)
    if not 0 < used <= step or size < step * count:
        pixels = f"{int(message.width)} x {int(message.height)}"
        raise ValueError(f"a picture of {pixels} pixels in {size} bytes, {step} per row")


def _row_bytes(message: Any) -> int:
    """Return how many bytes of each row of a picture are used."""
    encoding = message.encoding.lower()
    if encoding in PLAIN:
        order, size = PLAIN[encoding]
        return int(message.width) * size * CHANNELS.get(order, 3)
    wide = 4 if message.encoding == "32FC1" else 2 if encoding in YUV or encoding.endswith(("16", "16uc1")) else 1
    return int(message.width) * wide


def _height(message: Any) -> int:
    """Return the height of a picture [px]; some drivers count the rows of colour, too.

    Raises:
        ValueError: Its data do not fit, or a side is odd, though its colour has half the size.
    """
    height, width, step = int(message.height), int(message.width), int(message.step)
    if message.encoding.lower() not in HALVED:
        return height
    whole = height if len(message.data) >= step * (height * 3 // 2) else height * 2 / 3
    if whole % 2 or width % 2:
        raise ValueError(f"a picture of {width} x {height} pixels in {len(message.data)} bytes, {step} per row")
    return int(whole)


def _upper(channels: Any) -> Any:
    """Return the upper 8 bits of numbers."""
    return np.ascontiguousarray(channels if channels.dtype.itemsize == 1 else (channels >> 8).astype(np.uint8))


def _unpacked(message: Any) -> tuple[tuple[float, float], bytes]:
    """Return the scaling of depth and the file in a `sensor_msgs/CompressedImage`."""
    data = bytes(message.data)
    if "compressedDepth" in message.format and len(data) > COMPRESSED_DEPTH.size:
        _, scale, offset = COMPRESSED_DEPTH.unpack_from(data)
        return (scale, offset), data[COMPRESSED_DEPTH.size :]
    return (0.0, 0.0), data


def _is_rvl(message: Any) -> bool:
    return "compressedDepth" in message.format and "rvl" in message.format.lower()


def _packed_size(message: Any, data: bytes) -> tuple[int, int]:
    """Return width and height of a `sensor_msgs/CompressedImage` [px]."""
    return rvl_size(data) if _is_rvl(message) else any_picture_size(data)


def _decoded(data: bytes) -> Any:
    """Return the pixels of a single-channel picture, shape (height, width)."""
    require_sound(data)
    picture = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), cv2.IMREAD_UNCHANGED)
    if picture is None or picture.ndim != 2:
        raise ValueError("a damaged depth picture")
    return picture
