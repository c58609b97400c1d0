"""A network that only this process and those that its user lets in can reach: a Linux network namespace.

References:
    user_namespaces(7), network_namespaces(7), unshare(2), netdevice(7).
"""

import ctypes
import fcntl
import os
import socket
import struct
from pathlib import Path

from mjsim.errors import UsageError

_NEW_USER, _NEW_NETWORK = 0x10000000, 0x40000000
_GET_FLAGS, _SET_FLAGS = 0x8913, 0x8914
_UP, _MULTICAST = 0x1, 0x1000
_REQUEST = "16sH14s"
"""A `struct ifreq`: the name of the interface, and its flags."""


def enter_private_network() -> str:
    """Move this process into a new network, whose only interface is loopback; return the command that joins it.

    Only processes of the same user, and root, can join. Child processes share the network; no other machine can be
    reached from it.

    Raises:
        UsageError: The system does not allow it, or the process already has several threads (NumPy starts some).
    """
    user, group = os.getuid(), os.getgid()
    try:
        _unshare(_NEW_USER | _NEW_NETWORK)
        # The kernel lets a user without privileges map groups only after giving up `setgroups`.
        Path("/proc/self/setgroups").write_text("deny")
        Path("/proc/self/uid_map").write_text(f"{user} {user} 1")
        Path("/proc/self/gid_map").write_text(f"{group} {group} 1")
        bring_loopback_up()
    except (OSError, AttributeError) as error:
        raise UsageError(
            f"no private network on this system: {error}; it needs Linux that lets users create namespaces, "
            "and must be entered before NumPy is imported"
        ) from error
    return f"nsenter --preserve-credentials -U -n -t {os.getpid()}"


def _unshare(flags: int) -> None:
    """Leave the namespaces of these kinds for new ones. `os.unshare` needs Python 3.12."""
    library = ctypes.CDLL(None, use_errno=True)
    if library.unshare(flags) != 0:
        code = ctypes.get_errno()
        raise OSError(code, os.strerror(code))


def bring_loopback_up() -> None:
    """Switch loopback on, with the multicast by which participants find each other."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        request = struct.pack(_REQUEST, b"lo", 0, b"")
        name, flags, rest = struct.unpack(_REQUEST, fcntl.ioctl(any_socket, _GET_FLAGS, request))
        fcntl.ioctl(any_socket, _SET_FLAGS, struct.pack(_REQUEST, name, flags | _UP | _MULTICAST, rest))
