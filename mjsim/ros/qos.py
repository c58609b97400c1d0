"""Qualities of service as ROS 2 names them."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Qos:
    """How a topic is transported; history is always 'keep last'."""

    reliable: bool
    """Whether what is lost is sent again; 'best effort' otherwise."""
    transient_local: bool = False
    """Whether those who come late get the last messages; 'volatile' otherwise."""
    depth: int = 10
    """How many messages are kept."""


SENSOR_DATA = Qos(reliable=False, depth=5)
"""`rmw_qos_profile_sensor_data`: what is late is of no use."""
RELIABLE = Qos(reliable=True)
"""`rmw_qos_profile_default`."""
LATCHED = Qos(reliable=True, transient_local=True, depth=1)
"""Of `/tf_static` and maps."""
COMMANDS = Qos(reliable=False, depth=1)
"""Of commands that are received: matches senders of both kinds, and only the newest counts."""
SERVICES = Qos(reliable=True)
"""`rmw_qos_profile_services_default`."""
