"""Events of a run for browsers: bounded, and targets that follow each other are one event that grows."""

from mjsim.record import Tick
from mjsim.web.run.news import EventNews
from mjsim.world import EVENT_KINDS, WorldEvent, event_text, extend_motion, kind_of

MAX_EVENTS = 1000
"""Number of events kept for late joiners."""


class Happenings:
    """Events until now, each with the number of its last change."""

    def __init__(self) -> None:
        """Start without events."""
        self.count = 0
        """Number of changes."""
        self._kept: dict[int, tuple[int, EventNews]] = {}
        """By the number of the event: that of its last change, and itself."""
        self._motions: dict[int, WorldEvent] = {}

    def take(self, tick: Tick) -> None:
        """Add the events at a tick, of the world and its robots."""
        for happened in tick.events:
            self._take_world(happened)
        for robot, order in tick.orders.items():
            for event in order.events:
                self._add(
                    {"kind": "event", "time": event.time, "robot": robot, "event": event.kind, "text": event.text}
                )

    def after(self, number: int) -> list[EventNews]:
        """Return the events that are new or have changed after a number of changes."""
        return [event for changed, event in self._kept.values() if changed > number]

    def all(self) -> list[EventNews]:
        """Return all events."""
        return self.after(-1)

    def clear(self) -> None:
        """Remove all events; numbers continue."""
        self._kept, self._motions = {}, {}

    def _take_world(self, happened: WorldEvent) -> None:
        before, whole = extend_motion(self._motions, happened)
        number = self.count + 1 if before is None else before
        self._motions[number] = whole
        kind, text = str(kind_of(whole, EVENT_KINDS)), event_text(whole)
        news: EventNews = {"kind": "event", "time": whole.time, "robot": None, "event": kind, "text": text}
        if kind in ("reach", "lead"):
            news["motion"] = number
        self._add(news, number)

    def _add(self, news: EventNews, number: int | None = None) -> None:
        self.count += 1
        self._kept[self.count if number is None else number] = self.count, news
        while len(self._kept) > MAX_EVENTS:
            oldest = next(iter(self._kept))
            del self._kept[oldest]
            self._motions.pop(oldest, None)
