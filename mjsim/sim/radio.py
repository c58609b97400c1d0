"""The radio between robots: messages sent in a tick arrive in the next one at the earliest."""

import math
from collections import deque
from collections.abc import Callable, Mapping, Sequence

from mjsim.geometry import Pose
from mjsim.interface import Message, message_text
from mjsim.sim.streams import stream
from mjsim.world import Radio


class RadioNet:
    """Messages in transit in a running simulation; each pair of sender and receiver has its own random stream."""

    def __init__(self, robots: Sequence[str], radio: Radio, *, seed: int) -> None:
        """Initialise without messages."""
        self._radio = radio
        self._outgoing: dict[str, tuple[str, ...]] = {}
        self._coming: dict[str, deque[tuple[int, Message]]] = {robot: deque() for robot in robots}
        self._luck = {
            (sender, receiver): stream(seed, receiver, f"radio/{sender}")
            for sender in robots
            for receiver in robots
            if radio.loss and sender != receiver
        }

    def queue(self, robot: str, messages: Sequence[object]) -> None:
        """Set the messages that a robot sends in this tick, replacing those set before.

        Raises:
            ValueError: A message cannot be sent.
        """
        self._outgoing[robot] = tuple(message_text(message) for message in messages)

    def send(self, tick: int, time: float, truths: Callable[[], Mapping[str, Pose]]) -> None:
        """Send the messages of a tick, at a simulated time [s], to all robots in range."""
        outgoing, self._outgoing = self._outgoing, {}
        if not any(outgoing.values()):
            return
        places, due = truths(), tick + 1 + self._radio.delay
        # In the order of the world, regardless of which robot decided first.
        for sender in self._coming:
            for text in outgoing.get(sender, ()):
                message = Message(sender, time, text)
                for receiver, coming in self._coming.items():
                    if receiver != sender and self._reaches(sender, receiver, places):
                        coming.append((due, message))

    def received(self, robot: str, tick: int) -> tuple[Message, ...]:
        """Return the messages received by a robot since the last call, in the order of sending."""
        coming, found = self._coming[robot], []
        while coming and coming[0][0] <= tick:
            found.append(coming.popleft()[1])
        return tuple(found)

    def _reaches(self, sender: str, receiver: str, places: Mapping[str, Pose]) -> bool:
        # At any distance, each message draws one random number per receiver.
        lost = bool(self._radio.loss) and self._luck[sender, receiver].random() < self._radio.loss
        one, other = places[sender], places[receiver]
        reach = math.inf if self._radio.range is None else self._radio.range
        return not lost and math.hypot(one.x - other.x, one.y - other.y) <= reach
