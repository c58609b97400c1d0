"""The scans, clouds and pictures of one robot in a bag, each read from its message on request."""

from collections.abc import Callable
from typing import Any

import numpy as np

from mjsim.geometry import Array
from mjsim.inventory import Fate, told
from mjsim.logs.bags.bag_contents import Contents, Stream
from mjsim.logs.bags.bag_file import Bag, BagMessages
from mjsim.logs.resampling import Damage, DamagedReadingError, Readings


class RobotStreams:
    """The topics of a robot whose messages are large, the mounts of its sensors, and notes about them."""

    def __init__(self, bag: Bag, contents: Contents, messages: BagMessages, *, space: str) -> None:
        """Take an open bag; `space` is the namespace of the robot's frames."""
        self.bag, self.contents, self._messages = bag, contents, messages
        self.frames = contents.frames_of(space)
        self.base: str | None = None
        """The robot's frame, once it is known."""
        self.notes: dict[str, str] = {}
        """Notes on what was guessed or left out, by subject."""
        self.damage = Damage()

    def place(self, name: str, frame: str) -> Array | None:
        """Return robot_from_sensor from the frames of the bag, shape (4, 4) [m]; None if they do not contain it."""
        place = None if self.base is None else self.frames.between(self.base, frame)
        if place is None:
            self.notes[f"place of {name}"] = told(Fate.GUESSED, "not in the bag")
        return place

    def stream(self, topic: str) -> Stream | None:
        """Return the messages of a topic; None if there is none that can be read."""
        stream = self.contents.streams.get(topic)
        return None if stream is None or not len(stream.numbers()) else stream

    def readings(self, topic: str, stream: Stream, make: Callable[..., Any], *, later: float = 0.0) -> Readings[Any]:
        """Return the readings of a stream, each made on request from its message and its stamp, moved `later` [s]."""
        numbers = stream.numbers()
        stamps = np.array(stream.stamps)[numbers] + later

        def take(number: int) -> Any:
            message = self._messages.take(topic, int(numbers[number]))
            try:
                return make(self.bag.decode(message), float(stamps[number]))
            except ValueError as error:
                raise DamagedReadingError(f"{topic} at {stamps[number]:.3f} s: {error}") from None

        return Readings(stamps, take)

    def count_odd(self, topic: str, stream: Stream) -> None:
        """Note how many messages of a topic are left out, since their size is not the usual one."""
        self.contents.left_out[topic] = len(stream.stamps) - len(stream.numbers())
