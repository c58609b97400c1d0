"""A browser opened at an address that no other user of the machine can read."""

import os
import shutil
import tempfile
import threading
import webbrowser
from collections.abc import Callable
from html import escape
from pathlib import Path

from mjsim.closing import Closes
from mjsim.web.keys import LIFETIME

_REDIRECT = """<!doctype html>
<meta charset="utf-8">
<meta name="referrer" content="no-referrer">
<meta http-equiv="refresh" content="0; url={url}">
<title>mjsim</title>
<p><a href="{url}">Opening the page …</a></p>
"""


class BrowserOpener(Closes):
    """Opens the browser in threads of its own, and leaves no file behind."""

    def __init__(self) -> None:
        """Open nothing yet."""
        self._closed = threading.Event()
        self._private: list[tuple[threading.Thread, threading.Event]] = []

    def open(self, address: str, *, failed: Callable[[], None]) -> None:
        """Open an address that is no secret.

        Args:
            address: Of the page, or of a file.
            failed: Called when there is no browser, from another thread.
        """

        def launch() -> None:
            if not webbrowser.open(address) and not self._closed.is_set():
                failed()

        # Some browsers block until they are closed.
        threading.Thread(target=launch, name="browser", daemon=True).start()

    def open_privately(self, url: str, over: threading.Event, *, failed: Callable[[], None]) -> None:
        """Open an address that is a secret, through a file that redirects to it; command lines can be read by all.

        Args:
            url: Of the page.
            over: Set once the address is of no use any more; then the file goes.
            failed: Called when there is no browser, from another thread.
        """
        folder = Path(tempfile.mkdtemp(prefix="mjsim-", dir=_seen_by_browsers()))  # for its owner alone
        file = folder / "open.html"
        with open(os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as text:
            text.write(_REDIRECT.format(url=escape(url)))

        def remove() -> None:
            over.wait(LIFETIME)
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
            remover.join()


def _seen_by_browsers() -> Path | None:
    """Return a folder whose files browsers can read; None for that of temporary files.

    Browsers that are installed as snaps see neither that nor hidden folders.
    """
    return Path.home() if Path("/snap/bin").is_dir() else None
