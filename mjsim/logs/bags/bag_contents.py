"""The first pass over a bag: keeps motion and inertial readings, and the times of scans and pictures."""

from array import array
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial, reduce
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjsim.errors import MAX_MESSAGE_LENGTH
from mjsim.geometry import Array, Pose3
from mjsim.logs.bags.bag_clocks import Clocks
from mjsim.logs.bags.bag_clouds import CloudUnits, end_of, units_of
from mjsim.logs.bags.bag_file import Bag, RosMessage
from mjsim.logs.bags.bag_frames import FrameTree, frame_name, is_odometry, matrix_of
from mjsim.logs.bags.bag_gps import Fix, fix_of
from mjsim.logs.bags.bag_messages import imu_of, pose_of, scan_of, twist_of
from mjsim.logs.bags.bag_pictures import is_depth, size_of
from mjsim.logs.bags.bag_topics import INFO, TRANSFORMS, TWISTS, RobotTopics, robot_of
from mjsim.logs.resampling import rising, track_of

MAX_TRANSFORMS = 5000
"""Maximum number of transforms per topic from which poses of sensors are taken."""
MAX_BAG_LENGTHS, EXTRA_SECONDS = 10.0, 3600.0
"""Times farther from the median than this many lengths of the bag plus this many seconds are wrong [1, s]."""
UNSTAMPED = ("geometry_msgs/msg/Twist", *TRANSFORMS)
"""Types without a header at their beginning."""
MAX_SIMULATED = 1e8
"""Stamps below are of a simulation, or count from the start of a robot; those since 1970 are far above [s]."""
MAX_UNSET = 1000
"""Maximum number of messages that are searched for a stamp above 0, or for a moving frame."""
MAX_UNITS = 12
"""Number of clouds from which their units are derived."""
BEAMS_TOLERANCE = 0.2
"""Fraction by which the beams of a scan may differ from the usual number; cheap lidars vary with their motors."""


@dataclass(slots=True)
class Stream:
    """A topic of scans or pictures, which is read in the second pass."""

    times: list[int] = field(default_factory=list)
    """When its messages were recorded [ns]."""
    stamps: list[float] = field(default_factory=list)
    """When they were taken; NaN for unusable messages [s]."""
    kinds: list[tuple[int, ...] | None] = field(default_factory=list)
    """Shape of each message, usually constant for a sensor: number of beams, or size."""
    first: Any = None
    """The first valid message."""
    has_returns: bool = False
    """Whether any scan has a beam, or any cloud a point, that came back."""
    tolerance: float = 0.0
    """Fraction by which numbers in a shape may differ from the most common ones."""

    def usual(self) -> tuple[int, ...] | None:
        """Return the most common shape of its messages; None without messages."""
        known = [kind for kind in self.kinds if kind is not None]
        return Counter(known).most_common(1)[0][0] if known else None

    def numbers(self) -> NDArray[np.intp]:
        """Return the indices of usable messages in order of time."""
        stamps, usual = np.array(self.stamps), self.usual()
        fits = [kind is not None and usual is not None and self._fits(kind, usual) for kind in self.kinds]
        fit = np.array(fits, dtype=bool) & np.isfinite(stamps)
        chosen = np.flatnonzero(fit)
        return np.asarray(chosen[rising(stamps[chosen])], dtype=np.intp)

    def _fits(self, kind: tuple[int, ...], usual: tuple[int, ...]) -> bool:
        return all(abs(n - m) <= self.tolerance * m for n, m in zip(kind, usual, strict=True))


@dataclass(slots=True)
class Moves:
    """A topic of poses."""

    rows: list[tuple[float, ...]] = field(default_factory=list)
    """Time [s], then x, y, z [m] and quaternion x, y, z, w."""
    twists: list[tuple[float, ...]] = field(default_factory=list)
    """Time [s], forward [m/s], turn [rad/s] and left [m/s]."""
    child: str = ""
    """Name of the frame that moves."""

    def planar(self) -> Array | None:
        """Return time, x, y [m] and heading [rad] of its poses, or integrated from its twists, shape (N, 4)."""
        if self.by_twists():
            return track_of(self.table(self.twists))
        if not self.rows:
            return None
        rows = self.table(self.rows)
        places = (Pose3(*row).planar().as_array() for row in rows[:, 1:].tolist())
        return np.array([[time, *place] for time, place in zip(rows[:, 0].tolist(), places, strict=True)])

    def by_twists(self) -> bool:
        """Return whether its motion must be taken from twists: it has no poses, or they never change."""
        return any(any(row[1:]) for row in self.twists) and all(row[1:] == self.rows[0][1:] for row in self.rows)

    def table(self, rows: Sequence[tuple[float, ...]]) -> Array:
        """Return rows in order of time, shape (N, columns)."""
        table = np.array(rows, dtype=float)
        return table[np.argsort(table[:, 0], kind="stable")]


class Contents:
    """Contents of a bag."""

    def __init__(self, bag: Bag, robots: Sequence[RobotTopics]) -> None:
        """Read the bag once, and again if clocks jumped."""
        self._bag, self._clocks = bag, Clocks(bag.set_back)
        self._takes = self._roles(robots)
        self._shared = robots[0].shared
        self._needs_odometry = any(robot.odometry is None for robot in robots)
        self._simulated = self._is_simulated()
        self.units = {topic: self._units_of(topic) for robot in robots for topic in robot.cloud.values()}
        """By topic of clouds."""
        self._read()
        self.notes = self._clocks.settle()
        """Notes about clocks for the metadata."""
        if self.notes:
            self._read()

    def _is_simulated(self) -> bool:
        """Return whether the clock of the headers begins at 0, so that a stamp of 0 is a time, not a missing one."""
        stamped = {topic for topic in self._takes if self._bag.types[topic] not in UNSTAMPED}
        stamps = map(self._bag.stamp, islice(self._bag.messages(stamped), MAX_UNSET))
        return 0.0 < next(filter(None, stamps), 0.0) < MAX_SIMULATED

    def _units_of(self, topic: str) -> CloudUnits:
        clouds = []
        for message in islice(self._bag.messages({topic}), MAX_UNITS):
            with suppress(ValueError):
                clouds.append(self._bag.decode(message))
        return units_of(clouds)

    def _read(self) -> None:
        """Read the bag."""
        self._frames: dict[str, FrameTree] = {}
        """Robot in whose namespace a topic of transforms is, or '' -> its frames."""
        self.streams: dict[str, Stream] = {}
        self.moves: dict[str, Moves] = {}
        """By topic: poses of odometry and truth, twists of commands."""
        self.carried: dict[tuple[str, str], Moves] = {}
        """Robot as in `_frames`, and its frame -> poses of that frame in the odometry frame, from /tf."""
        self.imus: dict[str, array[float]] = {}
        """By topic: stamp [s], acceleration [m/s^2] and turn rate [rad/s] of each reading, seven numbers each."""
        self.imu_frames: dict[str, str] = {}
        self.fixes: dict[str, list[Fix]] = {}
        self.fix_frames: dict[str, str] = {}
        self.infos: dict[str, Any] = {}
        self.left_out: Counter[str] = Counter()
        self.reasons: dict[str, str] = {}
        """Topic -> why its first invalid message is left out."""
        self._unstamped: set[str] = set()
        """Topics without stamps, whose times are those of the recorder."""
        self._transforms: Counter[str] = Counter()
        first, last = 0, 0
        for message in self._bag.messages(self._takes):
            first, last = first or message.time, max(last, message.time)
            try:
                self._takes[message.topic](message)
            except ValueError as error:
                self.left_out[message.topic] += 1
                self.reasons.setdefault(message.topic, f"{error}"[:MAX_MESSAGE_LENGTH])
        for topic in self._unstamped:
            moves = self.moves[topic]
            times = self._clocks.stamps_at(np.array([row[0] for row in moves.twists]))
            moves.twists = [(time, *row[1:]) for time, row in zip(times.tolist(), moves.twists, strict=True)]
        self._drop_wrong_times((last - first) * 1e-9)

    def frames_of(self, robot: str) -> FrameTree:
        """Return the frames of a robot: those of its namespace and those without; all for a robot without one."""
        own = [self._frames[robot]] if robot in self._frames else []
        others = [tree for name, tree in self._frames.items() if name != robot and not (own and name)]
        return reduce(FrameTree.joined, [*own, *others], FrameTree())

    def left_out_of(self, robots: Sequence[RobotTopics]) -> dict[str, str]:
        """Return the metadata about left-out messages of the topics that are read of robots."""
        topics = [topic for robot in robots for topic in robot.all()]
        counts = {f"{topic} messages left out": str(self.left_out[topic]) for topic in topics}
        return counts | {
            f"first message of {topic} left out": self.reasons[topic] for topic in topics if topic in self.reasons
        }

    def _roles(self, robots: Sequence[RobotTopics]) -> dict[str, Callable[[RosMessage], None]]:
        """Return the handler of the messages of each topic."""
        roles: dict[str, Callable[[RosMessage], None]] = {}
        for topic, kind in self._bag.types.items():
            if kind in TRANSFORMS:
                roles[topic] = self._take_transforms
            elif kind == INFO:
                roles[topic] = self._take_info
        for robot in robots:
            for topic in filter(None, (robot.odometry, robot.truth)):
                roles[topic] = self._take_twist if self._bag.types[topic] in TWISTS else self._take_pose
            if robot.command is not None:
                roles[robot.command] = self._take_twist
            if robot.gps is not None:
                roles[robot.gps] = self._take_fix
            roles |= dict.fromkeys(robot.cloud.values(), self._take_cloud)
            roles |= dict.fromkeys(robot.scan.values(), self._take_scan)
            roles |= dict.fromkeys(robot.camera.values(), self._take_picture)
            roles |= dict.fromkeys(robot.imu.values(), self._take_imu)
        return roles

    def _stamp(self, message: RosMessage) -> float:
        return self._time_of(message, message.topic, self._bag.stamp(message))

    def _time_of(self, message: RosMessage, clock: str, stamp: float) -> float:
        """Return the time of a reading: its stamp, or when it was recorded if it has none [s]."""
        recorded = message.time * 1e-9
        return self._clocks.time(clock, recorded, stamp if stamp or self._simulated else recorded)

    def _take_transforms(self, message: RosMessage) -> None:
        self._transforms[message.topic] += 1
        if not self._needs_odometry and self._transforms[message.topic] > MAX_TRANSFORMS:
            return
        transforms = self._bag.decode(message).transforms
        robot = robot_of(message.topic, self._shared)
        self._frames.setdefault(robot, FrameTree()).add(transforms, fixed=message.topic.endswith("tf_static"))
        if not self._needs_odometry:
            return
        for each in transforms:
            outer, inner = frame_name(each.header.frame_id), frame_name(each.child_frame_id)
            if is_odometry(outer, inner) and not message.topic.endswith("tf_static"):
                stamp = each.header.stamp
                time = self._time_of(message, f"{inner} in {message.topic}", stamp.sec + 1e-9 * stamp.nanosec)
                moves = self.carried.setdefault((robot, inner), Moves(child=inner))
                pose = matrix_of(each.transform.translation, each.transform.rotation)
                moves.rows.append((time, *Pose3.from_matrix(pose).as_array().tolist()))

    def _take_info(self, message: RosMessage) -> None:
        if message.topic not in self.infos:
            self.infos[message.topic] = self._bag.decode(message)

    def _take_pose(self, message: RosMessage) -> None:
        content, time = self._bag.decode(message), self._stamp(message)
        moves = self.moves.setdefault(message.topic, Moves(child=frame_name(getattr(content, "child_frame_id", ""))))
        if hasattr(content, "twist"):
            with suppress(ValueError):
                moves.twists.append((time, *twist_of(content)))
        # If the pose of a message is invalid, its twist still counts.
        moves.rows.append((time, *Pose3.from_matrix(pose_of(content)).as_array().tolist()))

    def _take_twist(self, message: RosMessage) -> None:
        content = self._bag.decode(message)
        if hasattr(content, "header"):
            time, child = self._stamp(message), frame_name(content.header.frame_id)
        else:
            # A plain Twist has no header.
            time, child = message.time * 1e-9, ""
            self._unstamped.add(message.topic)
        self.moves.setdefault(message.topic, Moves(child=child)).twists.append((time, *twist_of(content)))

    def _take_imu(self, message: RosMessage) -> None:
        stamp = self._stamp(message)
        if message.topic not in self.imu_frames:
            self.imu_frames[message.topic] = frame_name(self._bag.decode(message).header.frame_id)
        reading = imu_of(message.data, is_ros2=self._bag.is_ros2)
        self.imus.setdefault(message.topic, array("d")).extend((stamp, *reading))

    def _take_fix(self, message: RosMessage) -> None:
        content = self._bag.decode(message)
        self.fix_frames.setdefault(message.topic, frame_name(content.header.frame_id))
        self.fixes.setdefault(message.topic, []).append(fix_of(content, self._stamp(message)))

    def _take_scan(self, message: RosMessage) -> None:
        stream = self.streams.setdefault(message.topic, Stream(tolerance=BEAMS_TOLERANCE))

        def kind_of(content: Any) -> tuple[int, ...]:
            ranges = scan_of(content, 0.0, upside_down=False).ranges
            stream.has_returns |= bool(np.isfinite(ranges).any())
            return (len(ranges),)

        self._take_streamed(message, kind_of)

    def _take_picture(self, message: RosMessage) -> None:
        self._take_streamed(message, lambda content: (*size_of(content), int(is_depth(content, message.topic))))

    def _take_cloud(self, message: RosMessage) -> None:
        stream = self.streams.setdefault(message.topic, Stream())

        def kind_of(content: Any) -> tuple[int, ...]:
            stream.has_returns |= content.width * content.height > 0
            return ()

        self._take_streamed(message, kind_of, end_of=partial(end_of, units=self.units[message.topic]))

    def _take_streamed(
        self,
        message: RosMessage,
        kind_of: Callable[[Any], tuple[int, ...]],
        *,
        end_of: Callable[[Any], float] = lambda _: 0.0,
    ) -> None:
        """Store time and shape of a scan, a cloud or a picture."""
        stream = self.streams.setdefault(message.topic, Stream())
        stream.times.append(message.time)
        stream.stamps.append(self._stamp(message))
        stream.kinds.append(None)
        content = self._bag.decode(message)
        stream.stamps[-1] += end_of(content)
        stream.kinds[-1] = kind_of(content)
        stream.first = content if stream.first is None else stream.first

    def _drop_wrong_times(self, length: float) -> None:
        """Leave out messages with a time far from all others, such as from before a clock was set."""
        columns = [np.array(stream.stamps) for stream in self.streams.values()]
        columns += [np.array([row[0] for row in moves.rows]) for moves in self.carried.values()]
        columns += [np.array([row[0] for row in (*moves.rows, *moves.twists)]) for moves in self.moves.values()]
        columns += [np.array(readings[::7]) for readings in self.imus.values()]
        columns += [np.array([fix.time for fix in fixes]) for fixes in self.fixes.values()]
        if not any(map(len, columns)):
            return
        middle, limit = float(np.median(np.concatenate(columns))), MAX_BAG_LENGTHS * length + EXTRA_SECONDS
        before_drop = Counter(self.left_out)
        for topic, stream in self.streams.items():
            in_time = [abs(stamp - middle) <= limit for stamp in stream.stamps]
            stream.stamps = [
                stamp if fits else float("nan") for stamp, fits in zip(stream.stamps, in_time, strict=True)
            ]
            self.left_out[topic] += in_time.count(False)
        carried = ((f"{frame} in /tf", moves) for (_, frame), moves in self.carried.items())
        for topic, moves in (*self.moves.items(), *carried):
            before = len(moves.rows) or len(moves.twists)
            moves.rows = [row for row in moves.rows if abs(row[0] - middle) <= limit]
            moves.twists = [row for row in moves.twists if abs(row[0] - middle) <= limit]
            self.left_out[topic] += before - (len(moves.rows) or len(moves.twists))
        for topic, readings in self.imus.items():
            near_rows = np.abs(np.array(readings[::7]) - middle) <= limit
            self.imus[topic] = array("d", np.array(readings).reshape(-1, 7)[near_rows].ravel())
            self.left_out[topic] += int(np.count_nonzero(~near_rows))
        for topic, fixes in self.fixes.items():
            self.fixes[topic] = sorted((f for f in fixes if abs(f.time - middle) <= limit), key=lambda fix: fix.time)
            self.left_out[topic] += len(fixes) - len(self.fixes[topic])
        for topic in self.left_out - before_drop:
            self.reasons.setdefault(topic, f"its time is far from {middle:.3f} s, the median of all messages")


def unread_topics(bag: Bag, robots: Sequence[RobotTopics]) -> dict[str, str]:
    """Return the metadata about topics of robots in a bag that are not read."""
    read = {topic for robot in robots for topic in robot.all()}
    return {
        f"{topic} left out": f"{count} messages of {bag.types[topic]}"
        for topic, count in bag.counts.items()
        if count and topic not in read and bag.types[topic] not in (*TRANSFORMS, INFO)
    }


def moving_in_tf(bag: Bag) -> list[str]:
    """Return the namespaces of frames, such as 'one' of 'one/base_link', that move in frames of odometry."""
    found: dict[str, None] = {}
    topics = {topic for topic, kind in bag.types.items() if kind in TRANSFORMS}
    for message in islice(bag.messages(topics), MAX_UNSET):
        with suppress(ValueError):
            for each in bag.decode(message).transforms:
                outer, inner = frame_name(each.header.frame_id), frame_name(each.child_frame_id)
                if is_odometry(outer, inner) and "/" in inner:
                    found[inner.partition("/")[0]] = None
    return list(found)


def times_of(streams: Mapping[str, Stream]) -> dict[str, NDArray[np.int64]]:
    """Return when the messages of each stream were recorded [ns]."""
    return {topic: np.array(stream.times, dtype=np.int64) for topic, stream in streams.items()}
