"""A real chromium for tests of the page; they are skipped where there is none."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest
from playwright.sync_api import Browser, Page

from mjsim.bench.chromium import PATIENCE, REMEDY, chromium_path
from mjsim.bench.chromium import chromium as chromium_or_error
from mjsim.bench.chromium import page_at as opened

__all__ = ["PATIENCE", "agreed", "chromium", "page_at", "without_portraits"]
NO_PICTURE = '<svg xmlns="http://www.w3.org/2000/svg" width="4" height="3"/>'


@contextmanager
def chromium() -> Iterator[Browser]:
    """Start a browser; skip the test, and say what to install, where there is none."""
    if chromium_path() is None:
        pytest.skip(f"no chromium on this machine; {REMEDY}")
    with chromium_or_error() as browser:
        yield browser


@contextmanager
def page_at(browser: Browser, url: str, *, outside: bool = False, **window) -> Iterator[Page]:
    """Open a page, without the view of runs from outside unless it is wanted: to draw it costs much."""
    with opened(browser, url, remembers={} if outside else {"mjsim.run.outside": "no"}, **window) as page:
        yield page


def without_portraits(page: Page) -> None:
    """Give dialogs blank portraits of what can be chosen: to draw all of them takes as long as everything else."""
    page.route("**/api/portrait?*", lambda route: route.fulfill(content_type="image/svg+xml", body=NO_PICTURE))


def agreed(page: Page, first: Callable[[], str], second: Callable[[], str]) -> str:
    """Wait until two values that both still change are the same, and return it: each may be behind the other."""
    until = time.monotonic() + PATIENCE / 1000
    while (one := first()) != (other := second()):
        assert time.monotonic() < until, f"{one[:200]} is not {other[:200]}"
        page.wait_for_timeout(50)  # the page goes on meanwhile
    return one
