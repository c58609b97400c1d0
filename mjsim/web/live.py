"""A run to watch in a browser on this machine while it goes on."""

from collections.abc import Callable
from typing import Any

from starlette.requests import Request
from starlette.routing import Route

from mjsim.closing import Closes
from mjsim.errors import UsageError, did_you_mean
from mjsim.record import Tick
from mjsim.session import Session
from mjsim.web.answers import asked
from mjsim.web.items import scene_of
from mjsim.web.run_api import RunApi
from mjsim.web.server import Server
from mjsim.web.static_page import page_routes
from mjsim.web.trust import Trust
from mjsim.world import World


class LiveView(Closes):
    """The Run view of the studio on the loopback address: `show` each tick while the block runs.

    A browser gets the newest tick and the newest pictures, and misses what it has no time for; it holds nobody up.
    Pictures are encoded in other threads, and only while somebody watches. The run goes its own way, unless a
    session is steered from the page, too: `steer`.
    """

    def __init__(self, world: World, robot: str | None = None, *, port: int = 0) -> None:
        """Begin to serve the page.

        Args:
            world: Where the run is.
            robot: Whose run is shown first; by default that of the first one.
            port: Of the page; by default a free one.

        Raises:
            UsageError: The robot does not exist, or the port is taken.
        """
        names = [item.name for item in world.robots]
        if robot is not None and robot not in names:
            raise UsageError(f"no robot '{robot}' to show in this world{did_you_mean(robot, names)}")
        self._world, self._robot = world, robot
        self._api = RunApi(None, Trust(), scene=scene_of)
        self._api.stage.put_on(world, None, first=robot)
        routes = [*page_routes(), Route("/api/folder", asked(self._folder), methods=["GET"]), *self._api.routes]
        self._server = Server(routes, port=port, closing=[self._api.close])

    @property
    def address(self) -> str:
        """Where the page is; browsers that were not let in are asked for a one-time address there."""
        return self._server.address

    @property
    def url(self) -> str:
        """A new address that lets in one browser, once, within five minutes."""
        return self._server.url

    def open(self, *, failed: Callable[[], None]) -> None:
        """Open the page in the browser of this machine, and let it in; `failed` is called when there is none."""
        self._server.open(failed=failed)

    def show(self, tick: Tick) -> None:
        """Hand over a tick; this is quick, however many watch."""
        self._api.stage.take(tick)

    def steer(self, session: Session) -> None:
        """Let the page pause, slow and restart a session, and drive its robots; its ticks are handed over by `show`."""
        self._api.stage.put_on(self._world, session, first=self._robot)

    def changed(self) -> None:
        """Tell who watches that the session is in another state."""
        self._api.stage.changed()

    def close(self) -> None:
        """Show who watches the last tick, then stop serving; closing twice is no fault."""
        self._server.close()

    def _folder(self, _: Request) -> dict[str, Any]:
        """Return what the page asks for first: that there is nothing here but this run."""
        kinds = ("worlds", "pictures", "models", "arms", "presets", "templates")
        shipped: dict[str, Any] = {kind: [] for kind in kinds} | {"about": {}, "sensors": {}}
        files: dict[str, Any] = {kind: [] for kind in ("worlds", "recordings", "sweeps", "pictures", "models")}
        return {"folder": "", **files, "shipped": shipped, "world": self._world.name, "mode": "live"}
