"""DDS types of ROS 2 messages; their samples carry CDR made by rosbags."""

import types
from functools import cache
from typing import Any

from mjsim.ros import typestore

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
        # Of a sample that says that its sender has gone.
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
