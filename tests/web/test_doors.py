"""Who gets past the doors of the studio, asked without a server: sessions, tokens, origins, connections."""

import asyncio
import os
from types import SimpleNamespace

import pytest

from mjsim.errors import UsageError
from mjsim.web.server import token_penalty
from mjsim.web.server.connections import (
    MAX_COOKIE,
    MAX_COOKIES,
    Connections,
    Limits,
    Visitor,
    _upgrade_headers,
)
from mjsim.web.server.entrance import Entrance
from mjsim.web.server.local import HEADERS, SameOrigin
from mjsim.web.server.peer import peer_of
from mjsim.web.server.session_keys import LIFETIME_SECONDS, MIN_TOKEN_LENGTH, Keys
from mjsim.web.server.token_penalty import AT_ONCE, MAX_PEERS, RESET_SECONDS, Penalty, delay
from tests.loops import in_a_loop

PORT = 8123
TOKEN = "t" * MIN_TOKEN_LENGTH
MINE, OTHERS = "user 1000", "user 1001"


class Clock:
    """A clock that is set by hand."""

    def __init__(self):
        self.time = 1000.0

    def __call__(self):
        return self.time


async def _page(scope, receive, send):
    await send({"type": "http.response.start", "status": 200, "headers": []})
    await send({"type": "http.response.body", "body": b"inside"})


def asked(app, path="/", *, peer=MINE, kind="http", method="GET", words="", body=b"", **headers):
    """Return the messages by which an application answers a request: the first tells how."""
    visitor = SimpleNamespace(peer=peer, let_in=lambda: peer != "too many")
    pairs = [(name.replace("_", "-").encode(), value.encode()) for name, value in headers.items()]
    scope = {"type": kind, "method": method, "path": path, "query_string": words.encode(), "headers": pairs}
    scope |= {"state": {"visitor": visitor}, "client": ("127.0.0.1", 1), "server": ("127.0.0.1", PORT)}
    said = []

    async def receive():
        return {"type": "http.request", "body": body, "more_body": False}

    async def send(message):
        said.append(message)

    in_a_loop(lambda: app(scope, receive, send))
    return said


def status(*request, **more):
    return asked(*request, **more)[0]["status"]


@pytest.fixture
def keys():
    return Keys(TOKEN, clock=Clock())


@pytest.fixture
def entrance(keys, monkeypatch):
    monkeypatch.setattr(token_penalty, "FIRST_DELAY", 0.0)
    return Entrance(_page, keys, port=PORT)


def cookie(session):
    return f"mjsim-session-{PORT}={session}"


def test_a_session_is_of_use_to_the_peer_that_began_it_alone(keys, entrance):
    session = keys.log_in(TOKEN, peer=MINE)
    assert keys.know([session], peer=lambda: MINE)
    assert not keys.know([session], peer=lambda: OTHERS)
    assert not keys.know([], peer=lambda: MINE)
    assert status(entrance, cookie=cookie(session)) == 200
    assert status(entrance, peer=OTHERS, cookie=cookie(session)) == 401
    assert status(entrance, "/api/folder", peer=OTHERS, cookie=cookie(session)) == 401
    assert status(entrance, cookie=f"other={session}") == 401
    assert status(entrance, cookie=cookie("wrong")) == 401


def test_among_cookies_that_others_set_ours_is_found(keys, entrance):
    session = keys.log_in(TOKEN, peer=MINE)
    assert status(entrance, cookie=f"a=b; {cookie('shadow')}; {cookie(session)}") == 200


def test_a_pass_is_of_use_once_and_for_its_time(keys):
    first, second = keys.new_pass(), keys.new_pass()
    assert keys.exchange(first.word, peer=MINE) is not None
    assert first.over.is_set()
    assert keys.exchange(first.word, peer=MINE) is None
    keys._clock.time += LIFETIME_SECONDS
    assert keys.exchange(second.word, peer=MINE) is None
    assert keys.exchange("a word", peer=MINE) is None


def test_the_token_lets_in_any_number_and_only_where_there_is_one(keys):
    assert keys.log_in(TOKEN, peer=MINE) != keys.log_in(TOKEN, peer=MINE)
    assert keys.log_in(TOKEN + "t", peer=MINE) is None
    assert Keys().log_in("", peer=MINE) is None
    with pytest.raises(UsageError, match=f"has {MIN_TOKEN_LENGTH - 1} characters; use at least {MIN_TOKEN_LENGTH}"):
        Keys("t" * (MIN_TOKEN_LENGTH - 1))


def test_the_entrance_gives_a_session_for_an_address_and_for_the_token(keys, entrance):
    said = asked(entrance, words=f"token={keys.new_pass().word}")
    assert said[0]["status"] == 200
    given = dict(said[0]["headers"])[b"set-cookie"].decode()
    assert given.endswith("; HttpOnly; SameSite=Strict; Path=/")
    assert status(entrance, cookie=given.partition(";")[0]) == 200
    assert status(entrance, "/login", method="POST", body=f"token={TOKEN}".encode()) == 303
    assert status(entrance, "/login", method="POST", body=b"token=wrong") == 401
    assert status(entrance, "/login", method="POST", body=b"token=" + b"t" * 5000) == 413
    assert status(entrance, "/", method="POST") == 401
    assert status(entrance, "/studio.js") == 401


def test_who_is_not_known_gets_no_connection_that_stays(entrance):
    assert dict(asked(entrance)[0]["headers"])[b"connection"] == b"close"
    assert asked(entrance, "/api/live", kind="websocket") == [{"type": "websocket.close", "code": 1008}]


def test_who_is_known_gets_an_error_where_there_are_too_many(keys, entrance):
    session = keys.log_in(TOKEN, peer="too many")
    assert status(entrance, peer="too many", cookie=cookie(session)) == 503
    said = asked(entrance, peer="too many", kind="websocket", cookie=cookie(session))
    assert said == [{"type": "websocket.close", "code": 1013}]


OWN = f"127.0.0.1:{PORT}"


@pytest.mark.parametrize(
    ("headers", "passes"),
    [
        ({"host": OWN}, True),
        ({"host": f"localhost:{PORT}"}, True),
        ({"host": "127.0.0.1"}, False),
        ({"host": f"evil.example:{PORT}"}, False),
        ({}, False),
        ({"host": OWN, "origin": f"http://{OWN}"}, True),
        ({"host": OWN, "origin": f"https://{OWN}"}, False),
        ({"host": OWN, "origin": "http://evil.example"}, False),
        ({"host": OWN, "origin": "null"}, False),
        ({"host": OWN, "sec_fetch_site": "same-origin"}, True),
        ({"host": OWN, "sec_fetch_site": "cross-site"}, False),
        ({"host": OWN, "sec_fetch_site": "same-site", "sec_fetch_mode": "no-cors"}, False),
        ({"host": OWN, "sec_fetch_site": "cross-site", "sec_fetch_mode": "navigate"}, True),
    ],
)
def test_only_the_page_itself_asks_and_links_lead_to_its_front_alone(headers, passes):
    app = SameOrigin(_page, PORT)
    assert (status(app, **headers) == 200) is passes
    if "sec_fetch_mode" in headers:
        assert status(app, "/api/folder", **headers) == 403
        assert status(app, "/", method="POST", **headers) == 403


def test_at_an_address_that_others_reach_any_name_is_ours_but_no_other_origin():
    app = SameOrigin(_page, PORT, host="0.0.0.0")
    assert status(app, host="a.name:1", origin="http://a.name:1") == 200
    assert status(app, host="a.name:1", origin="http://b.name:1") == 403


def test_each_answer_has_the_headers_that_keep_other_pages_out():
    for path, host in (("/", OWN), ("/", "evil.example")):
        told = {
            name.decode().lower(): value.decode()
            for name, value in asked(SameOrigin(_page, PORT), path, host=host)[0]["headers"]
        }
        assert {name: told.get(name.lower()) for name in HEADERS} == HEADERS
    assert asked(SameOrigin(_page, PORT), kind="websocket", host="evil.example") == [
        {"type": "websocket.close", "code": 1008}
    ]


def test_a_peer_on_this_machine_is_its_user_and_another_its_address():
    import socket

    with socket.create_server(("127.0.0.1", 0)) as server:
        with socket.create_connection(server.getsockname()):
            end, address = server.accept()
            with end:
                assert peer_of(address, server.getsockname()) == f"user {os.geteuid()}"
        assert peer_of(("127.0.0.1", 1), server.getsockname()) == "127.0.0.1"
    assert peer_of(("192.0.2.7", 5), ("192.0.2.1", 80)) == "192.0.2.7"


def test_wrong_tokens_wait_twice_as_long_each_time_up_to_a_limit(monkeypatch):
    assert [delay(count) for count in (1, 2, 3, 4, 5, 6, 2000)] == [0.25, 0.5, 1.0, 2.0, 4.0, 4.0, 4.0]
    clock, slept = Clock(), []

    async def sleep(seconds):
        slept.append(seconds)

    monkeypatch.setattr(asyncio, "sleep", sleep)
    penalty = Penalty(clock=clock)

    async def wrong():
        await penalty.wait("a")
        await penalty.wait("a")
        await penalty.wait("b")
        clock.time += RESET_SECONDS + 1.0
        await penalty.wait("a")
        await penalty.wait("a")
        penalty.forgive("a")
        await penalty.wait("a")
        for number in range(MAX_PEERS):
            await penalty.wait(f"peer {number}")
        await penalty.wait("a")

    in_a_loop(wrong)
    assert slept[:6] == [0.25, 0.5, 0.25, 0.25, 0.5, 0.25]
    assert slept[-1] == 0.25
    assert not penalty._waiting


def test_few_wrong_tokens_of_a_peer_wait_at_once():
    penalty = Penalty()
    penalty._waiting["a"] = AT_ONCE - 1
    assert not penalty.is_full("a")
    penalty._waiting["a"] += 1
    assert penalty.is_full("a")
    assert not penalty.is_full("b")


class Wire:
    """A connection that is not read."""

    def __init__(self):
        self.pending, self.aborted = 0, False

    def get_write_buffer_size(self):
        return self.pending

    def abort(self):
        self.aborted = True


def test_the_oldest_stranger_makes_room_and_who_is_known_stays():
    async def work():
        connections = Connections(Limits(strangers=2, known=1))
        wires = [Wire() for _ in range(4)]
        known = connections.arrive(wires[0])
        assert known.let_in()
        assert known.let_in(), "a second request of the same connection"
        visitors = [connections.arrive(wire) for wire in wires[1:3]]
        assert not visitors[0].let_in(), "one more than may be known"
        connections.arrive(wires[3])
        assert [wire.aborted for wire in wires] == [False, True, False, False]
        known.leave()
        assert visitors[1].let_in()
        connections.make_room()
        assert [wire.aborted for wire in wires] == [False, True, False, True]
        wires[2].pending = 1
        connections.close_all()
        assert wires[2].aborted

    in_a_loop(work)


def test_a_connection_is_stuck_when_nothing_moves_for_longer_than_is_allowed():
    async def work():
        now = Clock()
        visitor = Visitor(Connections(Limits()), Wire())
        visitor._now = now
        visitor.received = visitor.moved = now()
        now.time += 5.0
        assert not visitor.is_stuck(5.0)
        now.time += 1.0
        assert visitor.is_stuck(5.0), "a request that does not go on"
        visitor.note_data()
        assert not visitor.is_stuck(5.0)
        now.time += 6.0
        visitor.is_owed = lambda: True
        assert not visitor.is_stuck(5.0), "the server has to act"
        visitor.transport.pending = 10
        now.time += 6.0
        assert visitor.is_stuck(5.0), "an answer that is not read"
        visitor.transport.pending = 9
        assert not visitor.is_stuck(5.0), "it is read slowly"

    in_a_loop(work)


def test_a_websocket_gets_our_cookies_alone_and_a_bounded_number():
    ours = [f"mjsim-session-{number}=x".encode() for number in range(MAX_COOKIES + 1)]
    long = b"mjsim-session-1=" + b"x" * MAX_COOKIE
    headers = [
        (b"cookie", b"; ".join([b"a=b", long, *ours])),
        (b"host", b"h"),
        (b"accept", b"*"),
        (b"sec-websocket-key", b"k"),
    ]
    assert list(_upgrade_headers(headers)) == [
        *((b"cookie", each) for each in ours[:MAX_COOKIES]),
        (b"host", b"h"),
        (b"sec-websocket-key", b"k"),
    ]
