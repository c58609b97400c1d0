"""Bounds the memory that the bodies of all requests take together."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

MAX_TOTAL = 48_000_000
"""Maximum size of all large bodies that are read or worked on at once [bytes]."""
MAX_SMALL_BODY = 500_000
"""Bodies up to this size never wait [bytes]."""


class Bodies:
    """The bodies of requests that are in memory; for use in the event loop of a server only."""

    def __init__(self, *, total: int = MAX_TOTAL) -> None:
        """Start without bodies.

        Args:
            total: Maximum size of all [bytes].
        """
        self._total = self._left = total
        self._changed = asyncio.Condition()

    @asynccontextmanager
    async def room(self, size: int) -> AsyncIterator[None]:
        """Wait until a body of some size fits among the others [bytes]; it counts until the block ends."""
        if size <= MAX_SMALL_BODY:
            yield
            return
        size = min(size, self._total)
        async with self._changed:
            await self._changed.wait_for(lambda: self._left >= size)
            self._left -= size
        try:
            yield
        finally:
            async with self._changed:
                self._left += size
                self._changed.notify_all()
