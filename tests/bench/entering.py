"""A browser's way into a page: a one-time address is exchanged for the cookie of a session."""

from collections.abc import Iterator
from contextlib import contextmanager

import httpx

PATIENCE = 120.0
"""No answer takes this long [s], on however loaded a machine."""


@contextmanager
def client_of(url: str) -> Iterator[httpx.Client]:
    """Yield a client that was let in by a one-time address of a page."""
    address = httpx.URL(url).copy_with(query=None)
    # Certificates, which plain HTTP has none of, would take most of the time.
    with httpx.Client(base_url=address, timeout=PATIENCE, trust_env=False, verify=False) as client:
        answer = client.get(url)
        assert answer.status_code == 200, answer.text
        yield client


def cookie_of(client: httpx.Client) -> dict[str, str]:
    """Return the header that tells who a client is."""
    return {"Cookie": "; ".join(f"{name}={value}" for name, value in client.cookies.items())}


def socket_of(client: httpx.Client, at: str = "/api/run") -> str:
    """Return the address of a page's WebSocket, that of the run unless told otherwise."""
    return str(client.base_url.copy_with(scheme="ws").join(at))
