"""Another user of this machine, who tries things: a function runs in a process without our rights."""

import contextlib
import json
import os
import pwd
import signal
import traceback
import warnings
from collections.abc import Callable
from typing import Any

import pytest

OTHER = "nobody"


def other_user() -> pwd.struct_passwd:
    """Return another user; skip the test where this process cannot become one."""
    if os.geteuid() != 0:
        pytest.skip("only root can act as another user")
    try:
        return pwd.getpwnam(OTHER)
    except KeyError:
        pytest.skip(f"this machine has no user '{OTHER}'")


def as_stranger(work: Callable[[], Any], *, other: bool = True) -> Any:
    """Return what a function gives in a process of its own, as JSON carries it.

    Args:
        work: Runs with nothing but what it closes over.
        other: Whether as another user; else as the same one.
    """
    user = other_user() if other else None
    read, write = os.pipe()
    child = fork()
    if child == 0:
        try:
            os.close(read)
            if user is not None:
                os.setgroups([])
                os.setgid(user.pw_gid)
                os.setuid(user.pw_uid)
            os.write(write, json.dumps({"gave": work()}).encode())
        except BaseException:
            with contextlib.suppress(OSError):
                os.write(write, json.dumps({"failed": traceback.format_exc()}).encode())
        finally:
            os._exit(0)
    os.close(write)
    try:
        with os.fdopen(read, "rb") as pipe:
            told = json.loads(pipe.read() or b'{"failed": "it died"}')
    finally:
        ended(child)
    assert "gave" in told, told["failed"]
    return told["gave"]


def ended(child: int) -> None:
    """Kill a process of ours, if it still runs, and take its end."""
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)


def fork() -> int:
    """Return 0 in a new process, its number in this one; what it calls needs none of this one's threads."""
    with warnings.catch_warnings():
        # Python 3.12 warns where there are threads, such as those of a server.
        warnings.simplefilter("ignore", DeprecationWarning)
        return os.fork()
