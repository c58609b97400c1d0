"""Opens a browser at an address that other users of the machine cannot read."""

import os
import shutil
import tempfile
import threading
import webbrowser
from collections.abc import Callable
from html import escape
from pathlib import Path

from mjsim.closing import Closes, join
from mjsim.web.server.session_keys import LIFETIME_SECONDS

_REDIRECT = """<!doctype html>
<meta charset="utf-8">
<meta name="referrer" content="no-referrer">
<meta http-equiv="refresh" content="0; url={url}">
<title>mjsim</title>
<p><a href="{url}">Opening the page …</a></p>
"""


class BrowserOpener(Closes):
    """Opens browsers in separate threads, and removes its temporary files."""

    def __init__(self) -> None:
        """Open nothing yet."""
        self._closed = threading.Event()
        self._private: list[tuple[threading.Thread, threading.Event]] = []

    def open(self, address: str, *, failed: Callable[[], None]) -> None:
        """Open an address that is not secret.

        Args:
            address: Address of the page or a file.
            failed: Called from another thread if there is no browser.
        """

        def launch() -> None:
            if not webbrowser.open(address) and not self._closed.is_set():
                failed()

        # Some browsers block until they are closed.
        threading.Thread(target=launch, name="browser", daemon=True).start()

    def open_privately(self, url: str, over: threading.Event, *, failed: Callable[[], None]) -> None:
        """Open a secret address through a file that redirects to it, since all users can read command lines.

        Args:
            url: Address of the page.
            over: Set when the address is no longer valid; the file is then removed.
            failed: Called from another thread if there is no browser.
        """
        folder = Path(tempfile.mkdtemp(prefix="mjsim-", dir=_seen_by_browsers()))  # readable only by its owner
        file = folder / "open.html"
        with open(os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as text:
            text.write(_REDIRECT.format(url=escape(url)))

        def remove() -> None:
            over.wait(LIFETIME_SECONDS)
            shutil.rmtree(folder, ignore_errors=True)

        remover = threading.Thread(target=remove, name="redirect", daemon=True)
        remover.start()
        self._private.append((remover, over))
        self.open(file.as_uri(), failed=failed)

    def close(self) -> None:
        """Remove all files."""
        self._closed.set()
        for remover, over in self._private:
            over.set()
            join(remover)


def _seen_by_browsers() -> Path | None:
    """Return a folder that browsers can read; None for that of temporary files.

    Browsers installed as snaps can read neither that nor hidden folders.
    """
    return Path.home() if Path("/snap/bin").is_dir() else None
