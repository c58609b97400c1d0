"""The DDS bus of ROS 2: topics with the names and qualities of service of ROS 2.

DDS types of ROS 2 messages; their samples carry CDR made by rosbags.
"""

import ipaddress
import os
import socket
import stat
import time
import types
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from typing import Any
from xml.sax.saxutils import quoteattr

from mjsim.bridge.listener import Listener
from mjsim.closing import Closes
from mjsim.errors import UsageError, did_you_mean, how_to_install
from mjsim.ros import Outgoing, RosTopic, bytes_of, type_hash, typestore

LOOPBACK, LOOPBACK_DEVICE = "127.0.0.1", "lo"
MAX_DOMAIN = 232
"""Highest domain; ports of higher ones would exceed 65535."""
MAX_PROCESS_LENGTH = 100
"""Maximum length of the description of another participant's process [characters]."""
MAX_ENTITIES, POLL_SECONDS, SETTLING_SECONDS = 10_000, 0.02, 0.25
"""Maximum number of entities read from other participants, polling interval [s], and wait after the newest one [s]."""
FIRST_PORT, PORTS = 7400, 250
"""First port of domain 0, and number of ports per domain, as in RTPS."""


def domain_id() -> int:
    """Return the domain of `ROS_DOMAIN_ID`, by default 0.

    Raises:
        UsageError: It is not a number from 0 to 232.
    """
    text = os.environ.get("ROS_DOMAIN_ID", "").strip() or "0"
    if not text.isdecimal() or int(text) > MAX_DOMAIN:
        raise UsageError(f"ROS_DOMAIN_ID is {text[:40]!r}; it must be a whole number from 0 to {MAX_DOMAIN}")
    return int(text)


class Bus(Closes):
    """One participant of a DDS domain."""

    def __init__(self, *, domain: int, interface: str | None = None) -> None:
        """Join the domain.

        Args:
            domain: Its number.
            interface: Name or address of the network interface; by default loopback.

        Raises:
            UsageError: The interface does not exist, cyclonedds is not installed, or this process has already joined
                the domain.
        """
        place = _place(interface)
        try:
            from cyclonedds.core import DDSException
            from cyclonedds.domain import Domain, DomainParticipant
        except ModuleNotFoundError:
            raise UsageError(
                f"cyclonedds, the bus of ROS 2, is not installed; type: {how_to_install('cyclonedds')}"
            ) from None
        try:
            self._domain: Any = Domain(domain, _settings(place, local=interface is None))
        except DDSException as error:
            if error.code != DDSException.DDS_RETCODE_PRECONDITION_NOT_MET:
                raise UsageError(f"cannot join domain {domain} by {interface or 'loopback'}: {error}") from None
            raise UsageError(
                f"this process is in domain {domain} already; close its other bridge, or set ROS_DOMAIN_ID"
            ) from None
        self._participant: Any = DomainParticipant(domain)
        self._joined = time.monotonic()
        if interface is None:
            _keep_to_loopback(domain)
        self._writers: dict[RosTopic, Any] = {}
        self._sample_types: dict[RosTopic, Any] = {}
        # A service may wait for what it has started; commands do not wait for it.
        self._topics = Listener(self._participant, name="mjsim-bridge")
        self._services = Listener(self._participant, name="mjsim-services")

    def send(self, each: Outgoing, *, space: str = "rt") -> None:
        """Send a message; its topic is announced with the first one.

        Args:
            each: The message.
            space: 'rt' for topics, 'rq' and 'rr' for requests and responses of services.
        """
        topic = each.topic
        if topic not in self._writers:
            self.announce(topic, space=space)
        self._writers[topic].write(self._sample_types[topic](bytes_of(each.message)))

    def announce(self, topic: RosTopic, *, space: str = "rt") -> None:
        """Announce a topic that will be sent."""
        from cyclonedds.pub import DataWriter

        self._sample_types[topic] = sample_type(topic.type)
        found = self._topic(topic.name, topic.type, space)
        self._writers[topic] = DataWriter(self._participant, found, qos=_profile(topic))

    def receive(self, topic: RosTopic, take: Callable[[Any], None], *, space: str = "rt") -> None:
        """Call a function with each message of a topic, in a thread of the bus; to be used before `start`.

        Requests and responses of services have a separate thread.
        """
        from cyclonedds.sub import DataReader

        reader = DataReader(self._participant, self._topic(topic.name, topic.type, space), qos=_profile(topic))
        (self._topics if space == "rt" else self._services).add(reader, topic.type, take)

    def publishers(self, is_meant: Callable[[str], bool], *, wait: float) -> dict[str, str]:
        """Return the topics that other participants publish, each with its process if that is known.

        Args:
            is_meant: Returns whether a topic, given by name, counts; this participant must not publish these yet.
            wait: Time to find the first topic, counted from when this participant joined [s].
        """
        from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsParticipant, BuiltinTopicDcpsPublication

        writers, found = BuiltinDataReader(self._participant, BuiltinTopicDcpsPublication), dict[str, Any]()
        deadline = self._joined + wait
        while True:
            before = len(found)
            for each in writers.read(N=MAX_ENTITIES):
                space, _, topic = each.topic_name.partition("/")
                if space == "rt" and is_meant(f"/{topic}"):
                    found[f"/{topic}"] = each.participant_key
            if len(found) > before:
                # A participant announces its topics one after the other.
                deadline = time.monotonic() + SETTLING_SECONDS
            if time.monotonic() > deadline:
                break
            time.sleep(POLL_SECONDS)
        participants = BuiltinDataReader(self._participant, BuiltinTopicDcpsParticipant).read(N=MAX_ENTITIES)
        processes = {each.key: _process_of(each.qos) for each in participants}
        return {topic: processes.get(key, "") for topic, key in found.items()}

    def start(self) -> None:
        """Start to receive."""
        self._topics.start()
        self._services.start()

    def close(self) -> None:
        """Leave the domain; a second call does nothing."""
        self._topics.close()
        self._services.close()
        # Entities of DDS are deleted with their objects; the domain comes last.
        self._writers = {}
        self._participant = None
        self._domain = None

    def _topic(self, name: str, kind: str, space: str) -> Any:
        from cyclonedds.topic import Topic

        return Topic(self._participant, f"{space}{name}", sample_type(kind))


def _process_of(qos: Any) -> str:
    """Return name, number and host of a participant's process, as cyclonedds announces them, else ''."""
    told = {each.key: each.value for each in qos if type(each).__name__ == "Property"}
    name, number, host = (told.get(f"__{key}") for key in ("ProcessName", "Pid", "Hostname"))
    return f"{name} {number} on {host}"[:MAX_PROCESS_LENGTH] if name and number and host else ""


def _place(interface: str | None) -> str:
    """Return the configuration of an interface for cyclonedds; raises UsageError if it does not exist."""
    if interface is None:
        return f"address={quoteattr(LOOPBACK)}"
    names = [name for _, name in socket.if_nameindex()]
    if interface in names:
        return f"name={quoteattr(interface)}"
    try:
        address = ipaddress.IPv4Address(interface)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind((str(address), 0))
    except (ValueError, OSError):
        raise UsageError(
            f"no network interface or IPv4 address '{interface}'{did_you_mean(interface, names)}"
        ) from None
    return f"address={quoteattr(str(address))}"


def _keep_to_loopback(domain: int) -> None:
    """Make the kernel drop packets from other interfaces to the sockets of a domain.

    On loopback, cyclonedds only sends and joins groups there, but its receiving sockets are bound to every address, so
    another machine could send commands to their ports.
    """
    if not hasattr(socket, "SO_BINDTODEVICE"):
        return  # Linux only
    first = FIRST_PORT + PORTS * domain
    for descriptor in map(int, os.listdir("/proc/self/fd")):
        # It may have been closed meanwhile; before Linux 5.7 only root may bind.
        with suppress(OSError):
            if stat.S_ISSOCK(os.fstat(descriptor).st_mode):
                with socket.socket(fileno=os.dup(descriptor)) as found:
                    if found.type == socket.SOCK_DGRAM and first <= found.getsockname()[1] < first + PORTS:
                        found.setsockopt(socket.SOL_SOCKET, socket.SO_BINDTODEVICE, LOOPBACK_DEVICE.encode())


def _settings(place: str, *, local: bool) -> str:
    """Return the settings of cyclonedds as XML.

    Loopback has no multicast on most machines, so peers there are also searched for one by one.
    """
    peers = (
        "<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>"
        f"<Peers><Peer address={quoteattr(LOOPBACK)}/></Peers></Discovery>"
    )
    forced = 'multicast="true"' if local else ""
    return (
        f'<CycloneDDS><Domain Id="any"><General><Interfaces><NetworkInterface {place} {forced}/></Interfaces></General>'
        f"{peers if local else ''}</Domain></CycloneDDS>"
    )


def _profile(topic: RosTopic) -> Any:
    """Return the quality of service of a topic for cyclonedds; messages are CDR version 1, as in ROS 2.

    It includes the hash of the type, since ROS 2 nodes warn about endpoints without one.
    """
    from cyclonedds.core import Policy
    from cyclonedds.core import Qos as DdsQos
    from cyclonedds.util import duration

    qos = topic.qos
    reliable = Policy.Reliability.Reliable(duration(milliseconds=100))
    return DdsQos(
        reliable if qos.reliable else Policy.Reliability.BestEffort,
        Policy.Durability.TransientLocal if qos.transient_local else Policy.Durability.Volatile,
        Policy.History.KeepLast(qos.depth),
        Policy.DataRepresentation(use_cdrv0_representation=True),
        Policy.Userdata(f"typehash={type_hash(topic.type)};".encode()),
    )


OWN_TYPES = {"bool": bool, "string": str}
"""Base types of ROS that are Python types in cyclonedds."""
BASE_TYPES = {"octet": "byte", "char": "uint8"}
"""Base types of ROS with other names in cyclonedds."""


@cache
def sample_type(kind: str) -> Any:
    """Return the class of samples of a ROS 2 type, 'sensor_msgs/msg/LaserScan'; a sample holds its bytes as `cdr`.

    Members have the names and types of the message, for peers that compare types.

    References:
        ROS 2 design, Topic and Service name mapping to DDS: `pkg::msg::dds_::Name_`, `pkg::srv::dds_::Name_Request_`.
    """
    from cyclonedds.idl import IdlStruct

    package, group, *_, name = kind.split("/")

    def fill(space: dict[str, Any]) -> None:
        _, fields = typestore().fielddefs[kind]
        space["__annotations__"] = {field: _member(about) for field, about in fields}
        space["__init__"] = lambda self, cdr: setattr(self, "cdr", cdr)
        space["serialize"] = lambda self, *args, **kwargs: self.cdr
        space["deserialize"] = classmethod(lambda cls, data, *args, **kwargs: cls(data))
        # A sample that says that its sender has gone has no data.
        space["deserialize_key"] = classmethod(lambda cls, *args, **kwargs: None)

    return types.new_class(f"{name}_", (IdlStruct,), {"typename": f"{package}.{group}.dds_.{name}_"}, fill)


def _member(about: Any) -> Any:
    """Return the type of a member from rosbags' description."""
    from cyclonedds.idl import types as idl
    from rosbags.interfaces import Nodetype

    kind, content = about
    if kind == Nodetype.NAME:
        return sample_type(content)
    if kind == Nodetype.BASE:
        return OWN_TYPES.get(content[0]) or getattr(idl, BASE_TYPES.get(content[0], content[0]))
    inner, count = content
    made: Any = idl.array if kind == Nodetype.ARRAY else idl.sequence
    return made[_member(inner), count] if kind == Nodetype.ARRAY else made[_member(inner)]
