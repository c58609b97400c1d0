"""Services of ROS 2 over DDS, as rmw_cyclonedds sends them: requests on `rq/`, responses on `rr/`."""

from collections.abc import Callable
from typing import Any

from mjsim.bridge.bus import Bus
from mjsim.ros import SERVICES, Outgoing, RosTopic, typestore

Answer = Callable[[Any], tuple[Any, ...]]
"""Request -> fields of the response."""


def call_name(service: str, kind: str) -> tuple[RosTopic, RosTopic]:
    """Return the topics for the requests and the responses of a service.

    Args:
        service: '/mjsim/pause' and so on.
        kind: 'std_srvs/srv/Trigger' and so on.

    References:
        ROS 2 design, Topic and Service name mapping to DDS; rmw_cyclonedds, `cdds_request_header_t`.
    """
    stem = "/srv/msg/".join(kind.split("/srv/"))
    return (
        RosTopic(f"{service}Request", f"{stem}_Request", SERVICES),
        RosTopic(f"{service}Reply", f"{stem}_Response", SERVICES),
    )


def offer(bus: Bus, service: str, kind: str, answer: Answer) -> None:
    """Offer a service; to be used before the bus is started.

    Args:
        bus: The bus.
        service: Its name.
        kind: Its type.
        answer: Called in the thread of services.
    """
    request_topic, response_topic = call_name(service, kind)
    bus.announce(response_topic, space="rr")
    make = typestore().types[response_topic.type]

    def take(request: Any) -> None:
        # The client recognises its response by its id and the number of its request.
        bus.send(Outgoing(response_topic, make(request.guid, request.number, *answer(request))), space="rr")

    bus.receive(request_topic, take, space="rq")
