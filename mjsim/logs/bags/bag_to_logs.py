"""Converts bags of ROS 1 and ROS 2 to logs of robots.

A bag is read twice: the first pass keeps everything except pictures and scans, of which it keeps the times; the second
reads scans and pictures while their ticks are written. So memory use depends on the logged motion, not on the pictures.

Times are those in the headers of messages; without a header, the time of recording.
"""

import math
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from mjsim.errors import MAX_MESSAGE_LENGTH, UsageError
from mjsim.geometry import Array, Pose, Pose3
from mjsim.interface import PointCloud, Scan, swept
from mjsim.inventory import Fate, told
from mjsim.logs.bags.bag_cameras import cameras_of
from mjsim.logs.bags.bag_clouds import cloud_of
from mjsim.logs.bags.bag_contents import Contents, Moves, Stream, moving_in_tf, times_of, unread_topics
from mjsim.logs.bags.bag_file import Bag, BagMessages, is_bag
from mjsim.logs.bags.bag_frames import frame_name, is_base, level_mount, mount_of
from mjsim.logs.bags.bag_gps import gps_poses
from mjsim.logs.bags.bag_messages import (
    UPSIDE_DOWN,
    is_clockwise,
    limits_of,
    range_unit,
    scan_of,
)
from mjsim.logs.bags.bag_streams import RobotStreams
from mjsim.logs.bags.bag_topics import ODOMETRY, TRANSFORMS, RobotTopics, robots_of
from mjsim.logs.resampling import (
    NO_ODOMETRY,
    RESTARTS,
    InertialTable,
    Log,
    Mount,
    Readings,
    RobotLog,
    Wishes,
    beam_times,
    continuous,
    instead_of_log,
    last_beam,
    longest_gap,
    track_of,
)

__all__ = ["is_bag", "read_bag"]
MAX_TRUTH_GAP = 0.5
"""Maximum time between two poses of the truth to interpolate [s]."""
GRAVITY, ONE_G = 9.80665, (0.8, 1.2)
"""Standard gravity [m/s^2], and the range within which an accelerometer in g measures it at rest."""
MAX_TURN_RATE, MAX_SPEED = 40.0, 40.0
"""Maximum turn rate of any gyroscope, and maximum speed of any indoor robot [rad/s, m/s]."""
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
        instead = instead_of_log(path, types)
        line = f"'{path}' holds no odometry, scans, clouds, pictures or IMU of ROS; {instead} (it has {types})"
        raise UsageError(line[:MAX_MESSAGE_LENGTH])
    contents = Contents(bag, robots)
    messages = BagMessages(bag, times_of(contents.streams))
    streams = [RobotStreams(bag, contents, messages, space=robot.space) for robot in robots]
    logs = [_Robot(of, robot, deskew=wishes.deskew).log() for of, robot in zip(streams, robots, strict=True)]
    if len(logs) > 1:
        logs = [replace(log, notes={f"{log.name} {fact}": value for fact, value in log.notes.items()}) for log in logs]
    broken = {"bag breaks off": bag.cut and told(Fate.LEFT_OUT, bag.cut), "metadata.yaml left out": bag.misdescribed}
    shared = {**contents.left_out_of(robots), **contents.notes, **unread_topics(bag, robots)}
    shared |= {fact: why for fact, why in broken.items() if why}
    return [replace(logs[0], notes={**logs[0].notes, **shared}), *logs[1:]]


class _Robot:
    """One robot of a bag."""

    def __init__(self, streams: RobotStreams, topics: RobotTopics, *, deskew: bool) -> None:
        self._streams, self._topics, self._deskew = streams, topics, deskew
        self._contents, self._notes = streams.contents, streams.notes
        self._odometry = self._moves(topics.odometry) or self._transformed()
        self._track = None if self._odometry is None else self._odometry.planar()
        self._tell_speed()
        if self._track is not None:
            self._track, restarted = continuous(self._track)
            self._notes |= {RESTARTS: restarted} if restarted else {}
        if self._track is None:
            self._notes.setdefault("odometry", NO_ODOMETRY)
        elif self._odometry is not None and self._odometry.by_twists():
            self._notes["odometry"] = f"twists of topic {topics.odometry}; it has no poses, or they never change"
        elif topics.odometry is not None:
            self._notes["odometry"] = f"topic {topics.odometry}"
        self._streams.base = self._base_frame()

    def _tell_speed(self) -> None:
        """Note an odometry that moves faster than any robot, such as one in millimetres."""
        if self._track is None or len(self._track) < 2:
            return
        steps = np.diff(self._track, axis=0)
        moving = steps[(steps[:, 0] > 0.0) & steps[:, 1:3].any(axis=1)]
        speed = float(np.median(np.hypot(moving[:, 1], moving[:, 2]) / moving[:, 0])) if len(moving) else 0.0
        if speed > MAX_SPEED:
            self._notes["speed of odometry"] = told(
                Fate.GUESSED,
                f"{speed:.4g} m/s (median), as ROS uses metres; if it is in mm, divide it by 1000 first",
            )

    def _base_frame(self) -> str | None:
        """Return the frame of the robot: the child frame of odometry, or a usual one if that is not in /tf."""
        child = self._odometry.child if self._odometry is not None else ""
        usual = self._streams.frames.base(self._topics.space)
        if child and usual is not None and child not in self._streams.frames:
            self._notes["odometry's frame"] = told(Fate.GUESSED, f"{usual}, since {child} is not in /tf")
            return usual
        if child and usual is not None and not is_base(child):
            self._notes["odometry's frame"] = told(Fate.KEPT, f"{child}, which is the robot's here, not {usual}")
        return child or usual

    def log(self) -> Log:
        """Return its log."""
        topics = self._topics
        mounts, scans = self._scans()
        cameras, frames = cameras_of(self._streams, topics.camera)
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
            gap=MAX_TRUTH_GAP if gps is None else longest_gap(gps),
            damage=self._streams.damage,
        )
        return Log(
            kind="bag of ROS 2" if self._streams.bag.is_ros2 else "bag of ROS 1",
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
                self._notes["odometry"] = told(Fate.GUESSED, f"none; the robot follows {source}")
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
                self._notes["odometry"] = told(Fate.LEFT_OUT, f"/tf has several frames that move, {frames}")
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
        if not moves.child or self._streams.base is None or moves.child == self._streams.base:
            return table
        child_from_base = self._streams.frames.between(moves.child, self._streams.base)
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
            self._notes["truth"] = told(
                Fate.LEFT_OUT, f"without odometry the heading at {len(fixes)} fixes of {topic} is unknown"
            )
            return None
        antenna = self._streams.place("the antenna", self._contents.fix_frames[topic])
        x, y = (0.0, 0.0) if antenna is None else antenna[:2, 3].tolist()
        found = gps_poses(fixes, track, (x, y))
        if len(found.rows) < 2:
            self._notes["truth"] = told(
                Fate.LEFT_OUT, f"{len(fixes)} fixes of {topic} are too close together to give a heading"
            )
            return None
        self._notes["truth"] = f"{len(found.rows)} fixes of topic {topic}; {found.about}"
        self._notes["outlier fixes left out"] = str(found.jumped)
        return found.rows

    def _scans(self) -> tuple[dict[str, Mount], dict[str, Readings[Scan]]]:
        mounts: dict[str, Mount] = {}
        scans: dict[str, Readings[Scan]] = {}
        for name, topic in self._topics.scan.items():
            stream = self._streams.stream(topic)
            if stream is None:
                continue
            if (beams := (stream.usual() or (0,))[0]) > MAX_BEAMS:
                path = self._streams.bag.path
                raise UsageError(
                    f"'{path}': scans on '{topic}' have {beams:,} beams; a lidar has at most {MAX_BEAMS:,}"
                )
            place = self._streams.place(name, frame_name(stream.first.header.frame_id))
            mounts[name] = Mount() if place is None else mount_of(place)
            hangs = place is not None and float(place[2, 2]) < UPSIDE_DOWN
            if place is not None and abs(float(place[2, 2])) < -UPSIDE_DOWN:
                self._notes[f"place of {name}"] = told(Fate.GUESSED, "level, although it is tilted")
            given, taken = (stream.first.range_min, stream.first.range_max), limits_of(stream.first)
            if not np.allclose(given, taken):
                limits = f"{taken[0]:.4g} to {taken[1]:.4g} m; the bag gives {given[0]:.4g} to {given[1]:.4g}"
                limits += ", which can only be in mm" if range_unit(stream.first) < 1.0 else ""
                self._notes[f"range limits of {name}"] = told(Fate.GUESSED, limits)
            if not stream.has_returns:
                limits = f"{stream.first.range_min:.4g} to {stream.first.range_max:.4g} m"
                self._notes[f"returns of {name}"] = told(Fate.KEPT, f"none: no range is a number from {limits}")
            scans[name] = self._timed_scans(topic, stream, mounts[name], upside_down=hangs, beams=beams)
            if not self._deskew and (lasting := last_beam(stream.first, np.array(stream.stamps)[stream.numbers()])):
                self._notes[f"sweep of {name}"] = f"{abs(lasting):.3f} s; beams stay as measured without --deskew"
            self._streams.count_odd(topic, stream)
            if others := sum(stream.kinds[number] != (beams,) for number in stream.numbers().tolist()):
                self._notes[f"beams of {name}"] = told(
                    Fate.MENDED, f"{others} scans have more or fewer; resampled to {beams}"
                )
        return mounts, scans

    def _timed_scans(
        self, topic: str, stream: Stream, mount: Mount, *, upside_down: bool, beams: int
    ) -> Readings[Scan]:
        """Return the scans of a lidar; deskewed, each is as seen from where the robot was at its last beam."""
        take, track = partial(scan_of, upside_down=upside_down, beams=beams), self._track
        robot_from_lidar = Pose(*mount.at[:2], mount.yaw)
        last = last_beam(stream.first, np.array(stream.stamps)[stream.numbers()])
        if not (self._deskew and last) or track is None:
            return self._streams.readings(topic, stream, take)

        def make(message: Any, stamp: float) -> Scan:
            times = beam_times(message, beams, reverse=is_clockwise(message, upside_down=upside_down))
            return swept(take(message, stamp), times - max(last, 0.0), track, robot_from_lidar)

        return self._streams.readings(topic, stream, make, later=max(last, 0.0))

    def _clouds(self) -> tuple[dict[str, Readings[PointCloud]], dict[str, Mount]]:
        """Return clouds rotated to the axes of the robot, and the mounts of the lidars."""
        clouds: dict[str, Readings[PointCloud]] = {}
        mounts: dict[str, Mount] = {}
        for name, topic in self._topics.cloud.items():
            stream = self._streams.stream(topic)
            if stream is None:
                continue
            place = self._streams.place(name, frame_name(stream.first.header.frame_id))
            mounts[name] = Mount() if place is None else level_mount(place)
            turned = np.eye(4) if place is None else place
            if not stream.has_returns:
                self._notes[f"points of {name}"] = told(Fate.KEPT, "none: all clouds are empty")
            units = self._contents.units[topic]
            self._notes |= {f"{what} of points of {name}": note for what, note in units.notes}
            take = partial(cloud_of, robot_from_sensor=turned, units=units)
            clouds[name] = self._streams.readings(topic, stream, take)
            self._streams.count_odd(topic, stream)
        return clouds, mounts

    def _imu(self) -> tuple[InertialTable, dict[str, Mount]]:
        """Return inertial readings rotated to the axes of the robot, and the sensors' mounts."""
        tables: dict[str, Array] = {}
        mounts: dict[str, Mount] = {}
        for name, topic in self._topics.imu.items():
            if not (recorded := self._contents.imus.pop(topic, None)):
                continue
            place = self._streams.place(name, self._contents.imu_frames[topic])
            place = np.eye(4) if place is None else place
            mounts[name] = level_mount(place)
            rows = np.array(recorded).reshape(-1, 7)
            for columns in (slice(1, 4), slice(4, 7)):
                rows[:, columns] = rows[:, columns] @ place[:3, :3].T
            felt = float(np.nanmedian(np.linalg.norm(rows[:, 1:4], axis=1))) if np.isfinite(rows[:, 1]).any() else 0.0
            if ONE_G[0] < felt < ONE_G[1]:
                rows[:, 1:4] *= GRAVITY
                self._notes[f"acceleration of {name}"] = told(
                    Fate.GUESSED, f"in g, not m/s^2: its median is {felt:.2f}"
                )
            # A few readings may be faults.
            turn = float(np.quantile(np.nan_to_num(np.abs(rows[:, 4:7]).max(axis=1)), 0.98))
            if turn > MAX_TURN_RATE:
                rows[:, 4:7] *= math.pi / 180.0
                self._notes[f"turn rate of {name}"] = told(Fate.GUESSED, f"in deg/s, not rad/s: it reaches {turn:.3g}")
            tables[name] = rows
        return InertialTable(tables), mounts
