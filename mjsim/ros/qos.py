"""Qualities of service of ROS 2."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Qos:
    """How a topic is transported; history is always 'keep last'."""

    reliable: bool
    """Whether lost messages are sent again; otherwise 'best effort'."""
    transient_local: bool = False
    """Whether late joiners get the last messages; otherwise 'volatile'."""
    depth: int = 10
    """Number of messages kept."""


SENSOR_DATA = Qos(reliable=False, depth=5)
"""`rmw_qos_profile_sensor_data`: late messages are useless."""
RELIABLE = Qos(reliable=True)
"""`rmw_qos_profile_default`."""
LATCHED = Qos(reliable=True, transient_local=True, depth=1)
"""Quality of service of `/tf_static` and maps."""
COMMANDS = Qos(reliable=False, depth=1)
"""For received commands: matches reliable and best-effort senders, and keeps only the newest."""
SERVICES = Qos(reliable=True)
"""`rmw_qos_profile_services_default`."""
