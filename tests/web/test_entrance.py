"""Who is let in: nobody without a session, which takes a one-time address or the token."""

import asyncio
import os
import re
import time
from contextlib import contextmanager

import httpx
import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from mjsim.bench.entering import client_of, cookie_of, socket_of
from mjsim.errors import UsageError
from mjsim.web import LiveView
from mjsim.web.server.session_keys import LIFETIME_SECONDS, MAX_PASSES, MAX_SESSIONS, Keys
from mjsim.web.server.token_penalty import AT_ONCE, FIRST_DELAY, MAX_DELAY, Penalty, delay
from mjsim.web.studio import Studio
from mjsim.world import parse_world
from tests.loops import in_a_loop
from tests.strangers import as_stranger, ended, fork, other_user

PATIENCE = 60.0
"""No answer takes this long [s], on however loaded a machine."""
TOKEN = "a token of some length"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("entrance")
    (place / "room.yaml").write_text("mjsim: 1\n")
    return place


@pytest.fixture(scope="module")
def studio(folder):
    with Studio(folder, token=TOKEN) as page:
        yield page


@pytest.fixture
def stranger(studio):
    """A browser that was not let in."""
    with httpx.Client(base_url=studio.address, timeout=PATIENCE, trust_env=False) as browser:
        yield browser


def log_in(browser, token, **headers):
    return browser.post("/login", data={"token": token}, headers=headers)


def is_in(browser):
    return browser.get("/api/folder").status_code == 200


PLACES = (
    ("GET", "/"),
    ("GET", "/studio.js"),
    ("GET", "/studio.css"),
    ("GET", "/favicon.ico"),
    ("GET", "/api/folder"),
    ("GET", "/api/schema"),
    ("GET", "/nothing"),
    ("POST", "/api/source"),
    ("POST", "/api/trust"),
    ("POST", "/api/save"),
    ("POST", "/api/invite"),
    ("POST", "/api/upload?name=x.jpg"),
    ("HEAD", "/"),
    ("OPTIONS", "/api/open"),
    ("GET", "/login"),
)


@pytest.mark.slow
def test_access_needs_a_session_on_loopback_and_live_too(studio, stranger):
    for method, place in PLACES:
        answer = stranger.request(method, place, content=b"{}")
        assert answer.status_code == 401, place
        assert "set-cookie" not in answer.headers
    with pytest.raises(InvalidStatus) as refused:
        connect(socket_of(stranger))
    assert refused.value.response.status_code == 403
    with LiveView(parse_world("mjsim: 1")) as live:
        assert httpx.get(live.address, trust_env=False).status_code == 401
        assert httpx.get(f"{live.address}api/folder", trust_env=False).status_code == 401
        with client_of(live.url) as browser:
            assert is_in(browser)


def test_unauthenticated_users_only_see_the_login_form(studio, stranger, folder):
    told = stranger.get("/").text + stranger.get("/api/folder").text
    assert 'name="token"' in told
    for secret in (TOKEN, str(folder), folder.name, "room.yaml"):
        assert secret not in told


def test_an_address_works_once_and_then_the_cookie_does(studio, stranger):
    url = studio.url
    word = httpx.URL(url).params["token"]
    assert len(word) * 6 >= 128  # bits
    came = stranger.get(url)
    assert came.status_code == 200
    cookie = came.headers["set-cookie"]
    name = f"mjsim-session-{httpx.URL(url).port}"
    assert re.fullmatch(rf"{name}=[\w-]{{22,}}; HttpOnly; SameSite=Strict; Path=/", cookie)
    # The way on from there begins at the page itself: cookies of this kind are sent on no other.
    assert '<meta http-equiv="refresh" content="0; url=/">' in came.text
    assert came.headers["referrer-policy"] == "no-referrer"
    assert word not in came.text + cookie
    assert stranger.get("/").status_code == 200
    assert is_in(stranger)
    # The browser's own history leads there again.
    assert stranger.get(url).headers["location"] == "/"
    with connect(socket_of(stranger), additional_headers=cookie_of(stranger), open_timeout=PATIENCE):
        pass
    assert httpx.get(url, timeout=PATIENCE, trust_env=False).status_code == 401


def test_who_only_looks_at_an_address_does_not_use_it_up(studio, stranger):
    url = studio.url
    assert stranger.head(url).status_code == 401
    assert stranger.get(url, headers={"Sec-Purpose": "prefetch;prerender"}).status_code == 401
    foreign = {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "no-cors"}
    assert stranger.get(url, headers=foreign).status_code == 403
    assert stranger.get(url).status_code == 200


def test_an_address_is_too_old_after_five_minutes():
    now = 0.0
    keys = Keys(clock=lambda: now)
    first, second = keys.new_pass(), keys.new_pass()
    now = LIFETIME_SECONDS - 1.0
    assert keys.exchange(first.word, peer="a") is not None
    now = LIFETIME_SECONDS
    assert keys.exchange(second.word, peer="a") is None
    assert first.over.is_set()
    assert second.over.is_set()


def test_passes_and_sessions_are_bounded_and_the_oldest_go():
    keys = Keys()
    passes = [keys.new_pass() for _ in range(MAX_PASSES + 1)]
    assert passes[0].over.is_set()
    assert keys.exchange(passes[0].word, peer="a") is None
    first = keys.exchange(passes[1].word, peer="a")
    for _ in range(MAX_SESSIONS):
        keys.exchange(keys.new_pass().word, peer="a")
    assert not keys.know([first], peer=lambda: "a")


def test_a_browser_that_is_in_lets_in_another(studio):
    with client_of(studio.url) as first:
        told = first.post("/api/invite").json()
        assert told["minutes"] == 5
        with client_of(told["url"]) as second:
            assert is_in(second)
        assert is_in(first)
        assert first.post("/api/invite", headers={"Origin": "http://evil.example"}).status_code == 403


@pytest.mark.slow
def test_the_token_is_asked_for_and_lets_in_any_number(studio):
    for _ in range(2):
        with httpx.Client(base_url=studio.address, timeout=PATIENCE, trust_env=False) as browser:
            # It would stay in the history, and in the files of proxies.
            assert browser.get(f"/?token={TOKEN}").status_code == 401
            answer = log_in(browser, TOKEN)
            assert (answer.status_code, answer.headers["location"]) == (303, "/")
            assert is_in(browser)
    with httpx.Client(base_url=studio.address, timeout=PATIENCE, trust_env=False) as browser:
        assert log_in(browser, studio.url).status_code == 303  # a whole address, pasted
        assert is_in(browser)


def test_the_token_is_taken_from_the_page_itself_alone(studio, stranger):
    for headers in ({"Origin": "http://evil.example"}, {"Origin": "null"}, {"Sec-Fetch-Site": "cross-site"}):
        assert log_in(stranger, TOKEN, **headers).status_code == 403
    assert log_in(stranger, TOKEN, Origin=studio.address.rstrip("/")).status_code == 303


@pytest.mark.slow
def test_without_a_token_of_the_users_none_lets_in(folder):
    with (
        Studio(folder) as page,
        httpx.Client(base_url=page.address, timeout=PATIENCE, trust_env=False) as browser,
    ):
        for word in ("", "None", TOKEN):
            assert log_in(browser, word).status_code == 401


def test_no_cookie_but_a_sessions_own_lets_in(studio, stranger):
    name = f"mjsim-session-{httpx.URL(studio.address).port}"
    for cookie in (f"{name}=wrong", name, f"{name}=", f"x={TOKEN}", f"{name}={TOKEN}", "\u20ac;=;;"):
        answer = stranger.get("/api/folder", headers={"Cookie": cookie.encode("utf-8")})
        assert answer.status_code == 401
    with client_of(studio.url) as browser:
        (value,) = browser.cookies.values()
    # Pages at other ports may set cookies of any name; they cannot lock anybody out.
    for cookie in (f"{name}=wrong; {name}={value}; {name}=wrong", f"[]=; {name}={value}", f'"; {name}={value}'):
        assert stranger.get("/api/folder", headers={"Cookie": cookie}).status_code == 200


@pytest.mark.slow
def test_a_session_is_of_no_use_to_another_user(studio):
    with client_of(studio.url) as browser:
        cookie, address = cookie_of(browser), f"{studio.address}api/folder"

        def steal():
            claims = {"X-Forwarded-For": "127.0.0.1", "Forwarded": "for=127.0.0.1"}
            return [
                httpx.get(address, headers=headers, timeout=PATIENCE, trust_env=False).status_code
                for headers in (cookie, {**cookie, **claims})
            ]

        assert as_stranger(steal) == [401, 401]
        assert as_stranger(steal, other=False) == [200, 200]


@pytest.mark.slow
def test_a_closed_connection_belongs_to_no_user(studio):
    """The kernel shows connections whose program let go of them as the root user's."""
    other_user()
    with client_of(studio.url) as browser:
        cookie, before = cookie_of(browser)["Cookie"], set(os.listdir(browser.get("/api/folder").json()["folder"]))
        port = httpx.URL(studio.address).port

        def let_go():
            import socket

            body = b'{"path": "stolen.yaml", "text": "mjsim: 1"}'
            head = f"POST /api/save HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nCookie: {cookie}\r\n"
            head += f"Content-Type: application/json\r\nContent-Length: {len(body)}\r\n\r\n"
            for _ in range(50):
                with socket.create_connection(("127.0.0.1", port)) as raw:
                    raw.sendall(head.encode() + body)
            return True

        assert as_stranger(let_go)
        assert is_in(browser)
        assert set(os.listdir(browser.get("/api/folder").json()["folder"])) == before


@pytest.mark.slow
def test_wrong_tokens_are_answered_later_each_time(folder, monkeypatch):
    assert [delay(n) for n in (1, 2, 3, 4, 5, 60)] == [
        FIRST_DELAY,
        2 * FIRST_DELAY,
        4 * FIRST_DELAY,
        8 * FIRST_DELAY,
        MAX_DELAY,
        MAX_DELAY,
    ]
    with Studio(folder, token=TOKEN) as page, httpx.Client(base_url=page.address, trust_env=False) as browser:
        taken = []
        for attempt in (lambda: log_in(browser, "wrong" * 5), lambda: browser.get("/?token=wrong")):
            began = time.perf_counter()
            assert attempt().status_code == 401
            taken.append(time.perf_counter() - began)
        assert taken[0] >= FIRST_DELAY
        assert taken[1] >= 2 * FIRST_DELAY
        held_up = []
        monkeypatch.setattr(Penalty, "wait", lambda _, peer: held_up.append(peer))
        assert log_in(browser, TOKEN).status_code == 303
        assert held_up == []


@contextmanager
def guessing(address, *, other):
    """Let somebody try tokens as fast as can be, in many connections at once; begins once there was an answer."""
    reading, writing = os.pipe()

    def guess():
        async def work():
            limits = httpx.Limits(max_connections=None)
            async with httpx.AsyncClient(timeout=PATIENCE, trust_env=False, limits=limits) as client:
                while True:
                    await client.post(f"{address}login", data={"token": "wrong"})
                    os.write(writing, b".")

        async def all_of_them():
            await asyncio.gather(*(work() for _ in range(30)))

        in_a_loop(all_of_them, within=600.0)

    user = other_user() if other else None
    child = fork()
    if child == 0:
        try:
            if user is not None:
                os.setgid(user.pw_gid)
                os.setuid(user.pw_uid)
            guess()
        finally:
            os._exit(0)
    os.close(writing)
    try:
        assert os.read(reading, 1), "nobody guesses"
        yield
    finally:
        ended(child)
        os.close(reading)


@pytest.mark.slow
def test_who_guesses_does_not_lock_out_other_users(folder):
    with (
        Studio(folder, token=TOKEN) as page,
        guessing(page.address, other=True),
        httpx.Client(base_url=page.address, timeout=PATIENCE, trust_env=False) as browser,
    ):
        assert log_in(browser, TOKEN).status_code == 303
        assert is_in(browser)


@pytest.mark.slow
def test_who_guesses_as_the_same_user_does_not_keep_out_one_time_addresses(folder):
    with Studio(folder, token=TOKEN) as page, guessing(page.address, other=False), client_of(page.url) as browser:
        assert is_in(browser)


def test_of_tokens_that_are_tried_at_once_few_are_looked_at():
    async def guess():
        penalty = Penalty()
        waiting = [asyncio.create_task(penalty.wait("a")) for _ in range(AT_ONCE)]
        await asyncio.sleep(0.0)
        assert penalty.is_full("a")
        assert not penalty.is_full("b")
        for task in waiting:
            task.cancel()
        await asyncio.gather(*waiting, return_exceptions=True)
        assert not penalty.is_full("a")

    in_a_loop(guess)


def test_a_link_on_another_page_leads_in_by_a_step_of_our_own(stranger):
    visit = {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "navigate"}
    refresh = '<meta http-equiv="refresh" content="0; url=/">'
    assert refresh in stranger.get("/", headers=visit).text
    assert refresh not in stranger.get("/", headers={**visit, "Sec-Fetch-Site": "same-origin"}).text


def test_an_address_that_others_reach_asks_as_well(folder):
    with Studio(folder, host="0.0.0.0") as page:
        port = httpx.URL(page.address).port
        # The machine may be called anything; a page of another origin is refused all the same.
        for host, origin, status in (
            ("127.0.0.1", None, 401),
            ("my-server.lab", None, 401),
            ("my-server.lab", "http://evil.example", 403),
        ):
            headers = {"Host": f"{host}:{port}"} | ({"Origin": origin} if origin else {})
            answer = httpx.get(f"http://127.0.0.1:{port}/", headers=headers, timeout=PATIENCE, trust_env=False)
            assert answer.status_code == status
    with pytest.raises(UsageError, match=r"cannot serve at '203\.0\.113\.7': it is not an address of this machine"):
        Studio(folder, host="203.0.113.7")
