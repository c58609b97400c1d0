"""Hashes of types, by which ROS 2 since Iron checks whether two programs use the same type.

References:
    REP 2011, Evolving message types; REP 2016, ROS 2 interface type descriptions: `RIHS01_` and a SHA-256.
"""

from functools import cache
from typing import Any

from mjsim.ros.messages import typestore

EVENT = "service_msgs/msg/ServiceEventInfo"
HEAD = 2
"""Fields that rmw_cyclonedds puts before those of a request or a response; they are not part of its type."""


@cache
def type_hash(kind: str) -> str:
    """Return the hash of a message type; for requests and responses, that of the service.

    Args:
        kind: 'sensor_msgs/msg/LaserScan', or 'std_srvs/srv/msg/Trigger_Request' as rosbags names it.
    """
    service, found, part = kind.rpartition("_")
    if not found or part not in ("Request", "Response"):
        return str(typestore().hash_rihs01(kind))
    known = typestore().fielddefs
    request, response = (known[f"{service}_{word}"][1][HEAD:] for word in ("Request", "Response"))
    return service_hash(service.replace("/srv/msg/", "/srv/"), request=request, response=response)


def service_hash(name: str, *, request: Any, response: Any) -> str:
    """Return the hash of a service.

    Args:
        name: 'std_srvs/srv/Trigger' and so on.
        request: Fields of its request, as rosbags describes them.
        response: Fields of its response.
    """
    from rosbags.interfaces import Nodetype
    from rosbags.typesys import Stores, get_typestore

    def named(kind: str) -> Any:
        return Nodetype.NAME, kind

    def at_most_one(kind: str) -> Any:
        return Nodetype.SEQUENCE, (named(kind), 1)

    def number(kind: str) -> Any:
        return Nodetype.BASE, (kind, 0)

    store = get_typestore(Stores.ROS2_JAZZY)  # separate from ours: a type of this name would not be a message
    fields = {
        EVENT: [
            ("event_type", number("uint8")),
            ("stamp", named("builtin_interfaces/msg/Time")),
            ("client_gid", (Nodetype.ARRAY, (number("uint8"), 16))),
            ("sequence_number", number("int64")),
        ],
        f"{name}_Request": request,
        f"{name}_Response": response,
        f"{name}_Event": [
            ("info", named(EVENT)),
            ("request", at_most_one(f"{name}_Request")),
            ("response", at_most_one(f"{name}_Response")),
        ],
        name: [
            ("request_message", named(f"{name}_Request")),
            ("response_message", named(f"{name}_Response")),
            ("event_message", named(f"{name}_Event")),
        ],
    }
    store.fielddefs.update(typestore().fielddefs)
    store.fielddefs.update({each: ([], about) for each, about in fields.items()})
    return str(store.hash_rihs01(name))
