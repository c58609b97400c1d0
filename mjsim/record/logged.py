"""Cameras of imported logs, whose pictures are stored because they cannot be rendered again."""

import json
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from mjsim.errors import RecordingError
from mjsim.geometry import Array
from mjsim.interface import CameraFrame, Intrinsics, Picture, RobotInfo
from mjsim.record.drawn import LoggedFrame, decode_picture, depth_of
from mjsim.record.file import RawMessage, picture_of, raw_messages, timestamp_of
from mjsim.record.numbers import nanoseconds
from mjsim.record.parse import FAULTS, reading, unfit
from mjsim.record.recording import Recording
from mjsim.sentences import Sentence

LOGGED_CAMERAS = "logged cameras"
"""Metadata key of the data sheets of cameras whose pictures are stored."""


@dataclass(frozen=True, slots=True, eq=False)
class LoggedCamera:
    """The data sheet of a camera whose pictures are stored."""

    intrinsics: Intrinsics
    robot_from_camera: Array | None = None
    """Pose of its optical frame (x right, y down, z ahead), shape (4, 4) [m]; by default as in the world."""
    has_depth: bool = False
    """Whether some of its pictures come with depth."""

    def to_json(self) -> dict[str, Any]:
        """Return it as a JSON value."""
        place = self.robot_from_camera
        return {
            "intrinsics": asdict(self.intrinsics),
            "robot_from_camera": None if place is None else place.tolist(),
            "has_depth": self.has_depth,
        }

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> "LoggedCamera":
        """Return the data sheet from `to_json`; raises one of FAULTS for anything else."""
        values = dict(data["intrinsics"])
        numbers = [float(value) for value in values.pop("distortion")]
        intrinsics = Intrinsics(**values, distortion=tuple(numbers))
        has_depth = bool(data.get("has_depth", False))
        if data["robot_from_camera"] is None:
            return cls(intrinsics, has_depth=has_depth)
        place = np.array(data["robot_from_camera"], dtype=float)
        if place.shape != (4, 4) or not np.isfinite(place).all():
            raise ValueError("a camera's pose does not have 4 x 4 numbers")
        return cls(intrinsics, place, has_depth)


def cameras_text(cameras: Mapping[tuple[str, str], LoggedCamera]) -> str:
    """Return the data sheets by robot and camera as text for the metadata."""
    return json.dumps({f"{robot}/{name}": camera.to_json() for (robot, name), camera in cameras.items()})


def logged_cameras(recording: Recording) -> dict[tuple[str, str], LoggedCamera]:
    """Return the data sheets of a log's cameras by robot and camera; none for a simulated run.

    Raises:
        RecordingError: They were not written by mjsim.
    """
    text = recording.metadata.get(LOGGED_CAMERAS)
    if text is None:
        return {}
    try:
        cameras = {tuple(name.split("/")): LoggedCamera.from_json(camera) for name, camera in json.loads(text).items()}
    except (*FAULTS, AttributeError) as error:
        raise unfit(f"'{recording.path}': the metadata '{LOGGED_CAMERAS}'", error) from error
    return {(robot, name): camera for (robot, name), camera in cameras.items() if (robot, name) in recording.cameras()}


def with_logged_cameras(
    robots: Mapping[str, RobotInfo], cameras: Mapping[tuple[str, str], LoggedCamera]
) -> dict[str, RobotInfo]:
    """Return the data sheet of each robot, with those of the cameras of a log."""
    completed = {}
    for robot, info in robots.items():
        sensors = dict(info.sensors)
        for (of, name), camera in cameras.items():
            if of == robot:
                place = camera.robot_from_camera
                place = sensors[name].robot_from_sensor if place is None else place
                sensors[name] = replace(sensors[name], robot_from_sensor=place, intrinsics=camera.intrinsics)
        completed[robot] = replace(info, sensors=sensors)
    return completed


class LoggedPictures:
    """The pictures of one robot of a log, tick by tick; each is decoded when a module accesses it."""

    def __init__(self, recording: Recording, robot: str) -> None:
        """Store the cameras."""
        self.cameras = {name: camera for (of, name), camera in logged_cameras(recording).items() if of == robot}
        self._path, self._robot = recording.path, robot
        kinds = ("image", "depth")
        self._names = {f"/{robot}/{name}/{kind}": (name, kind) for name in self.cameras for kind in kinds}
        self._messages = raw_messages(recording.path, topics=self._names)
        self._next = next(self._messages, None)

    def at(self, time: int) -> Callable[[str, float], CameraFrame]:
        """Return a function that gives the pictures of a tick by camera and stamp; ticks must ascend.

        Args:
            time: Time of the tick's messages [ns].
        """
        found: dict[str, dict[str, RawMessage]] = defaultdict(dict)
        while self._next is not None and self._next.time <= time:
            name, kind = self._names[self._next.topic]
            if self._next.time == time:
                found[name][kind] = self._next
            self._next = next(self._messages, None)

        return lambda camera, stamp: self._frame(found.get(camera, {}), camera, stamp)

    def _frame(self, found: Mapping[str, RawMessage], camera: str, stamp: float) -> CameraFrame:
        intrinsics = self.cameras[camera].intrinsics
        if "image" not in found:
            raise RecordingError(
                Sentence(
                    "'{path}': the picture of camera '{camera}' at {stamp:g} s is missing", self._path, camera, stamp
                )
            )
        with reading(found["image"], path=self._path):
            data, form = picture_of(found["image"].data)
            image: Picture = decode_picture(data)
        depth, taken = None, None
        if "depth" in found:
            with reading(found["depth"], path=self._path):
                depth = depth_of(found["depth"].data, shape=(intrinsics.height, intrinsics.width))
                timestamp = timestamp_of(found["depth"].data)
            taken = None if timestamp == nanoseconds(stamp) else timestamp * 1e-9
        return LoggedFrame(stamp, image, intrinsics, depth, depth_stamp=taken, encoded=data, form=form)
