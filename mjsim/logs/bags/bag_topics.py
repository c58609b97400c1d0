"""Selects the topics of a bag to read, by robot and kind of data."""

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

from mjsim.errors import UsageError, did_you_mean

ODOMETRY = "nav_msgs/msg/Odometry"
PICTURES = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")
POSES = tuple(f"geometry_msgs/msg/{name}" for name in ("PoseStamped", "PoseWithCovarianceStamped", "TransformStamped"))
COMMANDS = ("geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped")
TWISTS = ("geometry_msgs/msg/TwistStamped", "geometry_msgs/msg/TwistWithCovarianceStamped")
"""Velocities with a stamp, which may be odometry."""
TYPES = {
    "odometry": (ODOMETRY, *TWISTS, *POSES),
    "truth": (ODOMETRY, *POSES),
    "scan": ("sensor_msgs/msg/LaserScan", "sensor_msgs/msg/MultiEchoLaserScan"),
    "cloud": ("sensor_msgs/msg/PointCloud2",),
    "camera": PICTURES,
    "imu": ("sensor_msgs/msg/Imu",),
    "command": COMMANDS,
    "gps": ("sensor_msgs/msg/NavSatFix",),
}
"""Kind of data, as in `--topic` -> types of ROS that it can be read from."""
UNASKED = {**TYPES, "odometry": (ODOMETRY,)}
"""The same for topics that the user did not name: other velocities and poses may be anything."""
NAMELESS = "robot"
"""Name of a robot without a namespace."""
SINGLE_TOPIC_KINDS = ("odometry", "truth", "command", "gps")
"""Kinds of data that are read from a single topic of a robot."""
SENSED = (*TYPES["scan"], *TYPES["cloud"], *PICTURES, *TYPES["imu"])
INFO = "sensor_msgs/msg/CameraInfo"
TRANSFORMS = ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage")
OF_ROBOTS = (*SENSED, *COMMANDS, *TRANSFORMS, "sensor_msgs/msg/Range", "sensor_msgs/msg/JointState")
"""Types of which a namespace with odometry must have one to be a robot's; one robot may have several odometry
topics."""
TRANSPORTS = ("compressed", "compressedDepth")
"""Last parts of topics with compressed pictures of the topic before them."""
PICTURE_WORDS = ("image", "image_raw", "image_color", "image_rect", "image_rect_color", "image_mono")
PLAIN_WORDS = ("data", "data_raw", "points", *PICTURE_WORDS)
"""Last parts of topics that are not part of a sensor's name."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotTopics:
    """The topics of one robot."""

    name: str
    space: str = ""
    """Its namespace, as returned by `robot_of`; empty without one."""
    shared: str = ""
    """Namespace that all robots are in, such as '/fleet'; usually empty."""
    odometry: str | None = None
    truth: str | None = None
    scan: Mapping[str, str] = field(default_factory=dict)
    """Name of the sensor -> topic; the next fields are the same."""
    camera: Mapping[str, str] = field(default_factory=dict)
    """Topics of pictures and of depth."""
    imu: Mapping[str, str] = field(default_factory=dict)
    cloud: Mapping[str, str] = field(default_factory=dict)
    command: str | None = None
    gps: str | None = None
    """Fixes that are the truth."""

    def all(self) -> list[str]:
        """Return every topic that is read."""
        single = [topic for topic in (self.odometry, self.truth, self.command, self.gps) if topic is not None]
        sensors = (self.scan, self.camera, self.imu, self.cloud)
        return [*single, *(topic for topics in sensors for topic in topics.values())]


def robots_of(
    types: Mapping[str, str],
    *,
    topics_by_kind: Mapping[str, Sequence[str]],
    names: Sequence[str],
    moving: Collection[str] = (),
) -> list[RobotTopics]:
    """Return the robots of a bag and their topics.

    There are several if several namespaces have odometry and also other data of a robot.

    Args:
        types: Topic -> type.
        topics_by_kind: Kind of data -> topics named by the user.
        names: Robots named by the user; by default all.
        moving: Namespaces of frames that move in /tf, as odometry.

    Raises:
        UsageError: A named topic or robot does not exist, or one topic must be chosen from several.
    """
    shared = _shared(types, topics_by_kind)
    _check(types, topics_by_kind, shared)
    spaces = _namespaces(types, topics_by_kind, shared, moving)
    for name in names:
        if name not in spaces:
            raise UsageError(f"no robot '{name}' in this bag{did_you_mean(name, spaces)}")
    several = len(spaces) > 1
    return [
        _robot(
            name,
            space,
            [topic for topic in types if not several or _first(topic, shared) == space],
            types,
            topics_by_kind,
            shared,
        )
        for name, space in spaces.items()
        if not names or name in names
    ]


def plain_topic(topic: str) -> str:
    """Return the topic of a picture without the part for its compression."""
    before, _, last = topic.rpartition("/")
    return before if last in TRANSPORTS else topic


def robot_of(topic: str, shared: str = "") -> str:
    """Return the name of the robot in whose namespace a topic is; empty outside namespaces.

    Args:
        topic: Name of the topic.
        shared: Namespace that all robots are in, as in `RobotTopics`.
    """
    return _plain(_first(topic, shared))


def _shared(types: Mapping[str, str], topics_by_kind: Mapping[str, Sequence[str]]) -> str:
    """Return the namespace that several robots are in, as '/fleet' in '/fleet/one/odom'; empty without one."""
    moved = topics_by_kind.get("odometry") or [topic for topic, kind in types.items() if kind == ODOMETRY]
    words = [topic.strip("/").split("/") for topic in moved]
    is_deep = all(len(each) > 2 for each in words) and len({each[0] for each in words}) == 1
    return f"/{words[0][0]}" if is_deep and len({each[1] for each in words}) > 1 else ""


def _check(types: Mapping[str, str], topics_by_kind: Mapping[str, Sequence[str]], shared: str) -> None:
    for kind, topics in topics_by_kind.items():
        if kind not in TYPES:
            raise UsageError(f"no kind of topic '{kind}'{did_you_mean(kind, TYPES)}")
        for topic in topics:
            if topic not in types:
                raise UsageError(f"no topic '{topic}' in this bag{did_you_mean(topic, types)}")
            if types[topic] not in TYPES[kind]:
                kinds = " or ".join(TYPES[kind])
                raise UsageError(f"topic '{topic}' is of {types[topic]}; {kind} is read from {kinds}")
        if kind in SINGLE_TOPIC_KINDS and len({_first(topic, shared) for topic in topics}) < len(topics):
            raise UsageError(f"{kind} is read from one topic of a robot; name one with --topic {kind}=...")


def _namespaces(
    types: Mapping[str, str], topics_by_kind: Mapping[str, Sequence[str]], shared: str, moving: Collection[str]
) -> dict[str, str]:
    """Return robot name -> namespace, which is empty for a robot without its own."""
    moved = [topic for topic, kind in types.items() if kind == ODOMETRY and not _is_truth(topic)]
    spaces = list(dict.fromkeys(_first(topic, shared) for topic in topics_by_kind.get("odometry") or moved))
    of_robots = {_first(topic, shared) for topic, kind in types.items() if kind in OF_ROBOTS}
    if not spaces:
        spaces = [space for space in moving if space in of_robots]
    if len(spaces) > 1 and all(space in of_robots for space in spaces):
        taken: set[str] = set()
        return {_free(_plain(space) or NAMELESS, taken): space for space in spaces}
    everything = {_first(topic) for topic, kind in types.items() if kind not in TRANSFORMS and topic.count("/") > 1}
    flat = [topic for topic, kind in types.items() if kind in (ODOMETRY, *TYPES["scan"]) and topic.count("/") < 2]
    if len(spaces) == 1 and spaces[0] and not flat and everything <= {spaces[0]}:
        return {_plain(spaces[0]) or NAMELESS: spaces[0]}
    return {NAMELESS: ""}


def _robot(
    name: str,
    space: str,
    topics: Collection[str],
    types: Mapping[str, str],
    topics_by_kind: Mapping[str, Sequence[str]],
    shared: str,
) -> RobotTopics:
    def of(kind: str) -> list[str]:
        given = [topic for topic in topics_by_kind.get(kind, ()) if topic in topics]
        return given or [topic for topic in topics if types[topic] in UNASKED[kind]]

    truths = [topic for topic in topics_by_kind.get("truth", ()) if topic in topics] or list(
        filter(_is_truth, of("truth"))
    )
    moved = [topic for topic in of("odometry") if topic not in truths and not _is_truth(topic)]
    # A picture topic and one with the same pictures compressed are one camera.
    pictures = [topic for topic in of("camera") if plain_topic(topic) == topic or plain_topic(topic) not in types]
    taken: set[str] = set()
    named = {
        kind: {_sensor_name(topic, f"{shared}/{space}/", kind, taken): topic for topic in sorted(found)}
        for kind, found in (("scan", of("scan")), ("camera", pictures), ("imu", of("imu")), ("cloud", of("cloud")))
    }
    # Other topics of velocities may hold anything.
    orders = [
        topic for topic in of("command") if topic in topics_by_kind.get("command", ()) or topic.endswith("cmd_vel")
    ]
    fixes = of("gps")
    if "gps" in topics_by_kind and "truth" not in topics_by_kind:
        truths = []
    return RobotTopics(
        name=name,
        space=_plain(space),
        shared=shared,
        odometry=_one("odometry", moved),
        truth=_one("truth", truths),
        gps=fixes[0] if len(fixes) == 1 and not truths else None,
        command=orders[0] if len(orders) == 1 else None,
        **named,
    )


def _one(kind: str, topics: Sequence[str]) -> str | None:
    """Return the topic to read from the possible ones."""
    usual = [topic for topic in topics if topic.rpartition("/")[2] == "odom"]
    chosen = topics if len(topics) < 2 else usual
    if len(topics) > 1 and len(usual) != 1:
        raise UsageError(f"several topics hold {kind}: {', '.join(topics)}; name one with --topic {kind}={topics[0]}")
    return chosen[0] if chosen else None


def _sensor_name(topic: str, space: str, kind: str, taken: set[str]) -> str:
    """Return a unique name for a sensor."""
    words = plain_topic(topic).removeprefix(space).strip("/").split("/")
    while words and words[-1] in PLAIN_WORDS:
        words.pop()
    return _free(_plain("_".join(words)) or kind, taken)


def _free(name: str, taken: set[str]) -> str:
    """Return a name, with a number appended if it is taken, and mark it as taken."""
    first, number = name, 1
    while name in taken:
        number += 1
        name = f"{first}_{number}"
    taken.add(name)
    return name


def _plain(name: str) -> str:
    return re.sub(r"[^A-Za-z0-9_.-]", "_", name)[:60].lstrip(".-")


def _first(topic: str, shared: str = "") -> str:
    """Return the first namespace of a topic, below a shared one; empty without one."""
    words = topic.removeprefix(f"{shared}/").strip("/").split("/")
    return words[0] if len(words) > 1 else ""


def _is_truth(topic: str) -> bool:
    return "truth" in topic.lower()
