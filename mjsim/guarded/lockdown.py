"""Drops, irrevocably, the rights of this process that a decoder of files does not need."""

import contextlib
import os
import signal
import site
import sys
import sysconfig
from collections.abc import Iterator, Sequence
from importlib.util import find_spec
from pathlib import Path

from mjsim.guarded.landlock import read_only
from mjsim.guarded.limits import Allowance
from mjsim.guarded.request import Permission
from mjsim.guarded.seccomp import refuse_calls

LIBRARIES = 1 << 30
"""Address space for libraries, which are mapped but take little memory [bytes]."""
MAX_FILES = 256
"""Maximum number of open files."""
SYSTEM = (
    *("/lib", "/lib64", "/usr/lib", "/usr/lib64", "/usr/local/lib", "/nix/store", "/gnu/store"),
    *("/etc/ld.so.cache", "/etc/localtime", "/usr/share/zoneinfo", "/sys/devices/system", "/proc/self"),
    *("/proc/cpuinfo", "/proc/meminfo", "/dev/null", "/dev/zero", "/dev/urandom"),
)
"""Files and folders of the system that libraries read."""
PARTS = ("mjsim", "mjsim.algorithms", "mjsim.assets", "mjsim.worlds")
"""Packages with folders of their own, in a clone."""
_PARENT_DIES = 1


def lock_down(start: Permission) -> list[str]:
    """Restrict this process; return the limits that this system lacks, in words."""
    missing = [] if _limited(start.allowance, start.scratch) else ["memory"]
    _end_with(start.parent)
    if not read_only([*_needed(), *start.folders], scratch=start.scratch):
        missing.append("other files")
    # Last, as it refuses what the others need.
    if not refuse_calls(writing=start.scratch is not None):
        missing.append("network and programs")
    return missing


def _limited(allowance: Allowance, scratch: Path | None) -> bool:
    """Limit memory, files and dumps; return whether the memory is limited.

    References:
        setrlimit(2).
    """
    try:
        import resource
    except ImportError:  # Windows
        return False
    written = 0 if scratch is None else allowance.written
    for which, value in (
        (resource.RLIMIT_CORE, 0),
        (resource.RLIMIT_FSIZE, written),
        (resource.RLIMIT_NOFILE, MAX_FILES),
    ):
        _limit(which, value)
    # A write fails then instead of ending the process.
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    # Only on Linux does this count all private writable memory; elsewhere it is the heap.
    return all(_limit(*each) for each in memory_limits(allowance)) and sys.platform == "linux"


def memory_limits(allowance: Allowance) -> Sequence[tuple[int, int]]:
    """Return the resources that limit memory, as in `resource.setrlimit`, with their values [bytes]."""
    import resource

    return (resource.RLIMIT_DATA, allowance.memory), (resource.RLIMIT_AS, allowance.memory + LIBRARIES)


def _limit(which: int, value: int) -> bool:
    """Set a soft limit, which only the parent raises for a larger file; return whether the system supports it."""
    import resource

    hard = resource.getrlimit(which)[1]
    with contextlib.suppress(ValueError, OSError):
        resource.setrlimit(which, (value if hard == resource.RLIM_INFINITY else min(value, hard), hard))
        return True
    return False


def _end_with(parent: int) -> None:
    """End this process when the thread that started it ends.

    References:
        prctl(2), PR_SET_PDEATHSIG.
    """
    if sys.platform != "linux":
        return
    import ctypes

    ctypes.CDLL(None).prctl(_PARENT_DIES, signal.SIGKILL, 0, 0, 0)
    if os.getppid() != parent:
        os._exit(1)


def _needed() -> Iterator[Path]:
    """Yield the folders of Python, its packages, and mjsim, and system files that libraries read."""
    yield from map(Path, SYSTEM)
    yield from (Path(entry) for entry in {sys.prefix, sys.base_prefix, *sysconfig.get_paths().values()})
    yield from (Path(entry) for entry in {*site.getsitepackages(), site.getusersitepackages(), *sys.path} if entry)
    yield from (Path(entry) for entry in os.environ.get("LD_LIBRARY_PATH", "").split(os.pathsep) if entry)
    for part in PARTS:
        found = find_spec(part)
        yield from map(Path, (found.submodule_search_locations or ()) if found else ())
