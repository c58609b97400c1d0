"""Messages with the estimates of a robot's modules at a tick."""

import operator
from collections.abc import Hashable, Sequence

from mjsim.interface import Shown
from mjsim.record.drawn import show_message
from mjsim.record.json_messages import (
    innovations_message,
    landmarks_message,
    map_arrays,
    pose_message,
    sightings_message,
)
from mjsim.record.numbers import Message
from mjsim.record.tick import Order

BELIEF_TOPICS = frozenset({"estimate", "landmarks", "sightings", "innovations", "covariance", "path", "show"})
"""Topics of a robot that its observer and its estimator make."""
_EMPTY_MAP = ((), b"", b"")


class BeliefMessages:
    """The beliefs of one robot, tick after tick.

    A map is repeated only when it has changed, and so are shown items.

    Args:
        robot: Robot that they belong to.
    """

    def __init__(self, robot: str) -> None:
        self._robot = robot
        self._shown: tuple[Shown, ...] = ()
        self._held: tuple[tuple[Hashable, ...], bytes, bytes] = _EMPTY_MAP

    def of(self, now: float, order: Order, *, moment: float | None) -> list[tuple[str, Message]]:
        """Return the messages by topic (without the robot) of estimates and sightings, without the joint covariance.

        Args:
            now: Simulated time [s].
            order: Holds the estimate and the sightings.
            moment: Time at which the robot is at the estimate [s]; None for now.
        """
        estimate = order.estimate
        messages = [("estimate", pose_message(now, estimate.pose, estimate.covariance, moment=moment))]
        names, means, covariances = map_arrays(estimate.landmarks)
        held = (names, means.tobytes(), covariances.tobytes())
        if held != self._held:
            self._held = held
            messages.append(("landmarks", landmarks_message(now, names, means, covariances)))
        if order.sightings:
            messages.append(("sightings", sightings_message(now, order.sightings)))
        if estimate.innovations:
            messages.append(("innovations", innovations_message(now, estimate.innovations)))
        if estimate.show is not self._shown and not _same(estimate.show, self._shown):
            messages.append(("show", show_message(now, self._robot, estimate.show)))
        self._shown = estimate.show
        return messages


def _same(items: Sequence[Shown], others: Sequence[Shown]) -> bool:
    """Return whether both hold the same immutable objects."""
    return len(items) == len(others) and all(map(operator.is_, items, others))
