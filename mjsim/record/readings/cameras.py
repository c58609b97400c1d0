"""Pictures of onboard cameras: the observation has their stamps, the pictures have topics of their own."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from foxglove import Context
from foxglove.channels import CameraCalibrationChannel, CompressedImageChannel, RawImageChannel
from numpy.typing import ArrayLike

from mjsim.interface import Observation, RobotInfo, SensorInfo
from mjsim.record.drawn import calibration_message, depth_message, picture_file_message
from mjsim.record.readings.codec import Box, DrawnTopic
from mjsim.record.readings.derived import derived
from mjsim.world import Camera, Depth, World


def _calibrate(context: Context, frame: str, camera: SensorInfo) -> None:
    if camera.intrinsics is not None:
        channel = CameraCalibrationChannel(f"/{frame}/calibration", context=context)
        channel.log(calibration_message(camera.intrinsics, frame), log_time=0)


def _boxes(camera: Camera, info: RobotInfo, world: World) -> Mapping[str, Box]:
    shape = camera.height, camera.width

    def picture(seen: Observation) -> ArrayLike | None:
        frame = seen.cameras.get(camera.camera)
        return None if frame is None else frame.image

    def depth(seen: Observation) -> ArrayLike | None:
        frame = seen.cameras.get(camera.camera)
        if frame is None or frame.depth is None:
            return None
        return np.where(np.isnan(frame.depth), np.inf, frame.depth)

    boxes = {"": Box(read=picture, low=0, high=255, shape=(*shape, 3), dtype=np.uint8)}
    if camera.depth:
        farthest = (camera.depth if isinstance(camera.depth, Depth) else Depth()).range[1]
        boxes["_depth"] = Box(read=depth, low=0.0, high=farthest, shape=shape, first=farthest)
    return boxes


CAMERAS = replace(
    derived("cameras"),
    drawings=(
        DrawnTopic(
            topic=lambda robot, camera: f"/{robot}/{camera}/image",
            channel=CompressedImageChannel,
            message=picture_file_message,
            begin=_calibrate,
            is_picture=True,
        ),
        DrawnTopic(
            topic=lambda robot, camera: f"/{robot}/{camera}/depth",
            channel=RawImageChannel,
            message=depth_message,
            is_picture=True,
        ),
    ),
    boxes=_boxes,
)
