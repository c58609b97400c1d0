"""Functions that the tests run in the guarded reader: what decoders do with files of strangers."""

import ctypes
import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from mjsim.errors import Problem, RecordingError, UsageError, WorldError
from mjsim.guarded import still_working

KEPT = []


def same(value):
    """Return what was given."""
    return value


def process():
    """Return the number of this process."""
    return os.getpid()


def limits_here():
    """Return the limits of private memory and address space [bytes] and of processor time, and what is used [s]."""
    import resource

    kinds = resource.RLIMIT_DATA, resource.RLIMIT_AS, resource.RLIMIT_CPU
    return [*(resource.getrlimit(kind)[0] for kind in kinds), time.process_time()]


def text_of(path):
    """Return the text of a file."""
    return Path(path).read_text()


def crash():
    """End with a segmentation fault."""
    ctypes.string_at(0)


def hang():
    """Hold the interpreter's lock for ever, deaf to signals."""
    ctypes.PyDLL(None).usleep(2**31)


def turn():
    """Compute for ever."""
    while True:
        pass


def swell(megabytes):
    """Fill memory."""
    return np.empty(megabytes * 2**17).nbytes


def hoard(megabytes):
    """Keep memory after the call, as libraries with caches do."""
    KEPT.append(np.empty(megabytes * 2**17))


def fail(kind):
    """Raise an error."""
    raise {"library": ZeroDivisionError, "usage": UsageError, "recording": RecordingError}[kind](f"of a {kind}")


def wrong_world():
    """Raise the error of a world."""
    raise WorldError([Problem("room.yaml", 2, 3, "height is -2.0 m; it must be above 0")])


def missing_library():
    """Import what is not there."""
    import not_there_at_all  # noqa: F401


def object_of_own():
    """Return what cannot cross."""
    return object()


def deaf():
    """Return, and read no further call, as a child that a file has taken over may."""
    sys.modules["__main__"]._next = lambda requests: hang()


def lie(answer):
    """Send an answer of our own, as a child that a file has taken over may."""
    sys.modules["__main__"].answers_to = lambda request: [answer]


def forged():
    """Write to every descriptor what an answer begins with."""
    for descriptor in range(3, 20):
        try:
            os.write(descriptor, b"\xff" * 64)
        except OSError:
            continue


def count(parts, *, then=""):
    """Yield numbers, then fail."""
    yield from range(parts)
    if then:
        raise UsageError(then)


def slow_parts(seconds) -> Iterator[int]:
    """Yield a number after some time, for ever."""
    while True:
        time.sleep(seconds)
        yield 1


def work(rounds, seconds):
    """Take several times some time, and say each time that it goes on."""
    for _ in range(rounds):
        time.sleep(seconds)
        still_working()
    return rounds


def temporary(text):
    """Return the text of a temporary file after writing it."""
    import tempfile

    with tempfile.NamedTemporaryFile("w+") as file:
        file.write(text)
        file.flush()
        return Path(file.name).read_text(), file.name


def descriptors():
    """Return the open descriptors that are no pipe of the reader, nor the null device."""
    opened = [each for each in range(3, 256) if os.path.exists(f"/proc/self/fd/{each}")]
    return [place for each in opened if not (place := os.readlink(f"/proc/self/fd/{each}")).startswith("pipe:")]


def attempt(what, place):
    """Return the error with which the system refuses an attempt; None if it allows it."""
    try:
        ATTEMPTS[what](place)
    except OSError as error:
        return type(error).__name__, error.errno
    return None


ATTEMPTS = {
    "read": lambda place: Path(place).read_text(),
    "list": lambda place: os.listdir(Path(place).parent),
    "write": lambda place: Path(place).write_text("written"),
    "append": lambda place: os.open(place, os.O_WRONLY | os.O_APPEND),
    "delete": os.unlink,
    "rename": lambda place: os.rename(place, f"{place}.old"),
    "link": lambda place: os.symlink(place, f"{place}.link"),
    "make folder": lambda place: os.mkdir(f"{place}.folder"),
    "change mode": lambda place: os.chmod(place, 0o777),
    "connect": lambda place: socket.create_connection(("127.0.0.1", 9), timeout=1),
    "local socket": lambda place: socket.socketpair(),
    "program": lambda place: subprocess.run([sys.executable, "-c", ""], check=True, timeout=10),
    "replace itself": lambda place: os.execv(sys.executable, [sys.executable, "-c", ""]),
    "fork": lambda place: os.fork() or os._exit(0),
    "kill parent": lambda place: os.kill(os.getppid(), 0),
    "trace parent": lambda place: _call("ptrace", 16, os.getppid(), 0, 0),
    "memory of parent": lambda place: Path(f"/proc/{os.getppid()}/environ").read_bytes(),
    "own limits": lambda place: _call("setrlimit", 9, ctypes.byref((ctypes.c_ulong * 2)(2**63, 2**63))),
    "memory file": lambda place: os.memfd_create("code"),
}


def _call(name, *arguments):
    libc = ctypes.CDLL(None, use_errno=True)
    if getattr(libc, name)(*arguments) < 0:
        raise OSError(ctypes.get_errno(), name)
