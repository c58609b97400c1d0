"""Converts bags of ROS 1 and ROS 2 to logs of robots.

A bag is read twice: the first pass keeps everything except pictures and scans, of which it keeps the times; the second
reads scans and pictures while their ticks are written. So the memory depends on the logged motion, not on the pictures.

Times are those in the headers of messages; without a header, the time of recording.
"""

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from mjsim.errors import LONGEST_MESSAGE, UsageError
from mjsim.geometry import Array, Pose, Pose3
from mjsim.interface import CameraFrame, Intrinsics, PointCloud, Scan, swept
from mjsim.logs.bags.bag_clouds import cloud_of
from mjsim.logs.bags.bag_contents import Contents, Moves, Stream, moving_in_tf, times_of, unread_topics
from mjsim.logs.bags.bag_file import Bag, BagMessages, is_bag
from mjsim.logs.bags.bag_frames import frame_name, is_base, level_mount, mount_of
from mjsim.logs.bags.bag_gps import gps_poses
from mjsim.logs.bags.bag_messages import (
    UPSIDE_DOWN,
    assumed_intrinsics,
    intrinsics_of,
    is_clockwise,
    scan_of,
    unread_lens,
)
from mjsim.logs.bags.bag_pictures import depth_of, frame_of, shown_depth
from mjsim.logs.bags.bag_topics import ODOMETRY, TRANSFORMS, RobotTopics, plain_topic, robots_of
from mjsim.logs.resampling import (
    AHEAD,
    NO_ODOMETRY,
    RESTARTS,
    TOGETHER,
    Damage,
    DamagedReadingError,
    InertialTable,
    Log,
    Mount,
    Readings,
    RobotLog,
    Wishes,
    beam_times,
    continuous,
    last_beam,
    longest_gap,
    partners,
    track_of,
)
from mjsim.record import LoggedCamera, LoggedFrame, logged_frame

__all__ = ["is_bag", "read_bag"]
GAP = 0.5
"""Maximum time between two poses of the truth to interpolate [s]."""
MAX_BEAMS = 10_000
"""Maximum number of beams of a scan in a recording."""


def read_bag(path: Path, wishes: Wishes, stack: ExitStack) -> list[Log]:
    """Return the log of each robot in a bag.

    Args:
        path: A file, or the folder of a bag of ROS 2.
        wishes: Options of the user: topics, robots and deskewing.
        stack: Keeps the bag open while scans and pictures are read.

    Raises:
        UsageError: It is not a bag, has no supported topic, or the choice of a topic is ambiguous.
    """
    bag = stack.enter_context(Bag(path))
    moving = () if ODOMETRY in bag.types.values() else moving_in_tf(bag)
    robots = robots_of(bag.types, topics_by_kind=wishes.topics, names=wishes.robots, moving=moving)
    if not any(robot.all() for robot in robots) and not any(kind in TRANSFORMS for kind in bag.types.values()):
        types = ", ".join(sorted(set(bag.types.values()))) or "nothing"
        line = f"'{path}' holds no odometry, scans, clouds, pictures or IMU of ROS; it has {types}"
        raise UsageError(line[:LONGEST_MESSAGE])
    contents = Contents(bag, robots)
    messages = BagMessages(bag, times_of(contents.streams))
    logs = [_Robot(bag, contents, messages, robot, deskew=wishes.deskew).log() for robot in robots]
    if len(logs) > 1:
        logs = [
            replace(log, notes={f"{fact} of {log.name}": value for fact, value in log.notes.items()}) for log in logs
        ]
    broken = {"bag breaks off": bag.cut, "metadata.yaml left out": bag.misdescribed}
    shared = {**contents.left_out_of(robots), **contents.notes, **unread_topics(bag, robots)}
    shared |= {fact: why for fact, why in broken.items() if why}
    return [replace(logs[0], notes={**logs[0].notes, **shared}), *logs[1:]]


class _Robot:
    """One robot of a bag."""

    def __init__(
        self, bag: Bag, contents: Contents, messages: BagMessages, topics: RobotTopics, *, deskew: bool
    ) -> None:
        self._bag, self._contents, self._messages, self._topics = bag, contents, messages, topics
        self._deskew = deskew
        self._frames = contents.frames_of(topics.space)
        self._notes, self._damage = dict[str, str](), Damage()
        self._odometry = self._moves(topics.odometry) or self._transformed()
        self._track = None if self._odometry is None else self._odometry.planar()
        if self._track is not None:
            self._track, restarted = continuous(self._track)
            self._notes |= {RESTARTS: restarted} if restarted else {}
        if self._track is None:
            self._notes.setdefault("odometry", NO_ODOMETRY)
        elif self._odometry is not None and self._odometry.by_twists():
            self._notes["odometry"] = f"twists of topic {topics.odometry}; it has no poses, or they never change"
        self._base = self._base_frame()

    def _base_frame(self) -> str | None:
        """Return the frame of the robot: the child frame of odometry, or a usual one if that is not in /tf."""
        child = self._odometry.child if self._odometry is not None else ""
        usual = self._frames.base(self._topics.space)
        if child and usual is not None and child not in self._frames:
            self._notes["odometry's frame"] = f"{child} is not in /tf; it is assumed to be {usual}"
            return usual
        return child or usual

    def log(self) -> Log:
        """Return its log."""
        topics = self._topics
        mounts, scans = self._scans()
        cameras, frames = self._cameras()
        clouds, tops = self._clouds()
        readings, places = self._imu()
        twists = self._twists()
        gps = self._gps(self._track if self._track is not None or not len(twists) else track_of(twists))
        robot = RobotLog(
            twists=twists,
            track=self._track,
            scans=scans,
            clouds=clouds,
            cameras=frames,
            imu=readings,
            truth=gps,
            poses=self._truth(),
            gap=GAP if gps is None else longest_gap(gps),
            damage=self._damage,
        )
        return Log(
            kind="bag of ROS 2" if self._bag.is_ros2 else "bag of ROS 1",
            robot=robot,
            name=topics.name,
            mounts={**mounts, **tops, **places},
            cameras=cameras,
            notes=self._notes,
        )

    def _twists(self) -> Array:
        """Return the commands, or else the twists of odometry, rows as in `RobotLog.twists`."""
        commanded = self._contents.moves.get(self._topics.command or "")
        if commanded is not None and commanded.twists:
            source = f"topic {self._topics.command}"
            self._notes["commands"] = source
            if self._track is None:
                self._notes["odometry"] = f"none; the robot is assumed to follow {source}"
            return commanded.table(commanded.twists)
        if self._odometry is None or not self._odometry.twists:
            return np.zeros((0, 3))
        return self._odometry.table(self._odometry.twists)

    def _moves(self, topic: str | None) -> Moves | None:
        moves = self._contents.moves.get(topic or "")
        return moves if moves is not None and (moves.rows or moves.by_twists()) else None

    def _transformed(self) -> Moves | None:
        """Return odometry from /tf, if there is no odometry topic."""
        if self._topics.odometry is not None:
            return None
        carried = self._contents.carried
        name = self._topics.space
        own = [moves for (space, child), moves in carried.items() if name in (space, child.partition("/")[0])]
        found = own or list(carried.values())
        found = [moves for moves in found if is_base(moves.child)] or found
        if len(found) != 1:
            if found:
                frames = ", ".join(moves.child for moves in found)
                self._notes["odometry"] = f"none; /tf has several frames that move, {frames}"
            return None
        self._notes["odometry"] = f"frame {found[0].child} in /tf"
        return found[0]

    def _truth(self) -> Array | None:
        """Return the true poses of the robot's frame, rows of time and 3-D pose, shape (N, 8)."""
        moves = self._moves(self._topics.truth)
        if moves is None or not moves.rows:
            return None
        self._notes["truth"] = f"topic {self._topics.truth}"
        table = moves.table(moves.rows)
        if not moves.child or self._base is None or moves.child == self._base:
            return table
        child_from_base = self._frames.between(moves.child, self._base)
        if child_from_base is None:
            return table
        for row in table:
            row[1:] = Pose3.from_matrix(Pose3(*row[1:].tolist()).matrix() @ child_from_base).as_array()
        return table

    def _gps(self, track: Array | None) -> Array | None:
        """Return the true poses of the robot's frame by a satellite receiver and odometry, as in `RobotLog.truth`."""
        topic = self._topics.gps
        fixes = self._contents.fixes.get(topic or "")
        if topic is None or not fixes:
            return None
        if track is None or not np.ptp(track[:, 1:], axis=0).any():
            self._notes["truth"] = f"none; without odometry the heading at {len(fixes)} fixes of {topic} is unknown"
            return None
        antenna = self._place("the antenna", self._contents.fix_frames[topic])
        x, y = (0.0, 0.0) if antenna is None else antenna[:2, 3].tolist()
        found = gps_poses(fixes, track, (x, y))
        if len(found.rows) < 2:
            self._notes["truth"] = f"none; {len(fixes)} fixes of {topic} are too close together to give a heading"
            return None
        self._notes["truth"] = f"{len(found.rows)} fixes of topic {topic}; {found.about}"
        self._notes["fixes left out that had jumped"] = str(found.jumped)
        return found.rows

    def _place(self, name: str, frame: str) -> Array | None:
        """Return robot_from_sensor from the frames of the bag, shape (4, 4) [m]; None if they do not contain it."""
        place = None if self._base is None else self._frames.between(self._base, frame)
        if place is None:
            self._notes[f"place of {name}"] = "not in the bag; a guess"
        return place

    def _stream(self, topic: str) -> Stream | None:
        stream = self._contents.streams.get(topic)
        return None if stream is None or not len(stream.numbers()) else stream

    def _scans(self) -> tuple[dict[str, Mount], dict[str, Readings[Scan]]]:
        mounts: dict[str, Mount] = {}
        scans: dict[str, Readings[Scan]] = {}
        for name, topic in self._topics.scan.items():
            stream = self._stream(topic)
            if stream is None:
                continue
            if (beams := (stream.usual() or (0,))[0]) > MAX_BEAMS:
                raise UsageError(
                    f"'{self._bag.path}': scans on '{topic}' have {beams:,} beams; a lidar has at most {MAX_BEAMS:,}"
                )
            place = self._place(name, frame_name(stream.first.header.frame_id))
            mounts[name] = Mount() if place is None else mount_of(place)
            hangs = place is not None and float(place[2, 2]) < UPSIDE_DOWN
            if place is not None and abs(float(place[2, 2])) < -UPSIDE_DOWN:
                self._notes[f"place of {name}"] = "not level; scans are treated as if it were"
            scans[name] = self._timed_scans(topic, stream, mounts[name], upside_down=hangs, beams=beams)
            if not self._deskew and (lasting := last_beam(stream.first, np.array(stream.stamps)[stream.numbers()])):
                self._notes[f"sweep of {name}"] = f"{abs(lasting):.3f} s; beams stay as measured without --deskew"
            self._count_odd(topic, stream)
            if others := sum(stream.kinds[number] != (beams,) for number in stream.numbers().tolist()):
                self._notes[f"beams of {name}"] = f"{others} scans have more or fewer; resampled to {beams}"
        return mounts, scans

    def _timed_scans(
        self, topic: str, stream: Stream, mount: Mount, *, upside_down: bool, beams: int
    ) -> Readings[Scan]:
        """Return the scans of a lidar; deskewed, each is as seen from where the robot was at its last beam."""
        take, track = partial(scan_of, upside_down=upside_down, beams=beams), self._track
        robot_from_lidar = Pose(*mount.at[:2], mount.yaw)
        last = last_beam(stream.first, np.array(stream.stamps)[stream.numbers()])
        if not (self._deskew and last) or track is None:
            return self._readings(topic, stream, take)

        def make(message: Any, stamp: float) -> Scan:
            times = beam_times(message, beams, reverse=is_clockwise(message, upside_down=upside_down))
            return swept(take(message, stamp), times - max(last, 0.0), track, robot_from_lidar)

        return self._readings(topic, stream, make, later=max(last, 0.0))

    def _clouds(self) -> tuple[dict[str, Readings[PointCloud]], dict[str, Mount]]:
        """Return clouds rotated to the axes of the robot, and the mounts of the lidars."""
        clouds: dict[str, Readings[PointCloud]] = {}
        mounts: dict[str, Mount] = {}
        for name, topic in self._topics.cloud.items():
            stream = self._stream(topic)
            if stream is None:
                continue
            place = self._place(name, frame_name(stream.first.header.frame_id))
            mounts[name] = Mount() if place is None else level_mount(place)
            turned = np.eye(4) if place is None else place
            clouds[name] = self._readings(topic, stream, partial(cloud_of, robot_from_sensor=turned))
            self._count_odd(topic, stream)
        return clouds, mounts

    def _readings(self, topic: str, stream: Stream, make: Callable[..., Any], *, later: float = 0.0) -> Readings[Any]:
        """Return the readings of a stream, each made on request from its message and its stamp, moved `later` [s]."""
        numbers = stream.numbers()
        stamps = np.array(stream.stamps)[numbers] + later

        def take(number: int) -> Any:
            message = self._messages.take(topic, int(numbers[number]))
            try:
                return make(self._bag.decode(message), float(stamps[number]))
            except ValueError as error:
                raise DamagedReadingError(f"{topic} at {stamps[number]:.3f} s: {error}") from None

        return Readings(stamps, take)

    def _count_odd(self, topic: str, stream: Stream) -> None:
        self._contents.left_out[topic] = len(stream.stamps) - len(stream.numbers())

    def _cameras(self) -> tuple[dict[str, LoggedCamera], dict[str, Readings[LoggedFrame]]]:
        """Return data sheets and pictures; depth of the same frame and size belongs to a picture."""
        found = {name: (topic, self._stream(topic)) for name, topic in self._topics.camera.items()}
        streams = {name: (topic, stream) for name, (topic, stream) in found.items() if stream is not None}
        depths = {name: each for name, each in streams.items() if _is_of_depth(each[1])}
        cameras: dict[str, LoggedCamera] = {}
        frames: dict[str, Readings[LoggedFrame]] = {}
        for name in [name for name in streams if name not in depths]:
            topic, stream = streams[name]
            camera, pictures = self._camera(name, topic, stream, frame_of)
            partner = next((other for other in depths if _belong(stream, depths[other][1])), None)
            if partner is not None:
                pictures = self._with_depth(name, pictures, camera.intrinsics, *depths.pop(partner))
                camera = replace(camera, has_depth=True)
            cameras[name], frames[name] = camera, pictures
        for name, (topic, stream) in depths.items():
            camera, frames[name] = self._camera(name, topic, stream, _depth_frame)
            cameras[name] = replace(camera, has_depth=True)
        return cameras, frames

    def _camera(
        self, name: str, topic: str, stream: Stream, make: Callable[[Any, float, Intrinsics], LoggedFrame]
    ) -> tuple[LoggedCamera, Readings[LoggedFrame]]:
        """Return the data sheet and the pictures of a topic."""
        self._count_odd(topic, stream)
        width, height = _size(stream)
        place = self._place(name, frame_name(stream.first.header.frame_id))
        intrinsics = self._intrinsics(name, topic, width, height)
        camera = LoggedCamera(intrinsics, AHEAD if place is None else place)
        return camera, self._readings(topic, stream, lambda message, stamp: make(message, stamp, intrinsics))

    def _intrinsics(self, name: str, topic: str, width: int, height: int) -> Intrinsics:
        """Return the calibration beside a topic of pictures [px]."""
        plain = plain_topic(topic)
        info = self._contents.infos.get(f"{plain.rpartition('/')[0]}/camera_info")
        rectified = "rect" in plain.rpartition("/")[2]
        intrinsics = None if info is None else intrinsics_of(info, width=width, height=height, rectified=rectified)
        if intrinsics is None:
            self._notes[f"calibration of {name}"] = "not in the bag; 60 degrees are assumed"
        elif not rectified and (unread := unread_lens(info)):
            self._notes[f"calibration of {name}"] = unread
        return intrinsics or assumed_intrinsics(width, height)

    def _with_depth(
        self, name: str, pictures: Readings[LoggedFrame], intrinsics: Intrinsics, topic: str, stream: Stream
    ) -> Readings[LoggedFrame]:
        """Return pictures with the depth of another topic, where the times match."""
        self._count_odd(topic, stream)
        self._notes[f"depth of {name}"] = f"topic {topic}"
        depths: Readings[Any] = self._readings(topic, stream, lambda message, _: depth_of(message, intrinsics))
        partner = partners(pictures.stamps, depths.stamps, tolerance=TOGETHER).tolist()

        def take(number: int) -> LoggedFrame:
            frame = pictures.take(number)
            other = partner[number]
            if other < 0:
                return frame
            try:
                return replace(frame, depth=depths.take(other), depth_stamp=float(depths.stamps[other]))
            except DamagedReadingError as error:
                self._damage.add(f"depth of {name}", error)
                return frame

        return Readings(pictures.stamps, take)

    def _imu(self) -> tuple[InertialTable, dict[str, Mount]]:
        """Return inertial readings rotated to the axes of the robot, and the sensors' mounts."""
        tables: dict[str, Array] = {}
        mounts: dict[str, Mount] = {}
        for name, topic in self._topics.imu.items():
            if not (recorded := self._contents.imus.pop(topic, None)):
                continue
            place = self._place(name, self._contents.imu_frames[topic])
            place = np.eye(4) if place is None else place
            mounts[name] = level_mount(place)
            rows = np.array(recorded).reshape(-1, 7)
            for columns in (slice(1, 4), slice(4, 7)):
                rows[:, columns] = rows[:, columns] @ place[:3, :3].T
            tables[name] = rows
        return InertialTable(tables), mounts


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
