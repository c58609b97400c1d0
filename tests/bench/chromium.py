"""A headless Chromium for measurements, pictures and tests of the studio's page."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Literal

from playwright.sync_api import Browser, ConsoleMessage, Page, sync_playwright

from mjsim.errors import UsageError

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
FEATURES_OFF = (
    # Pages of the browser's own for its address bar: two more renderers, half of the processor time of a window.
    *("WebUIOmniboxPopup", "WebUIOmniboxAimPopup", "WebUIOmniboxFullPopup"),
    # Chromium heeds the last such list alone, so what Playwright turns off is repeated.
    *("AimEnabled", "AvoidCorsURLLoaderRestartOnRedirect", "AvoidUnnecessaryBeforeUnloadCheckSync"),
    *(
        "DestroyProfileOnBrowserClose",
        "HttpsFirstBalancedModeAutoEnable",
        "HttpsUpgrades",
        "LensOverlay",
        "MediaRouter",
    ),
    *("NetworkTimeServiceQuerying", "OptimizationHints", "PaintHolding", "PreconnectToSearch"),
    "ThirdPartyStoragePartitioning",
)
ARGUMENTS = [
    f"--disable-features={','.join(FEATURES_OFF)}",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
PATIENCE = 60_000
"""Nothing on the page takes this long [ms], on however loaded a machine."""
WANTED = (
    *("ERR_CONNECTION_", "ERR_EMPTY_RESPONSE", "WebSocket connection"),
    *("409 (Conflict)", "401 (Unauthorized)", "403 (Forbidden)"),
)
"""What chromium says on its own when a server is gone, or refuses a change, a browser or code: some tests want it."""


def chromium_path() -> str | None:
    """Return the path of a Chromium: the one that MJSIM_CHROMIUM names, or the system's; None without one."""
    return os.environ.get("MJSIM_CHROMIUM") or next(filter(None, map(shutil.which, NAMES)), None)


@contextmanager
def chromium() -> Iterator[Browser]:
    """Start a browser.

    Raises:
        UsageError: There is none on this machine.
    """
    path = chromium_path()
    if path is None:
        raise UsageError("no chromium on this machine; 'apt-get install chromium', or name one in MJSIM_CHROMIUM")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=ARGUMENTS)
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def page_at(
    browser: Browser,
    url: str,
    *,
    width: int = 1280,
    height: int = 720,
    scheme: Literal["light", "dark"] = "light",
    touch: bool = False,
) -> Iterator[Page]:
    """Open a page in a window of its own, which remembers nothing; its errors fail the test when it is closed."""
    context = browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme, has_touch=touch)
    context.set_default_timeout(PATIENCE)
    errors: list[str] = []
    page = context.new_page()
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("console", lambda message: errors.extend(_complaints(message)))
    page.goto(url)
    # A one-time address leads on by itself.
    page.wait_for_url(lambda now: "token=" not in now)
    try:
        yield page
    finally:
        context.close()
    assert errors == [], errors


def _complaints(message: ConsoleMessage) -> list[str]:
    told = message.type == "error" and not any(part in message.text for part in WANTED)
    return [f"{message.text} {message.location.get('url', '')}"] if told else []
