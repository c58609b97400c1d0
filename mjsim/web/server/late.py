"""Routes that are loaded while the server already serves: a request for one of them waits until they are there."""

import asyncio
import errno
import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from typing import NamedTuple

from starlette.routing import BaseRoute, Mount, Router
from starlette.types import Receive, Scope, Send


class Loaded(NamedTuple):
    """What was loaded."""

    routes: Sequence[BaseRoute]
    closing: Sequence[Callable[[], None]]
    """Called on closing."""


RETRY_SECONDS = 0.2
"""Time after which routes are loaded again if no file descriptor was free [s]."""


class LateRoutes:
    """An application of routes that a thread loads, again and again while the process has too many open files."""

    def __init__(self, load: Callable[[], Loaded], *, before: Sequence[BaseRoute] = ()) -> None:
        """Store how to load them; if it raises an error, each request gets it.

        Args:
            load: Called in the thread.
            before: Routes that are there at once. A request that only differs from them in its method comes here too.
        """
        self._load, self._loaded, self._before = load, Future[Loaded](), before
        self._thread = threading.Thread(target=self._run, name="mjsim-loading")
        self._closing = threading.Event()
        self._router: Router | None = None
        self.mount = Mount("", self)
        """Takes every address that no route before it takes."""

    def start(self) -> None:
        """Start loading; until then, requests wait."""
        self._thread.start()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request."""
        if self._router is None:
            # A browser that disconnects meanwhile cancels nothing.
            loaded = await asyncio.shield(asyncio.wrap_future(self._loaded))
            self._router = Router([*self._before, *loaded.routes])
        await self._router(scope, receive, send)

    def close(self) -> None:
        """Wait for the routes to load, and close them; do nothing if loading was never started."""
        self._closing.set()
        if self._thread.ident is None:
            return
        self._thread.join()
        if self._loaded.exception() is None:
            for call in self._loaded.result().closing:
                call()

    def _run(self) -> None:
        while True:
            try:
                self._loaded.set_result(self._load())
                return
            except BaseException as error:
                # A library that is not found for lack of files is an ImportError.
                if os.strerror(errno.EMFILE) not in str(error) or self._closing.wait(RETRY_SECONDS):
                    self._loaded.set_exception(error)
                    return
