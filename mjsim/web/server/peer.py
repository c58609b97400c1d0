"""Identity of a peer: its address and, on this machine, its user."""

import socket
import sys
from pathlib import Path

from mjsim.web.server.local import is_loopback

_TABLES = (Path("/proc/self/net/tcp"), Path("/proc/self/net/tcp6"))
_ESTABLISHED = "01"


def peer_of(client: tuple[str, int], server: tuple[str, int]) -> str:
    """Return the identity of a peer: its address, or on loopback under Linux its user id.

    Args:
        client: Address and port of the remote end.
        server: Address and port of the local end.
    """
    if not is_loopback(client[0]):
        return client[0]
    user = _user_of(client, server)
    return client[0] if user is None else f"user {user}"


def _user_of(client: tuple[str, int], server: tuple[str, int]) -> int | None:
    """Return the user whose program holds the other end of a loopback connection; None if unknown.

    Only established connections count: the kernel lists closed ones under root.
    """
    for table in _TABLES:
        try:
            rows = table.read_text(encoding="ascii")
        except OSError:
            continue
        for mapped in (False, True):
            wanted = f" {_shown(client, mapped)} {_shown(server, mapped)} {_ESTABLISHED} "
            _, found, rest = rows.partition(wanted)
            if found:
                # Queues, timer and retransmissions precede it.
                return int(rest.split(maxsplit=4)[3])
    return None


def _shown(end: tuple[str, int], mapped: bool) -> str:
    """Return address and port in the format of the kernel's table; `mapped` means IPv4 within IPv6."""
    host, port = end
    if ":" in host:
        raw = socket.inet_pton(socket.AF_INET6, host.partition("%")[0])
    else:
        raw = bytes(10) * mapped + b"\xff\xff" * mapped + socket.inet_pton(socket.AF_INET, host)
    words = (int.from_bytes(raw[k : k + 4], sys.byteorder) for k in range(0, len(raw), 4))
    return f"{''.join(f'{word:08X}' for word in words)}:{port:04X}"
