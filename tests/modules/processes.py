"""Processes that a test has started, as the system tells of them."""

import subprocess
import time


def left_running(word: str) -> list[str]:
    """Return the processes whose command line holds a word, as ps tells."""
    lines = subprocess.run(
        ["ps", "-eww", "-o", "pid,args"], capture_output=True, text=True, check=True
    ).stdout.splitlines()
    return [line for line in lines if word in line and "ps -eww" not in line]


def gone(word: str, seconds: float = 30.0) -> bool:
    """Wait until no process has a word in its command line; False when one stays."""
    until = time.monotonic() + seconds
    while left_running(word) and time.monotonic() < until:
        time.sleep(0.02)
    return not left_running(word)
