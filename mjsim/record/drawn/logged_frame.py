"""Pictures and depth as messages that Foxglove draws; those of imported logs are lossless."""

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from foxglove.messages import CompressedImage, RawImage
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.interface import CameraFrame, Intrinsics, Picture
from mjsim.models import any_picture_size
from mjsim.record.drawn.scene_messages import picture_message, stamp
from mjsim.record.file import parts_of
from mjsim.sentences import Sentence

FORMS = {b"\xff\xd8": "jpeg", b"\x89P": "png"}
"""First bytes of files that are stored unchanged -> name of the format."""
QUICK_PNG = [cv2.IMWRITE_PNG_COMPRESSION, 1]
"""Low compression level: for noisy pictures, higher levels hardly reduce the size."""
MM_PER_METRE = 1000.0
"""Millimetres per metre: the unit of 16-bit depth (ROS REP 118), where 0 means no depth."""


@dataclass(frozen=True, slots=True, eq=False)
class LoggedFrame(CameraFrame):
    """A picture of a log, whose file is stored unchanged."""

    encoded: bytes = b""
    """Contents of the file."""
    form: str = "png"
    """'jpeg' or 'png'."""


def logged_frame(frame: CameraFrame) -> LoggedFrame:
    """Return a picture with its file as lossless PNG."""
    if isinstance(frame, LoggedFrame):
        return frame
    _, data = cv2.imencode(".png", cv2.cvtColor(frame.image, cv2.COLOR_RGB2BGR), QUICK_PNG)
    return LoggedFrame(
        frame.stamp,
        frame.image,
        frame.intrinsics,
        frame.depth,
        depth_stamp=frame.depth_stamp,
        encoded=data.tobytes(),
    )


def filed_frame(data: bytes, stamp: float, intrinsics: Intrinsics) -> LoggedFrame:
    """Return the picture in a file of a log: JPEG and PNG are kept unchanged, others become lossless PNG.

    Args:
        data: Contents of the file.
        stamp: When it was taken [s].
        intrinsics: Intrinsics of the camera; pictures have its size.

    Raises:
        ValueError: It is broken, or has another size.
    """
    # A small file may claim gigabytes: it is not decoded.
    try:
        size = any_picture_size(data)
    except ValueError as error:
        raise ValueError(Sentence("a picture that {error}", error)) from None
    require_size(size, intrinsics)
    image = decode_picture(data)
    height, width = image.shape[:2]
    require_size((width, height), intrinsics)
    form = FORMS.get(data[:2])
    if form is None:
        return logged_frame(CameraFrame(stamp, image, intrinsics))
    return LoggedFrame(stamp, image, intrinsics, encoded=data, form=form)


def require_size(size: tuple[int, int], intrinsics: Intrinsics) -> None:
    """Check that a picture has the size of its camera's pictures.

    Args:
        size: Width and height [px].
        intrinsics: Intrinsics of the camera.

    Raises:
        ValueError: It has another.
    """
    width, height = size
    if size != (intrinsics.width, intrinsics.height):
        raise ValueError(
            Sentence("a picture of {width} x {height} pixels among pictures of another size", width, height)
        )


def decode_picture(data: bytes) -> Picture:
    """Return the RGB picture in a file, without rotating it by its metadata, shape (height, width, 3).

    Raises:
        ValueError: It is broken.
    """
    # OpenCV raises its own error for no bytes at all.
    how = cv2.IMREAD_COLOR_RGB | cv2.IMREAD_IGNORE_ORIENTATION
    picture = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), how) if data else None
    if picture is None:
        raise ValueError("a broken picture")
    return np.asarray(picture, dtype=np.uint8)


def picture_file_message(frame: CameraFrame, frame_id: str) -> CompressedImage:
    """Return the message of a picture: the file of a log, or a JPEG of a simulated camera."""
    if isinstance(frame, LoggedFrame):
        return CompressedImage(timestamp=stamp(frame.stamp), frame_id=frame_id, data=frame.encoded, format=frame.form)
    return picture_message(frame, frame_id)


def depth_message(frame: CameraFrame, frame_id: str) -> RawImage | None:
    """Return the depth of a picture, as in `depth_values`."""
    if frame.depth is None:
        return None
    pixels = depth_values(frame)
    height, width = pixels.shape
    return RawImage(
        timestamp=stamp(frame.stamp if frame.depth_stamp is None else frame.depth_stamp),
        frame_id=frame_id,
        width=width,
        height=height,
        encoding="16UC1" if pixels.dtype == np.uint16 else "32FC1",
        step=width * pixels.itemsize,
        data=pixels.tobytes(),
    )


def depth_values(frame: CameraFrame) -> NDArray[Any]:
    """Return the depth of a picture that has one, in millimetres, or in metres where a log's would lose precision.

    Depth of a simulated camera can be rendered again without loss, like its pictures.

    Returns:
        Shape (height, width): uint16 [mm], 0 for no depth, too near, and farther than 65.535 m; or float32 [m].
    """
    metres = np.asarray(frame.depth, dtype=np.float32)
    counts = np.rint(metres * np.float32(MM_PER_METRE))
    counts[~((counts > 0.0) & (counts < 1 << 16))] = 0.0
    pixels = counts.astype("<u2")
    exact = not isinstance(frame, LoggedFrame) or np.array_equal(_metres_of(pixels), metres)
    return pixels if exact else metres.astype("<f4")


def depth_of(data: bytes, *, shape: tuple[int, int]) -> Array:
    """Return the depth in a `foxglove.RawImage` of a known height and width [m].

    Raises:
        ValueError: It is not as `depth_message` writes it.
    """
    pixels = depth_pixels(data)
    if pixels.shape != shape:
        raise ValueError("depth of another size than the camera's")
    metres = _metres_of(pixels) if pixels.dtype == np.uint16 else pixels
    return metres.astype(float)


def depth_pixels(data: bytes) -> NDArray[Any]:
    """Return the values of a `foxglove.RawImage` with depth, shape (height, width).

    Returns:
        Whole millimetres as uint16, 0 for none, or metres as float32, infinite for none.

    Raises:
        ValueError: It is not as `depth_message` writes it.
    """
    fields = {number: value for number, value, _ in parts_of(data)}
    kind = {b"16UC1": "<u2", b"32FC1": "<f4"}.get(fields.get(4, b""))
    if kind is None:
        raise ValueError("depth of an unknown encoding")
    height, width = (int.from_bytes(fields.get(number, b""), "little") for number in (3, 2))
    return np.frombuffer(fields.get(6, b""), dtype=kind).reshape(height, width)


def _metres_of(pixels: NDArray[np.uint16]) -> NDArray[np.float32]:
    """Return millimetres as metres, 0 as +inf."""
    return np.where(pixels == 0, np.float32(np.inf), pixels / np.float32(MM_PER_METRE))
