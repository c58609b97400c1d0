"""The cameras of one robot in a bag: data sheets, and pictures with the depth that belongs to them."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from mjsim.interface import CameraFrame, Intrinsics
from mjsim.inventory import Fate, told
from mjsim.logs.bags.bag_contents import Stream
from mjsim.logs.bags.bag_frames import frame_name
from mjsim.logs.bags.bag_messages import assumed_intrinsics, intrinsics_of, unread_lens
from mjsim.logs.bags.bag_pictures import depth_of, frame_of, shown_depth
from mjsim.logs.bags.bag_streams import RobotStreams
from mjsim.logs.bags.bag_topics import plain_topic
from mjsim.logs.resampling import AHEAD, TOGETHER, DamagedReadingError, Readings, partners
from mjsim.record import LoggedCamera, LoggedFrame, logged_frame


def cameras_of(
    robot: RobotStreams, topics: Mapping[str, str]
) -> tuple[dict[str, LoggedCamera], dict[str, Readings[LoggedFrame]]]:
    """Return data sheets and pictures; depth of the same frame and size belongs to a picture."""
    found = {name: (topic, robot.stream(topic)) for name, topic in topics.items()}
    streams = {name: (topic, stream) for name, (topic, stream) in found.items() if stream is not None}
    depths = {name: each for name, each in streams.items() if _is_of_depth(each[1])}
    cameras: dict[str, LoggedCamera] = {}
    frames: dict[str, Readings[LoggedFrame]] = {}
    for name in [name for name in streams if name not in depths]:
        topic, stream = streams[name]
        camera, pictures = _camera(robot, name, topic, stream, frame_of)
        partner = next((other for other in depths if _belong(stream, depths[other][1])), None)
        if partner is not None:
            pictures = _with_depth(robot, name, pictures, camera.intrinsics, *depths.pop(partner))
            camera = replace(camera, has_depth=True)
        cameras[name], frames[name] = camera, pictures
    for name, (topic, stream) in depths.items():
        camera, frames[name] = _camera(robot, name, topic, stream, _depth_frame)
        cameras[name] = replace(camera, has_depth=True)
    return cameras, frames


def _camera(
    robot: RobotStreams, name: str, topic: str, stream: Stream, make: Callable[[Any, float, Intrinsics], LoggedFrame]
) -> tuple[LoggedCamera, Readings[LoggedFrame]]:
    """Return the data sheet and the pictures of a topic."""
    robot.count_odd(topic, stream)
    width, height = _size(stream)
    place = robot.place(name, frame_name(stream.first.header.frame_id))
    intrinsics = _intrinsics(robot, name, topic, width, height)
    camera = LoggedCamera(intrinsics, AHEAD if place is None else place)
    return camera, robot.readings(topic, stream, lambda message, stamp: make(message, stamp, intrinsics))


def _intrinsics(robot: RobotStreams, name: str, topic: str, width: int, height: int) -> Intrinsics:
    """Return the calibration beside a topic of pictures [px]."""
    plain = plain_topic(topic)
    info = robot.contents.infos.get(f"{plain.rpartition('/')[0]}/camera_info")
    rectified = "rect" in plain.rpartition("/")[2]
    intrinsics = None if info is None else intrinsics_of(info, width=width, height=height, rectified=rectified)
    if intrinsics is None:
        robot.notes[f"calibration of {name}"] = told(Fate.GUESSED, "60 degrees; it is not in the bag")
    elif not rectified and (unread := unread_lens(info)):
        robot.notes[f"calibration of {name}"] = unread
    return intrinsics or assumed_intrinsics(width, height)


def _with_depth(
    robot: RobotStreams, name: str, pictures: Readings[LoggedFrame], intrinsics: Intrinsics, topic: str, stream: Stream
) -> Readings[LoggedFrame]:
    """Return pictures with the depth of another topic, where the times match."""
    robot.count_odd(topic, stream)
    robot.notes[f"depth of {name}"] = f"topic {topic}"
    depths: Readings[Any] = robot.readings(topic, stream, lambda message, _: depth_of(message, intrinsics))
    partner = partners(pictures.stamps, depths.stamps, tolerance=TOGETHER).tolist()

    def take(number: int) -> LoggedFrame:
        frame = pictures.take(number)
        other = partner[number]
        if other < 0:
            return frame
        try:
            return replace(frame, depth=depths.take(other), depth_stamp=float(depths.stamps[other]))
        except DamagedReadingError as error:
            robot.damage.add(f"depth of {name}", error)
            return frame

    return Readings(pictures.stamps, take)


def _size(stream: Stream) -> tuple[int, int]:
    """Return width and height of the pictures of a stream [px]."""
    width, height, *_ = stream.usual() or (0, 0)
    return width, height


def _is_of_depth(stream: Stream) -> bool:
    return (stream.usual() or (0,))[-1] == 1


def _belong(pictures: Stream, depths: Stream) -> bool:
    """Return whether depth is registered to the pixels of a camera."""
    frames = [frame_name(stream.first.header.frame_id) for stream in (pictures, depths)]
    return frames[0] == frames[1] and _size(pictures) == _size(depths)


def _depth_frame(message: Any, stamp: float, intrinsics: Intrinsics) -> LoggedFrame:
    """Return the frame of a camera that only has depth, with a grey picture of it."""
    depth = depth_of(message, intrinsics)
    return logged_frame(CameraFrame(stamp, shown_depth(depth), intrinsics, depth))
