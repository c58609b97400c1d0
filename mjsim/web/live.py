"""Shows a running simulation in a browser on this machine."""

from collections.abc import Callable
from typing import Any

from starlette.requests import Request
from starlette.routing import Route

from mjsim.closing import Closes
from mjsim.errors import UsageError, did_you_mean
from mjsim.record import Tick
from mjsim.sentences import Sentence
from mjsim.session import Session
from mjsim.web.run import RunApi
from mjsim.web.server import Server, answer_get, page_routes
from mjsim.web.worlds import Trust, scene_of
from mjsim.world import World


class LiveView(Closes):
    """The Run view of the studio at the loopback address; call `show` for each tick within the block.

    A browser gets the newest tick and pictures, and skips what it is too slow for; it never blocks the run. Pictures
    are encoded in other threads, and only while somebody watches. The page only displays the run, unless `steer` lets
    it control a session.
    """

    def __init__(self, world: World, robot: str | None = None, *, port: int = 0) -> None:
        """Start serving the page.

        Args:
            world: World of the run.
            robot: Robot shown first; by default the first one.
            port: Port of the page; by default a free one.

        Raises:
            UsageError: The robot does not exist, or the port is taken.
        """
        names = [item.name for item in world.robots]
        if robot is not None and robot not in names:
            raise UsageError(
                Sentence("no robot '{robot}' to show in this world{meant}", robot, did_you_mean(robot, names))
            )
        self._world, self._robot = world, robot
        self._api = RunApi(None, Trust(), scene=scene_of)
        self._api.stage.put_on(world, None, first=robot)
        routes = [*page_routes(), Route("/api/folder", answer_get(self._folder), methods=["GET"]), *self._api.routes]
        self._server = Server(routes, port=port, closing=[self._api.close])

    @property
    def address(self) -> str:
        """Address of the page; unauthenticated browsers are asked for a one-time address there."""
        return self._server.address

    @property
    def url(self) -> str:
        """A new address that admits one browser, once, within five minutes."""
        return self._server.url

    def open(self, *, failed: Callable[[], None]) -> None:
        """Open the page in the browser of this machine, authenticated; `failed` is called if there is no browser."""
        self._server.open(failed=failed)

    def show(self, tick: Tick) -> None:
        """Pass on a tick; this is fast regardless of the number of viewers."""
        self._api.stage.take(tick)

    def steer(self, session: Session) -> None:
        """Let the page pause, slow down and restart a session, and drive its robots; its ticks are passed to `show`."""
        self._api.stage.put_on(self._world, session, first=self._robot)

    def changed(self) -> None:
        """Tell viewers that the state of the session has changed."""
        self._api.stage.changed()

    def close(self) -> None:
        """Show viewers the last tick, then stop serving; a second call does nothing."""
        self._server.close()

    def _folder(self, _: Request) -> dict[str, Any]:
        """Return the folder listing that the page requests first: empty, except for this run."""
        kinds = ("worlds", "pictures", "models", "arms", "presets", "templates")
        shipped: dict[str, Any] = {kind: [] for kind in kinds} | {"about": {}, "sensors": {}}
        files: dict[str, Any] = {kind: [] for kind in ("worlds", "recordings", "sweeps", "pictures", "models")}
        return {"folder": "", **files, "shipped": shipped, "world": self._world.name, "mode": "live"}
