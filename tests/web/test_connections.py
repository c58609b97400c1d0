"""Connections that say nothing, say it slowly or do not read are closed, and keep nobody out; on real sockets."""

import json
import resource
import socket
import subprocess
import sys
import threading
import time
from contextlib import ExitStack, contextmanager, suppress

import httpx
import pytest
from starlette.routing import Route

from mjsim.bench.entering import client_of, cookie_of
from mjsim.web.run.run_api import RunApi
from mjsim.web.server.answers import answer_get
from mjsim.web.server.connections import Limits
from mjsim.web.server.server import Server
from mjsim.web.server.static_page import page_routes
from mjsim.web.worlds.folder import Folder
from mjsim.web.worlds.trust import Trust
from mjsim.world import parse_world
from tests.browser import browser
from tests.children import child

PATIENCE = 60.0
"""Nothing takes this long [s], on however loaded a machine."""
SHORT = Limits(strangers=20, known=12, stranger=1.0, idle=1.5, ping=0.5)
FILES = 1024
HALF_OPEN = 1150


def scene(world):
    return {"items": [], "bounds": [-2.0, -2.0, 2.0, 2.0]}


@contextmanager
def serving(folder, limits=SHORT):
    api = RunApi(Folder(folder), Trust(), scene=scene)
    with Server([*page_routes(), *api.routes], closing=[api.close], limits=limits) as server:
        server.stage = api.stage
        yield server


@pytest.fixture
def server(tmp_path):
    with serving(tmp_path) as page:
        yield page


@pytest.fixture
def sockets():
    with ExitStack() as stack:

        def raw(server, data=b""):
            made = stack.enter_context(socket.create_connection(("127.0.0.1", server.port), PATIENCE))
            made.sendall(data)
            return made

        yield raw


def is_closed(raw):
    """Read until the other end closes; what came is thrown away. False when nothing comes for too long."""
    raw.settimeout(PATIENCE)
    try:
        while raw.recv(65536):
            pass
    except TimeoutError:
        return False
    except ConnectionError:
        pass
    return True


def head(server, cookie="", method="GET", path="/"):
    return f"{method} {path} HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nCookie: {cookie}\r\n".encode()


def cookie_for(server):
    with client_of(server.url) as client:
        return cookie_of(client)["Cookie"]


@pytest.mark.slow
def test_silent_unauthenticated_connections_are_closed(server, sockets):
    late = [
        sockets(server),
        sockets(server, b"GET / HT"),
        sockets(server, head(server)),
        sockets(server, head(server, method="POST", path="/login") + b"Content-Length: 100\r\n\r\ntok"),
    ]
    assert all(is_closed(raw) for raw in late)


@pytest.mark.slow
def test_sending_bytes_does_not_extend_an_unauthenticated_connection(server, sockets):
    raw, began = sockets(server, head(server)), time.monotonic()
    with suppress(ConnectionError):
        while time.monotonic() - began < PATIENCE:
            raw.sendall(b"X-More: 1\r\n")
            time.sleep(0.1)
        pytest.fail("it is heard still")


def test_an_unauthenticated_request_is_answered_once_and_closed(server, sockets):
    raw = sockets(server, head(server) + b"\r\n")
    assert b"401" in raw.recv(12)
    assert is_closed(raw)
    # A body is not read for somebody who may not send it.
    raw = sockets(server, head(server, method="POST", path="/api/x") + b"Content-Length: 1000000000\r\n\r\n")
    assert b"401" in raw.recv(12)
    assert is_closed(raw)


@pytest.mark.slow
def test_who_is_known_may_be_slow_but_not_stop(server, sockets):
    cookie = cookie_for(server)
    slow = sockets(server)
    for part in (head(server, cookie), b"\r\n"):
        time.sleep(SHORT.stranger / 4)
        slow.sendall(part)
    assert b"200" in slow.recv(12)
    first = head(server, cookie) + b"\r\n"
    stopped = sockets(server, first)
    assert b"200" in stopped.recv(12)
    stopped.sendall(head(server, cookie))
    assert is_closed(stopped)


@pytest.mark.slow
def test_an_answer_that_is_not_read_ends_its_connection(tmp_path, sockets):
    with serving(tmp_path) as server:
        small = server._server.servers[0].sockets[0]
        small.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
        raw = socket.socket()
        raw.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        raw.settimeout(PATIENCE)
        with raw:
            raw.connect(("127.0.0.1", server.port))
            asked = head(server, cookie_for(server), path="/studio.js") + b"\r\n"
            raw.sendall(asked)
            time.sleep(4 * SHORT.idle)
            assert is_closed(raw)
            assert not server._connections._known


@pytest.mark.slow
def test_a_websocket_that_never_reads_is_dropped(tmp_path):
    with serving(tmp_path) as server, browser(server.url) as quick:
        cookie = cookie_for(server)
        server.stage.put_on(parse_world("mjsim: 1"), None)
        with socket.create_connection(("127.0.0.1", server.port), PATIENCE) as raw:
            raw.sendall(
                head(server, cookie, path="/api/run")
                + b"Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                b"Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n"
            )
            quick.until("run")
            until = time.monotonic() + PATIENCE
            while len(server.stage.viewers) < 2:
                assert time.monotonic() < until
            # It answers no ping; who does stays.
            while len(server.stage.viewers) > 1:
                assert time.monotonic() < until
                quick.say("watch", cameras=[])
                quick.socket.ping().wait(PATIENCE)
        quick.say("pause")
        quick.until("refused")


@pytest.mark.slow
def test_the_oldest_unauthenticated_connections_are_replaced_and_sessions_stay(server, sockets):
    with client_of(server.url) as client:
        first = [sockets(server) for _ in range(SHORT.strangers)]
        client.get("/")
        more = [sockets(server) for _ in range(SHORT.strangers)]
        assert all(is_closed(raw) for raw in first)
        assert client.get("/").status_code == 200
        assert len(server._connections._strangers) <= SHORT.strangers
        assert len(more) == SHORT.strangers


def test_too_many_authenticated_connections_get_an_error(server, sockets):
    request = head(server, cookie_for(server)) + b"\r\n"
    answers = []
    for _ in range(SHORT.known + 3):
        raw = sockets(server, request)
        answers.append(raw.recv(12))
    assert answers.count(b"HTTP/1.1 503") >= 1
    assert answers[:5] == [b"HTTP/1.1 200"] * 5


SERVE = f"""
import resource, sys
hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
resource.setrlimit(resource.RLIMIT_NOFILE, ({FILES}, hard))
from mjsim.web.studio import Studio
with Studio(sys.argv[1]) as page:
    files = [open("/dev/null") for _ in range(int(sys.argv[2]))]
    print(page.url, page.url, flush=True)
    sys.stdin.readline()
"""


@contextmanager
def studio_with_few_files(folder, held):
    """Serve a studio in a process that may open `FILES` files and holds some; yield its URLs and the process."""
    command = [sys.executable, "-c", SERVE, str(folder), str(held)]
    with child(command, stdin=subprocess.PIPE) as process:
        yield process.line().split(), process


@contextmanager
def many_files():
    """Let this process have enough files for all the sockets."""
    before = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = HALF_OPEN + 500
    if before[1] != resource.RLIM_INFINITY and before[1] < wanted:
        pytest.skip(f"this machine allows {before[1]} files; the test needs {wanted}")
    resource.setrlimit(resource.RLIMIT_NOFILE, (max(before[0], wanted), before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, before)


def flood(stack, port):
    """Hold as many connections in a stack as the attack had, each with the beginning of a request."""
    for _ in range(HALF_OPEN):
        raw = stack.enter_context(socket.create_connection(("127.0.0.1", port), PATIENCE))
        raw.sendall(b"GET / HTTP/1.1\r\nHost: ")


@pytest.mark.slow
def test_a_flood_of_half_open_connections_keeps_nobody_out(tmp_path):
    """Most files are open already: there are too few for the strangers that are allowed."""
    with many_files(), ExitStack() as stack, studio_with_few_files(tmp_path, FILES - 120) as (urls, process):
        client = stack.enter_context(client_of(urls[0]))
        flood(stack, client.base_url.port)
        for _ in range(10):
            assert client.get("/api/folder", headers={"Connection": "close"}, timeout=PATIENCE).status_code == 200
        # A connection that is new, and a browser that is.
        stack.enter_context(client_of(urls[1]))
        with browser_of(client) as run:
            assert json.loads(run.recv(PATIENCE))["kind"] == "run"
        process.say("\n")
        process.ended()
        told = process.rest("stderr").splitlines()
    assert "Traceback" not in "".join(told)
    assert len(told) <= 1


@contextmanager
def browser_of(client):
    from websockets.sync.client import connect

    address = str(client.base_url.copy_with(scheme="ws").join("/api/run"))
    with connect(address, additional_headers=cookie_of(client), open_timeout=PATIENCE) as run:
        yield run


def test_what_is_no_http_fills_no_terminal(tmp_path, capfd):
    with serving(tmp_path) as server:
        for data in (b"\x16\x03\x01\x02\x00\x01", b"GET\r\n\r\n", b"GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n"):
            with socket.create_connection(("127.0.0.1", server.port), PATIENCE) as raw:
                raw.sendall(data)
                assert is_closed(raw)
        upgrade = {"Connection": "upgrade", "Upgrade": "other"}
        assert httpx.get(server.address, headers=upgrade, trust_env=False).status_code == 401
        with socket.create_connection(("127.0.0.1", server.port), PATIENCE) as raw, suppress(ConnectionError):
            while True:
                raw.sendall(b"x" * 10_000)
    assert capfd.readouterr().err == ""


@pytest.mark.slow
def test_the_end_of_a_server_waits_for_answers_that_are_still_computed():
    """A thread that draws while Python ends would crash it."""
    begun, ended = threading.Event(), threading.Event()

    def draw(_):
        begun.set()
        time.sleep(3.0)  # longer than the server waits for connections
        ended.set()

    with Server([Route("/api/slow", answer_get(draw))], without_token=True) as server:
        port = httpx.URL(server.address).port
        with socket.create_connection(("127.0.0.1", port), PATIENCE) as raw:
            raw.sendall(f"GET /api/slow HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n".encode())
            assert begun.wait(PATIENCE)
            server.close()
    assert ended.is_set()
