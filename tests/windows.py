"""A real chromium for tests of the page; they are skipped where there is none."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from playwright.sync_api import Browser

from mjsim.bench.chromium import PATIENCE, chromium_path, page_at
from mjsim.bench.chromium import chromium as chromium_or_error

__all__ = ["PATIENCE", "chromium", "page_at"]


@contextmanager
def chromium() -> Iterator[Browser]:
    """Start a browser; skip the test, and say what to install, where there is none."""
    if chromium_path() is None:
        pytest.skip("no chromium on this machine; 'apt-get install chromium', or name one in MJSIM_CHROMIUM")
    with chromium_or_error() as browser:
        yield browser
