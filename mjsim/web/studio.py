"""The studio: a page to edit worlds, run them and review recordings."""

from collections.abc import Callable
from pathlib import Path

from mjsim.closing import Closes
from mjsim.errors import UsageError
from mjsim.web.server import LOOPBACK, LateRoutes, Loaded, Server, page_routes
from mjsim.web.worlds import Folder, is_shipped

PRELOAD = ("/api/folder", "/api/schema")
"""Data that the page requests first."""


class Studio(Closes):
    """Serves the studio for the files of one folder, in separate threads, until it is closed."""

    def __init__(
        self,
        folder: str | Path = ".",
        *,
        world: str | None = None,
        host: str = LOOPBACK,
        port: int = 0,
        token: str | None = None,
        without_token: bool = False,
    ) -> None:
        """Start serving.

        Args:
            folder: Folder with worlds, pictures and modules; nothing outside it is read or written.
            world: World that the page opens first: a file of the folder, or `shipped:NAME` for a shipped world.
            host: Address on which to listen.
            port: Port of the page; by default a free one.
            token: Admits clients that know it, in addition to the one-time addresses from `url`; at least 16
                characters.
            without_token: Admit every user and program of this machine; for loopback addresses only.

        Raises:
            UsageError: The folder or world does not exist, or the page cannot be served there.
        """
        place = Folder(Path(folder))
        if world is not None and not is_shipped(world) and not place.path(world).is_file():
            raise UsageError(f"no file '{world}' in {place.root}; name a world file")
        self.asks_for_token = not without_token
        pages = page_routes(preload=PRELOAD)
        late = LateRoutes(lambda: _loaded(place, world), before=pages)
        routes, closing = [*pages, late.mount], [late.close]
        self._server = Server(routes, host=host, port=port, token=token, without_token=without_token, closing=closing)
        late.start()

    @property
    def address(self) -> str:
        """Address of the page; unauthenticated browsers are asked for the token there."""
        return self._server.address

    @property
    def url(self) -> str:
        """A new address that admits one browser, once, within five minutes; `address` if no token is required."""
        return self._server.url

    def open(self, *, failed: Callable[[], None]) -> None:
        """Open the page in the browser of this machine, authenticated.

        Args:
            failed: Called from another thread if there is no browser.
        """
        self._server.open(failed=failed)

    def wait(self) -> None:
        """Serve until it is closed from elsewhere, or Ctrl-C interrupts."""
        self._server.wait()

    def close(self) -> None:
        """Stop serving; a second call does nothing."""
        self._server.close()


def _loaded(folder: Folder, world: str | None) -> Loaded:
    """Load what editing, running and reviewing need, such as MuJoCo, while the browser gets the page."""
    from mjsim.web.edit import EditApi
    from mjsim.web.review import ReviewApi
    from mjsim.web.run import RunApi
    from mjsim.web.warm import warm_up
    from mjsim.web.worlds import Tabs, Trust, scene_of

    warm_up()
    trust, tabs = Trust(), Tabs(folder)
    edit = EditApi(folder, trust, world=world, saved=tabs.wake)
    run, review = RunApi(folder, trust, scene=scene_of), ReviewApi(folder, scene=scene_of)
    parts = (tabs, run, review, edit)
    return Loaded([route for part in parts for route in part.routes], [part.close for part in parts])
