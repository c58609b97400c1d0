"""The studio: one page to edit worlds, to run them, and to look at what was recorded."""

from pathlib import Path

from mjsim.closing import Closes
from mjsim.errors import UsageError
from mjsim.web.edit_api import EditApi
from mjsim.web.folder import Folder
from mjsim.web.items import scene_of
from mjsim.web.local import LOOPBACK
from mjsim.web.review_api import ReviewApi
from mjsim.web.run_api import RunApi
from mjsim.web.server import Server
from mjsim.web.static_page import page_routes
from mjsim.web.trust import Trust


class Studio(Closes):
    """Serves the studio for the files of one folder, in threads of its own, until it is closed."""

    def __init__(
        self,
        folder: str | Path = ".",
        *,
        world: str | None = None,
        host: str = LOOPBACK,
        port: int = 0,
        token: str | None = None,
    ) -> None:
        """Begin to serve.

        Args:
            folder: Worlds, pictures and modules of this folder are seen; nothing outside of it is read or written.
            world: What the page opens at first, from the folder.
            host: Address to listen at; another than this machine's own needs a token, which is made unless given.
            port: Of the page; a free one unless given.
            token: That everybody must have.

        Raises:
            UsageError: There is no such folder or world, or the page cannot be served there.
        """
        place, trust = Folder(Path(folder)), Trust()
        if world is not None and not place.path(world).is_file():
            raise UsageError(f"no file '{world}' in {place.root}; name a world file")
        edit = EditApi(place, trust, world=world)
        run, review = RunApi(place, trust, scene=scene_of), ReviewApi(place, scene=scene_of)
        routes = [*page_routes(), *edit.routes, *run.routes, *review.routes]
        self._server = Server(routes, host=host, port=port, token=token, closing=[run.close, review.close, edit.close])

    @property
    def url(self) -> str:
        """Address of the page, with its token when it has one."""
        return self._server.url

    def wait(self) -> None:
        """Serve until it is closed from elsewhere, or Ctrl-C interrupts."""
        self._server.wait()

    def close(self) -> None:
        """Stop serving; closing twice is no fault."""
        self._server.close()
