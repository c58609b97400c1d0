"""The bus by itself: where it listens, and that it leaves nothing behind."""

import os
import socket
import stat
from pathlib import Path

import pytest

from mjsim.errors import UsageError

pytest.importorskip("cyclonedds", reason="no wheel for Python 3.14")

from mjsim.bridge import Bus

DOMAIN = 10 + (os.getpid() + 45) % 90
"""One that nobody else is likely to use."""


def sockets() -> list[tuple[str, str]]:
    """Return address and device of each socket for datagrams of IP that this process has."""
    found = []
    for descriptor in map(int, os.listdir("/proc/self/fd")):
        try:
            is_socket = stat.S_ISSOCK(os.fstat(descriptor).st_mode)
        except OSError:
            continue  # that of the listing itself
        if is_socket:
            with socket.socket(fileno=os.dup(descriptor)) as each:
                if each.family == socket.AF_INET and each.type == socket.SOCK_DGRAM:
                    device = each.getsockopt(socket.SOL_SOCKET, socket.SO_BINDTODEVICE, 16)
                    found.append((each.getsockname()[0], device.rstrip(b"\0").decode()))
    return found


@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="asks Linux")
def test_a_bus_hears_loopback_alone_and_leaves_no_socket_behind(tmp_path):
    before = sockets()
    with (tmp_path / "open").open("w") as held:
        for _ in range(2):
            with Bus(domain=DOMAIN):
                ours = sockets()[len(before) :]
                assert ours
                assert all(address == "127.0.0.1" or device == "lo" for address, device in ours)
                with pytest.raises(UsageError, match=f"this process is in domain {DOMAIN} already"):
                    Bus(domain=DOMAIN)
            assert sockets() == before
        # A descriptor that stays open keeps the locks of files that are being written.
        links = [os.path.realpath(f"/proc/self/fd/{name}") for name in os.listdir("/proc/self/fd")]
        assert links.count(os.path.realpath(held.name)) == 1


@pytest.mark.parametrize("interface", ["eth99", "203.0.113.9", "::1"])
def test_an_interface_that_is_not_there_is_refused(interface):
    with pytest.raises(UsageError, match=f"no network interface, nor IPv4 address of one, '{interface}'"):
        Bus(domain=DOMAIN, interface=interface)
