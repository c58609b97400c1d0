"""WebSockets whose peers send pings, pieces or nonsense without end: memory and the terminal stay as they are."""

import base64
import json
import socket
import time
from contextlib import contextmanager

import pytest

from mjsim.bench.entering import client_of, cookie_of
from mjsim.web import Studio
from mjsim.web.server.connections import MAX_FRAGMENTS

pytestmark = pytest.mark.slow  # Each starts a server.

PATIENCE = 60.0
"""Nothing takes this long [s], on however loaded a machine."""
TEXT, MORE, PING = 1, 0, 9
KEPT = 1_000_000
"""Data that a peer does not take may add up to a little more than asyncio's 64 kB [bytes]."""


@pytest.fixture
def studio(tmp_path):
    with Studio(tmp_path) as page:
        yield page


@pytest.fixture
def cookie(studio):
    with client_of(studio.url) as client:
        yield cookie_of(client)["Cookie"]


def frame(kind, data=b"", *, last=True):
    """Return a frame with fewer than 126 bytes, masked with zeros."""
    return bytes([0x80 * last | kind, 0x80 | len(data)]) + bytes(4) + data


@contextmanager
def opened(studio, *headers, path="/api/run"):
    """Yield a raw connection that asked for a WebSocket, and how the answer begins."""
    port = int(studio.address.rstrip("/").rpartition(":")[2])
    lines = [f"GET {path} HTTP/1.1", f"Host: 127.0.0.1:{port}", "Upgrade: websocket", "Connection: Upgrade"]
    key = base64.b64encode(bytes(16)).decode()
    lines += [f"Sec-WebSocket-Key: {key}", "Sec-WebSocket-Version: 13", *headers, "\r\n"]
    with socket.create_connection(("127.0.0.1", port), PATIENCE) as raw:
        raw.sendall("\r\n".join(lines).encode())
        yield raw, raw.recv(12)


def ends(raw):
    """Return what comes until the other end closes."""
    told = b""
    try:
        while got := raw.recv(65536):
            told += got
    except ConnectionError:
        pass
    return told


def send_all(raw, data, *, seconds):
    """Send data again and again until a time is over or nobody takes more."""
    raw.settimeout(seconds)
    until = time.monotonic() + seconds
    try:
        while time.monotonic() < until:
            raw.sendall(data)
    except (TimeoutError, ConnectionError):
        return


@pytest.mark.parametrize(
    "more",
    [
        ["Cookie: " + "; ".join(f"other-{k}={'x' * 90}" for k in range(100))],
        [f"Cookie: other-{k}={'x' * 90}" for k in range(150)],
        [f"X-More-{k}: 1" for k in range(150)],
        ["Cookie: " + "; ".join(f"mjsim-session-{k}={'x' * 90}" for k in range(500))],
    ],
    ids=["long", "many", "others", "alike"],
)
def test_a_websocket_opens_with_the_cookies_and_headers_of_other_servers_of_this_machine(studio, cookie, more):
    with opened(studio, f"Cookie: {cookie}", *more) as (_, answer):
        assert answer == b"HTTP/1.1 101"


@pytest.mark.parametrize("more", [[], ["Content-Length: 5"], ["Transfer-Encoding: chunked"]])
def test_without_a_session_it_is_refused_at_once_whatever_its_headers_are(studio, more):
    with opened(studio, "Cookie: " + "x" * 9000, *more) as (raw, answer):
        assert answer == b"HTTP/1.1 403"
        ends(raw)


def test_a_request_for_a_websocket_that_is_too_long_is_answered_and_closed(studio, cookie):
    with opened(studio, f"Cookie: {cookie}", path="/api/run?" + "x" * 20_000) as (raw, answer):
        assert answer == b"HTTP/1.1 431"
        ends(raw)


def test_pings_of_a_peer_that_does_not_read_are_not_all_answered(studio, cookie):
    with opened(studio, f"Cookie: {cookie}") as (raw, _):
        send_all(raw, frame(PING, b"x" * 125) * 500, seconds=1.0)
        [kept] = [
            each.transport.get_write_buffer_size() for each in studio._server._connections._known if is_socket(each)
        ]
        assert kept < KEPT
        # It is answered once it reads: the newest of them last.
        raw.settimeout(PATIENCE)
        raw.sendall(frame(PING, b"the newest"))
        told = b""
        while b"the newest" not in told:
            told = told[-20:] + raw.recv(65536)


def is_socket(visitor):
    return type(visitor.transport.get_protocol()).__name__ == "WebSocketConnection"


def test_a_message_in_pieces_without_end_ends_its_connection(studio, cookie):
    with opened(studio, f"Cookie: {cookie}") as (raw, _):
        raw.sendall(frame(TEXT, b"x", last=False))
        for _ in range(50):
            send_all(raw, frame(MORE, last=False) * (MAX_FRAGMENTS // 10), seconds=0.01)
        raw.settimeout(PATIENCE)
        assert len(ends(raw)) < KEPT


def test_a_message_in_some_pieces_is_read(studio, cookie):
    with opened(studio, f"Cookie: {cookie}") as (raw, _):
        message = json.dumps({"do": "pause"}).encode()
        pieces = [frame(TEXT, message[:1], last=False), *[frame(MORE, last=False)] * 1000, frame(MORE, message[1:])]
        raw.sendall(b"".join(pieces))
        told = b""
        while b"no run has begun" not in told:
            told += raw.recv(65536)


def test_neither_broken_text_nor_a_peer_that_goes_amid_its_requests_fills_the_terminal(studio, cookie, caplog):
    with opened(studio, f"Cookie: {cookie}") as (raw, _):
        raw.sendall(frame(TEXT, b"\xff\xfe"))
        assert (1007).to_bytes(2, "big") in ends(raw)
    for _ in range(5):
        with opened(studio, f"Cookie: {cookie}") as (raw, _):
            raw.sendall(frame(TEXT, b"{}") * 10_000)
            # What it was sent is unread: the connection is reset.
    with client_of(studio.url) as client:
        for _ in range(20):
            assert client.get("/api/folder").status_code == 200
    # Without handlers of their own these lines go to the terminal.
    assert caplog.messages == []
