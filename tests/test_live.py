"""The live view: a page of this machine alone, which shows the newest tick and never holds up the run."""

import json
import socket as sockets
import threading
import time

import cv2
import httpx
import numpy as np
import pytest
from record_ticks import hand_made_ticks, hand_made_world
from websockets.exceptions import ConnectionClosedOK, InvalidStatus
from websockets.sync.client import connect

from mjsim.errors import UsageError
from mjsim.video.frame import Frame
from mjsim.video.moment import moment_of
from mjsim.web import LiveView
from mjsim.web.easel import BACKLOG, Easel
from mjsim.world import parse_world

WORLD = hand_made_world()
TICKS = list(hand_made_ticks(40))
PATIENCE = 20.0
"""No answer takes this long [s], on however loaded a machine."""


@pytest.fixture
def live():
    with LiveView(WORLD) as view:
        yield view


def socket(live, **headers):
    return connect(live.url.replace("http:", "ws:") + "pictures", additional_headers=headers, open_timeout=PATIENCE)


def next_picture(browser):
    """Ask for a picture; return what is told with it and its pixels, RGB."""
    browser.send("next")
    told = json.loads(browser.recv(PATIENCE))
    data = np.frombuffer(browser.recv(PATIENCE), np.uint8)
    return told, cv2.imdecode(data, cv2.IMREAD_COLOR)[..., ::-1]


def watch_without_reading(live):
    """Return a socket that asked for far more pictures than there are and reads none of them."""
    port = httpx.URL(live.url).port
    # Who is answered knows that the server is up.
    httpx.get(live.url, timeout=PATIENCE)
    # The system would keep megabytes for who does not read; connections take this from the one that listens.
    live._server.servers[0].sockets[0].setsockopt(sockets.SOL_SOCKET, sockets.SO_SNDBUF, 4096)
    raw = sockets.socket()
    raw.settimeout(PATIENCE)
    raw.setsockopt(sockets.SOL_SOCKET, sockets.SO_RCVBUF, 4096)
    raw.connect(("127.0.0.1", port))
    raw.sendall(
        f"GET /pictures HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n".encode()
    )
    assert b" 101 " in raw.recv(1024)
    # RFC 6455, section 5.2: a whole text message of 4 bytes, masked with zeros.
    raw.sendall((b"\x81\x84\0\0\0\0" + b"next") * 100)
    return raw


def test_the_page_and_what_it_needs_come_from_the_loopback_address_alone(live):
    with httpx.Client(base_url=live.url, timeout=PATIENCE) as client:
        page = client.get("/")
        assert page.status_code == 200
        assert "hand-made" in page.text
        assert "default-src 'self'" in page.headers["content-security-policy"]
        assert client.get("/live.js").headers["content-type"].startswith("text/javascript")
        assert client.get("/live.css").headers["content-type"].startswith("text/css")
        assert client.get("/live.py").status_code == 404
        assert "//" not in page.text.replace("<!doctype html>", "")
    assert live.url.startswith("http://127.0.0.1:")


def test_a_browser_sees_the_newest_tick_as_the_film_shows_it(live):
    frame, moment = Frame(WORLD, "scout"), None
    with socket(live) as browser:
        for tick in TICKS:
            live.show(tick)
            moment = moment_of(tick, "scout", before=moment)
            frame.add(moment)
        told, picture = next_picture(browser)
    assert told["time"] == pytest.approx(TICKS[-1].time)
    assert picture.shape == (720, 1280, 3)
    # JPEG rounds; a picture of another tick differs by far more at the robots.
    assert np.abs(picture.astype(int) - frame.draw(moment)).mean() < 3


def test_a_slow_browser_misses_pictures_and_the_run_goes_on(live):
    with socket(live) as slow, socket(live) as quick:
        live.show(TICKS[0])
        assert next_picture(slow)[0]["time"] == 0.0
        for tick in TICKS[1:30]:
            live.show(tick)
        # At most one picture that was drawn just now for another, then the newest: none is kept for later.
        times = [next_picture(quick)[0]["time"], next_picture(slow)[0]["time"]]
        assert times[1] == pytest.approx(TICKS[29].time)
        assert times[0] in (0.0, times[1])


def test_who_asks_and_never_reads_holds_up_neither_the_run_nor_others_nor_the_end(caplog):
    taken = []
    with LiveView(WORLD) as live, watch_without_reading(live), socket(live) as quick:
        for k in range(0, len(TICKS), 10):
            for tick in TICKS[k : k + 10]:
                began = time.perf_counter()
                live.show(tick)
                taken.append(time.perf_counter() - began)
            assert next_picture(quick)[0]["time"] >= TICKS[k].time - 1e-9
        began = time.perf_counter()
        live.close()
        closing = time.perf_counter() - began
    # A tick at 25 Hz has 40 ms; the median leaves out that other work takes the processor now and then.
    assert np.median(taken) < 0.005
    # Less than the farewell and the server's own patience with who does not read (2 s).
    assert closing < 2.5
    assert not caplog.records


def test_a_message_of_any_kind_asks_for_a_picture(live, caplog):
    with socket(live) as browser:
        live.show(TICKS[0])
        browser.send(b"next")
        assert json.loads(browser.recv(PATIENCE))["time"] == 0.0
    assert not caplog.records


def test_pictures_go_out_as_they_are(live):
    # JPEG is compressed already: doing it again costs half as much as drawing and saves little.
    with socket(live) as browser:
        assert "Sec-WebSocket-Extensions" not in browser.response.headers


def test_a_browser_that_waits_gets_the_tick_when_it_comes(live):
    with socket(live) as browser:
        browser.send("next")
        live.show(TICKS[0])
        assert json.loads(browser.recv(PATIENCE))["time"] == 0.0


def test_at_the_end_who_watches_is_told_so_after_the_last_picture():
    with LiveView(WORLD) as live, socket(live) as browser:
        live.show(TICKS[0])
        next_picture(browser)
        live.show(TICKS[1])
        closing = threading.Thread(target=live.close)
        closing.start()
        assert next_picture(browser)[0]["time"] == pytest.approx(TICKS[1].time)
        browser.send("next")
        with pytest.raises(ConnectionClosedOK) as ended:
            browser.recv(PATIENCE)
        assert ended.value.rcvd.reason == "ended"
        closing.join(PATIENCE)


def test_nothing_is_drawn_while_nobody_watches():
    easel = Easel(WORLD, None)
    for tick in TICKS:
        easel.take(tick)
    assert easel.sheet is None
    assert easel.draw().number == len(TICKS)


def test_what_waits_while_nobody_watches_is_bounded():
    easel = Easel(WORLD, "scout")
    full = [easel.take(TICKS[k % len(TICKS)]) for k in range(2 * BACKLOG)]
    assert [k + 1 for k, now in enumerate(full) if now] == [BACKLOG, 2 * BACKLOG]
    assert all(moment.picture is None for moment in easel._backlog)


def test_who_asks_in_the_name_of_another_page_is_refused(live):
    port = httpx.URL(live.url).port
    for headers in ({"Host": f"evil.example:{port}"}, {"Host": "127.0.0.1"}, {"Origin": "http://evil.example"}):
        assert httpx.get(live.url, headers=headers, timeout=PATIENCE).status_code == 403
    with pytest.raises(InvalidStatus) as refused, socket(live, Origin="http://evil.example"):
        pass
    assert refused.value.response.status_code == 403
    with socket(live, Origin=live.url.rstrip("/")) as browser:
        live.show(TICKS[0])
        next_picture(browser)


def test_closing_frees_the_port_and_the_thread_and_showing_after_it_is_no_fault():
    with LiveView(WORLD) as live:
        port = httpx.URL(live.url).port
        live.show(TICKS[0])
    live.close()
    live.show(TICKS[1])
    assert not any(thread.name == "live view" for thread in threading.enumerate())
    with LiveView(WORLD, port=port) as again:
        assert again.url == live.url


def test_a_port_that_is_taken_is_refused_with_a_line(live):
    with pytest.raises(UsageError, match=r"cannot serve at port \d+: .*; 0 takes a free one"):
        LiveView(WORLD, port=httpx.URL(live.url).port)


def test_a_robot_that_is_not_there_is_named_before_anything_is_served():
    with pytest.raises(UsageError, match="no robot 'scut' to show in this world; did you mean 'scout'"):
        LiveView(WORLD, "scut")


def test_a_world_without_robots_can_be_shown_and_stays_empty():
    with LiveView(parse_world("mjsim: 1")) as live, socket(live) as browser:
        browser.send("next")
        live.close()
        with pytest.raises(ConnectionClosedOK):
            browser.recv(PATIENCE)
