"""A bus within the process, whose messages are CDR as on the real one."""

from collections.abc import Callable
from typing import Any

from mjsim.ros import Outgoing, RosTopic, bytes_of, message_of, typestore

PACKAGE = "simulation_interfaces"


class Desk:
    """Carries messages, requests and responses."""

    def __init__(self, **_: object) -> None:
        self.sent: list[Outgoing] = []
        """Of topics, each once it was written and read."""
        self.others: dict[str, str] = {}
        """Topics of other participants."""
        self.asked: list[Callable[[str], bool]] = []
        """What was said to be meant, when it was asked for other participants."""
        self.is_started = self.is_closed = False
        self._takes: dict[str, list[tuple[str, Callable[[Any], None]]]] = {}
        self._answers: list[Any] = []

    def announce(self, topic: RosTopic, *, space: str) -> None:
        """Take the topic of a response."""

    def receive(self, topic: RosTopic, take: Callable[[Any], None], *, space: str = "rt") -> None:
        self._takes.setdefault(topic.name, []).append((topic.type, take))

    def send(self, each: Outgoing, *, space: str = "rt") -> None:
        message = message_of(bytes_of(each.message), each.topic.type)
        if space == "rt":
            self.sent.append(Outgoing(each.topic, message))
        else:
            self._answers.append(message)

    def publishers(self, is_meant: Callable[[str], bool], *, wait: float) -> dict[str, str]:
        self.asked.append(is_meant)
        return {topic: process for topic, process in self.others.items() if is_meant(topic)}

    def start(self) -> None:
        self.is_started = True

    def close(self) -> None:
        self.is_closed = True

    def hear(self, topic: str, message: Any) -> int:
        """Hand a message to all who listen for its type on a topic; return their number."""
        kind = type(message).__msgtype__
        takes = [take for wanted, take in self._takes.get(topic, ()) if wanted == kind]
        for take in takes:
            take(message_of(bytes_of(message), kind))
        return len(takes)

    def call(self, name: str, *fields: object) -> Any:
        """Call a service of `simulation_interfaces` by its type."""
        kind = f"{PACKAGE}/srv/msg/{name}_Request"
        (topic,) = (topic for topic, pairs in self._takes.items() if pairs[0][0] == kind)
        return self.ask(topic.removesuffix("Request"), *fields)

    def ask(self, service: str, *fields: object) -> Any:
        """Call a service by its name."""
        ((kind, take),) = self._takes[f"{service}Request"]
        request = typestore().types[kind](4711, len(self._answers), *fields)
        take(message_of(bytes_of(request), kind))
        answer = self._answers[-1]
        assert (answer.guid, answer.number) == (4711, len(self._answers) - 1)
        return answer
