"""Delays the response to wrong tokens, longer each time, per peer."""

import asyncio
import time
from collections import Counter, OrderedDict
from collections.abc import Callable

FIRST_DELAY, MAX_DELAY = 0.25, 4.0
"""Delay for the first wrong token, which doubles each time, and its maximum [s]."""
RESET_SECONDS = 60.0
"""Time without a wrong token after which the count of a peer is reset [s]."""
AT_ONCE = 4
"""Maximum number of waiting tokens per peer."""
MAX_PEERS = 1000


class Penalty:
    """Limits the rate at which a peer can try tokens; a correct one is answered at once. For one event loop."""

    def __init__(self, *, clock: Callable[[], float] = time.monotonic) -> None:
        """Start without any peer at fault."""
        self._clock = clock
        self._wrong: OrderedDict[str, tuple[int, float]] = OrderedDict()
        self._waiting: Counter[str] = Counter()

    def is_full(self, peer: str) -> bool:
        """Return whether a peer has so many wrong tokens waiting that another one is not even checked."""
        return self._waiting[peer] >= AT_ONCE

    async def wait(self, peer: str) -> None:
        """Delay the response to a wrong token."""
        count, last = self._wrong.pop(peer, (0, 0.0))
        now = self._clock()
        count = 1 if now - last > RESET_SECONDS else count + 1
        self._wrong[peer] = count, now
        if len(self._wrong) > MAX_PEERS:
            self._wrong.popitem(last=False)
        self._waiting[peer] += 1
        try:
            await asyncio.sleep(delay(count))
        finally:
            self._waiting[peer] -= 1
            if not self._waiting[peer]:
                del self._waiting[peer]

    def forgive(self, peer: str) -> None:
        """Reset the count of a peer that gave a correct token."""
        self._wrong.pop(peer, None)


def delay(count: int) -> float:
    """Return the delay for the n-th wrong token [s]."""
    return min(FIRST_DELAY * 2.0 ** min(count - 1, 10), MAX_DELAY)
