"""Processes that a test has started, as the system tells of them."""

import time

from tests.children import completed


def left_running(word: str) -> list[str]:
    """Return the processes whose command line holds a word, as ps tells."""
    lines = completed(["ps", "-eww", "-o", "pid,args"]).stdout.splitlines()
    return [line for line in lines if word in line and "ps -eww" not in line]


def gone(word: str, seconds: float = 30.0) -> bool:
    """Wait until no process has a word in its command line; False when one stays."""
    until = time.monotonic() + seconds
    while left_running(word) and time.monotonic() < until:
        time.sleep(0.02)
    return not left_running(word)
