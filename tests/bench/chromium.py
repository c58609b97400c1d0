"""A headless Chromium for measurements, pictures and tests of the studio's page."""

import json
import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from types import MappingProxyType
from typing import Literal
from weakref import WeakKeyDictionary

from playwright.sync_api import Browser, ConsoleMessage, Error, Page, sync_playwright

from mjsim.errors import UsageError

NAMES = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
"""Programs, the leanest first: without a browser's own pages a test takes a fifth less processor time."""
REMEDY = "'apt-get install chromium-headless-shell', or name one in MJSIM_CHROMIUM"
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
PATIENCE = 40_000
"""Nothing on the page takes this long [ms], on however loaded a machine: less than the limit of a test."""
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
        raise UsageError(f"no chromium on this machine; {REMEDY}")
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
    own: bool = False,
    remembers: Mapping[str, str] = MappingProxyType({}),
) -> Iterator[Page]:
    """Open a page in a window that remembers nothing; its errors fail the test when it is closed.

    Args:
        browser: Opens it.
        url: Address of the page, which may be a one-time address.
        width: Of the page [px].
        height: Of the page [px].
        scheme: Colours that the page prefers.
        touch: Whether the screen can be touched.
        own: Whether the window is new, and is closed at the end: for who needs that, or adds scripts, listeners or
            sessions to the page. Otherwise it is that of the page before, which saves a third of the processor time.
        remembers: What the page remembers of visits before, by its keys: there before its first script reads them.
    """
    errors: list[str] = []

    def complain(error: Error) -> None:
        errors.append(str(error))

    def listen(message: ConsoleMessage) -> None:
        errors.extend(_complaints(message))

    with _own_window(browser, touch=touch) if own or touch else _window(browser) as page:
        page.set_viewport_size({"width": width, "height": height})
        page.emulate_media(color_scheme=scheme, reduced_motion="reduce")  # no colour, no size is on its way
        page.on("pageerror", complain)
        page.on("console", listen)
        with _remembering(page, remembers):
            page.goto(url)
            # A one-time address leads on by itself.
            page.wait_for_url(lambda now: "token=" not in now)
        yield page
        page.remove_listener("pageerror", complain)
        page.remove_listener("console", listen)
    assert errors == [], errors


@contextmanager
def _remembering(page: Page, remembers: Mapping[str, str]) -> Iterator[None]:
    """Put this into the storage of each page that the block opens, before any script of it."""
    if not remembers:
        yield
        return
    session = page.context.new_cdp_session(page)
    session.send("Page.enable")
    put = f"Object.assign(localStorage, {json.dumps(dict(remembers))})"
    session.send("Page.addScriptToEvaluateOnNewDocument", {"source": put})
    try:
        yield
    finally:
        session.detach()  # the script goes with it


def _new_page(browser: Browser, *, touch: bool = False) -> Page:
    context = browser.new_context(has_touch=touch)
    context.set_default_timeout(PATIENCE)
    return context.new_page()


@contextmanager
def _own_window(browser: Browser, *, touch: bool) -> Iterator[Page]:
    page = _new_page(browser, touch=touch)
    try:
        yield page
    finally:
        page.context.close()


_left: WeakKeyDictionary[Browser, Page] = WeakKeyDictionary()
"""What the page before has left, of each browser."""


@contextmanager
def _window(browser: Browser) -> Iterator[Page]:
    """Yield the page before, which has forgotten all; one that fails, or has others beside it, is left to nobody."""
    page, kept = _left.pop(browser, None) or _new_page(browser), False
    try:
        yield page
        if page.context.pages == [page] and browser not in _left:
            page.unroute_all()
            page.evaluate("localStorage.clear(), sessionStorage.clear()")
            page.context.clear_cookies()
            page.context.clear_permissions()
            _left[browser], kept = page, True
    finally:
        if not kept:
            page.context.close()


def _complaints(message: ConsoleMessage) -> list[str]:
    told = message.type == "error" and not any(part in message.text for part in WANTED)
    return [f"{message.text} {message.location.get('url', '')}"] if told else []
