"""The live view: a page of this machine alone, which shows the newest tick and never holds up the run."""

import socket as sockets
import threading
import time

import httpx
import numpy as np
import pytest
from websockets.exceptions import ConnectionClosedOK, InvalidStatus

from mjsim.bench.entering import client_of, cookie_of
from mjsim.errors import UsageError
from mjsim.web import LiveView
from mjsim.web.run.history import MAX_ROWS, Past
from mjsim.world import parse_world
from tests.browser import PATIENCE, browser
from tests.record_ticks import hand_made_ticks, hand_made_world

pytestmark = pytest.mark.slow  # Each starts a server.

WORLD = hand_made_world()
TICKS = list(hand_made_ticks(40))
CAMERA = "scout/front"


@pytest.fixture
def live():
    with LiveView(WORLD) as view:
        yield view


def watch_without_reading(live):
    """Return a socket that asked for pictures and reads nothing at all."""
    port = httpx.URL(live.url).port
    with client_of(live.url) as client:
        cookie = cookie_of(client)["Cookie"]
    # The system would keep megabytes for who does not read; connections take this from the one that listens.
    live._server._server.servers[0].sockets[0].setsockopt(sockets.SOL_SOCKET, sockets.SO_SNDBUF, 4096)
    raw = sockets.socket()
    raw.settimeout(PATIENCE)
    raw.setsockopt(sockets.SOL_SOCKET, sockets.SO_RCVBUF, 4096)
    raw.connect(("127.0.0.1", port))
    raw.sendall(
        f"GET /api/run HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        f"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nCookie: {cookie}\r\n\r\n".encode()
    )
    assert b" 101 " in raw.recv(1024)
    # RFC 6455, section 5.2: a whole text message of less than 126 bytes, masked with zeros.
    watch = b'{"do": "watch", "cameras": ["scout/front"]}'
    raw.sendall(bytes([0x81, 0x80 | len(watch), 0, 0, 0, 0]) + watch)
    return raw


def test_the_page_and_what_it_needs_come_from_the_loopback_address_alone(live):
    with client_of(live.url) as client:
        page = client.get("/")
        assert page.status_code == 200
        assert "default-src 'self'" in page.headers["content-security-policy"]
        assert client.get("/studio.js").headers["content-type"].startswith("text/javascript")
        assert client.get("/studio.css").headers["content-type"].startswith("text/css")
        assert client.get("/live.py").status_code == 404
        assert client.get("/api/open").status_code == 404
        assert "//" not in page.text.replace("<!doctype html>", "")
        folder = client.get("/api/folder").json()
    assert (folder["mode"], folder["world"]) == ("live", "hand-made")
    assert live.url.startswith("http://127.0.0.1:")


def test_a_browser_sees_the_newest_tick_and_the_newest_picture(live):
    with browser(live.url) as seen:
        seen.say("watch", cameras=[CAMERA])
        for tick in TICKS:
            live.show(tick)
        # The last tick but one has a picture. Others come while ticks are waited for; each is said to be shown.
        frame, last = TICKS[-2].seen["scout"].cameras["front"], TICKS[-1]
        time = stamp = -1.0
        while time < last.time - 1e-9 or stamp < frame.stamp - 1e-9:
            if seen.take() == "picture":
                stamp = seen.pictures[-1][0]["time"]
                seen.say("shown", number=seen.pictures[-1][0]["number"])
            time = seen.news.get("tick", {"time": time})["time"]
        told, shown = seen.news["tick"]["robots"]["scout"], seen.pictures[-1]
        np.testing.assert_allclose(told["truth"], last.truth["scout"].as_array(), atol=1e-4)
        np.testing.assert_allclose(told["estimate"], last.orders["scout"].estimate.pose.as_array(), atol=1e-4)
        assert set(told["landmarks"]) == {str(name) for name in last.orders["scout"].estimate.landmarks}
    # JPEG rounds; a picture of another tick differs by far more.
    assert np.abs(shown[1].astype(int) - frame.image).mean() < 3


def test_a_slow_browser_misses_pictures_and_the_run_goes_on(live):
    with browser(live.url) as slow:
        slow.say("watch", cameras=[CAMERA])
        live.show(TICKS[0])
        first = slow.picture(CAMERA)[0]
        for tick in TICKS[1:]:
            live.show(tick)
        while slow.until("tick")["time"] < TICKS[-1].time - 1e-9:
            pass
        times = [head["time"] for head, _ in slow.pictures]
        # Two that it has not shown are on their way at most, however many there were.
        assert times[0] == first["time"] == 0.0
        assert len(times) <= 3


def test_who_asks_and_never_reads_holds_up_neither_the_run_nor_others_nor_the_end(caplog):
    taken = []
    with LiveView(WORLD) as live, watch_without_reading(live), browser(live.url) as quick:
        for k in range(0, len(TICKS), 10):
            for tick in TICKS[k : k + 10]:
                began = time.perf_counter()
                live.show(tick)
                taken.append(time.perf_counter() - began)
            while quick.until("tick")["time"] < TICKS[k + 9].time - 1e-9:
                pass
        began = time.perf_counter()
        live.close()
        closing = time.perf_counter() - began
    # A tick at 25 Hz has 40 ms; the median leaves out that other work takes the processor now and then.
    assert np.median(taken) < 0.005
    # The farewell and the server's own patience with who does not read are 2 s; who never reads would hold it for ever.
    assert closing < 30.0
    assert not caplog.records


def test_pictures_go_out_as_they_are(live):
    # JPEG is compressed already: doing it again costs half as much as drawing and saves little.
    with browser(live.url) as seen:
        assert "Sec-WebSocket-Extensions" not in seen.socket.response.headers


def test_a_browser_that_waits_gets_the_tick_when_it_comes(live):
    with browser(live.url) as seen:
        assert seen.until("run")["controllable"] is False
        live.show(TICKS[0])
        assert seen.until("tick")["time"] == 0.0
        seen.say("pause")
        assert seen.until("refused")["error"] == "this run is controlled by another program; steer it from there"
        seen.say("start", text="mjsim: 1")
        assert "only one run" in seen.until("refused", do="start")["error"]


def test_a_world_is_told_after_the_run_that_it_is_of(live):
    with browser(live.url) as seen:
        seen.until("past")
        # As it is for a moment when another run is put on: a page without a run passes a world over.
        live._api.stage.show += 1
        live._api.stage.wake()
        assert [seen.take(), seen.take()] == ["run", "scene"]


def test_at_the_end_who_watches_is_told_so_after_the_last_tick():
    with LiveView(WORLD) as live, browser(live.url) as seen:
        live.show(TICKS[0])
        seen.until("tick")
        live.show(TICKS[1])
        closing = threading.Thread(target=live.close)
        closing.start()
        with pytest.raises(ConnectionClosedOK) as ended:
            seen.until("nothing that there is")
        assert ended.value.rcvd.reason == "ended"
        assert seen.news["tick"]["time"] == pytest.approx(TICKS[1].time)
        assert seen.news["run"]["state"] == "ended"
        closing.join(PATIENCE)


def test_nothing_is_drawn_while_nobody_watches(live):
    with browser(live.url) as seen:
        for tick in TICKS:
            live.show(tick)
        while seen.until("tick")["time"] < TICKS[-1].time - 1e-9:
            pass
        assert not seen.pictures
    assert not live._api.stage._made


def test_the_past_is_bounded_and_thinned_evenly():
    past, count = Past(), 4 * MAX_ROWS + 7
    for k in range(count):
        past.take(TICKS[k % len(TICKS)], "scout")
    assert len(past._rows) < 2 * MAX_ROWS * 19
    told = past.as_json()
    assert 0.4 * MAX_ROWS <= len(told["time"]) <= MAX_ROWS
    # Every fourth tick: the times of those that repeat every forty ticks.
    every = [TICKS[k % len(TICKS)].time for k in range(0, count, 4)]
    np.testing.assert_allclose(told["time"], every[:: len(every) // len(told["time"])][: len(told["time"])], atol=1e-4)


@pytest.mark.slow
def test_who_asks_in_the_name_of_another_page_is_refused(live):
    port = httpx.URL(live.url).port
    for headers in ({"Host": f"evil.example:{port}"}, {"Host": "127.0.0.1"}, {"Origin": "http://evil.example"}):
        assert httpx.get(live.url, headers=headers, timeout=PATIENCE).status_code == 403
    with pytest.raises(InvalidStatus) as refused, browser(live.url, Origin="http://evil.example"):
        pass
    assert refused.value.response.status_code == 403
    with browser(live.url, Origin=live.address.rstrip("/")) as seen:
        live.show(TICKS[0])
        seen.until("tick")


def test_closing_frees_the_port_and_the_thread_and_showing_after_it_is_no_fault():
    before = set(threading.enumerate())
    with LiveView(WORLD) as live:
        port = httpx.URL(live.url).port
        live.show(TICKS[0])
    live.close()
    live.show(TICKS[1])
    assert set(threading.enumerate()) <= before
    with LiveView(WORLD, port=port) as again:
        assert again.address == live.address


def test_a_port_that_is_taken_is_refused_with_a_line(live):
    with pytest.raises(UsageError, match=r"cannot serve on port \d+: .*; 0 selects a free one"):
        LiveView(WORLD, port=httpx.URL(live.url).port)


def test_a_robot_that_is_not_there_is_named_before_anything_is_served():
    with pytest.raises(UsageError, match="no robot 'scut' to show in this world; did you mean 'scout'"):
        LiveView(WORLD, "scut")


def test_the_robot_that_is_named_is_shown_first():
    with LiveView(WORLD, "7.tip_top-2") as live, browser(live.url) as seen:
        assert [robot["name"] for robot in seen.until("run")["robots"]] == ["7.tip_top-2", "scout"]


def test_a_world_without_robots_can_be_shown_and_stays_empty():
    with LiveView(parse_world("mjsim: 1")) as live, browser(live.url) as seen:
        assert seen.until("run")["robots"] == []
        live.close()
        with pytest.raises(ConnectionClosedOK):
            seen.until("tick")
