"""Requests that are deep, that grow when they are read, or that ask for odd parts: one line each, at once."""

import json
import os
import time

import pytest

from mjsim.bench.entering import client_of
from mjsim.cli import main
from mjsim.web import Studio
from tests.browser import browser

pytestmark = pytest.mark.slow  # Each starts a server.

JSON = {"Content-Type": "application/json"}
ROOM = "mjsim: 1\nrobots: [{name: scout, preset: pioneer3dx, at: [1, 1]}]\n"
DEEP = "[" * 100_000
CLOSED = DEEP + "]" * 100_000
SECONDS = 10.0
"""Of the processor's time; each takes far less [s]."""
LAUGHS = "mjsim: 1\na0: &a0 [ha, ha, ha, ha, ha, ha, ha, ha, ha, ha]\n" + "".join(
    f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 10)}]\n" for n in range(1, 10)
)
DOUBLES = "mjsim: 1\nvariables: {v0: 'ha', " + ", ".join(f"v{n}: '${{v{n - 1}}}${{v{n - 1}}}'" for n in range(1, 40))
BOMBS = {
    "a billion laughs": (LAUGHS, "the text holds more than 250000 values, with aliases expanded"),
    "an alias of itself": ("mjsim: 1\nwalls: &a [*a]\n", "alias '*a' is inside its own anchor '&a'"),
    "a text that doubles": (DOUBLES + "}\nname: ${v39}\n", "it must have at most 2000"),
    "deep brackets": (f"mjsim: 1\nwalls: {DEEP}\n", "values are nested more than 50 deep"),
    "a power": ("mjsim: 1\nlight: ${9**9**9**9}\n", "is too large"),
    "many repeats": (
        "mjsim: 1\nobstacles: [{box: [1, 1, 1], at: [0, 0], repeat: {times: 100000000, offset: [2, 0]}}]\n",
        "times",
    ),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("folder")
    (place / "room.yaml").write_text(ROOM)
    (place / "out").mkdir()
    (place / "out" / "film.mp4").write_bytes(bytes(range(256)) * 1000)
    return place


@pytest.fixture(scope="module")
def client(folder):
    with Studio(folder) as studio, client_of(studio.url) as browser:
        browser.studio = studio
        yield browser


@pytest.mark.parametrize("deep", [DEEP, CLOSED, '{"a":' * 100_000])
def test_deep_json_is_refused_in_a_line(client, deep):
    before = time.process_time()
    for address, body in (
        ("/api/parse", deep),
        ("/api/parse", f'{{"path": "room.yaml", "text": {deep}}}'),
        (
            "/api/edit",
            f'{{"path": "room.yaml", "text": "", "changes": [{{"op": "set", "path": [], "value": {deep}}}]}}',
        ),
        (
            "/api/trust",
            f'{{"path": "room.yaml", "text": "", "code": {{}}, "drivers": {{"scout": {{"push": {deep}}}}}}}',
        ),
        ("/api/draft/keep", f'{{"past": {deep}}}'),
        ("/api/recording/video", deep),
    ):
        answer = client.post(address, content=body, headers=JSON)
        assert answer.status_code == 400, (address, answer.text[:200])
        assert 0 < len(answer.json()["error"]) < 400
        assert "\n" not in answer.json()["error"]
    assert time.process_time() - before < SECONDS


@pytest.mark.parametrize("depth", [50, 150, 250])
def test_a_value_that_json_still_takes_is_refused_by_what_it_is_for(client, depth):
    deep = "[" * depth + "]" * depth
    known = f'"path": "room.yaml", "text": {json.dumps(ROOM)}'
    body = f'{{{known}, "changes": [{{"op": "set", "path": ["light"], "value": {deep}}}]}}'
    answer = client.post("/api/edit", content=body, headers=JSON)
    assert answer.status_code in (200, 400, 409), answer.text[:300]
    drivers = f'{{"scout": {{"navigator": {{"use": "mjsim.algorithms.wander:Wander", "a": {deep}}}}}}}'
    body = f'{{{known}, "code": {{}}, "drivers": {drivers}}}'
    answer = client.post("/api/trust", content=body, headers=JSON)
    assert answer.status_code in (200, 400), answer.text[:300]


def test_a_change_at_a_deep_path_and_a_template_with_a_long_name_are_refused_in_a_line(client):
    for op in ("set", "unset", "add", "remove", "rename", "single", "apart"):
        for path in (["a"] * 2000, ["robots", *[0] * 60], ["x" * 10_000]):
            asked = {"path": "room.yaml", "text": ROOM, "changes": [{"op": op, "path": path, "value": 1}]}
            answer = client.post("/api/edit", json=asked)
            assert (answer.status_code, len(answer.json()["error"]) < 200) == (400, True)
    answer = client.post("/api/new", json={"template": "x" * 300})
    assert (answer.status_code, answer.json()["error"].startswith("no template 'xxx")) == (400, True)


@pytest.mark.parametrize("deep", [DEEP, CLOSED, '{"do":' * 100_000, '"' * 100_000])
def test_deep_json_over_the_websocket_is_refused_in_a_line_and_the_page_stays(client, deep):
    with browser(client.studio.url) as seen:
        for text in (deep, f'{{"do": "start", "text": "", "drivers": {{"scout": {{"push": {deep}}}}}}}'):
            seen.socket.send(text)
            error = seen.until("refused")["error"]
            assert 0 < len(error) < 400
            assert "\n" not in error
        seen.say("pause")
        assert seen.until("refused", do="pause")["error"] == "no run has begun; start one"


@pytest.mark.parametrize(("key", "value"), [("at", [1e308, 0]), ("azimuth_deg", 1e308), ("distance", 1e308)])
def test_a_view_from_outside_that_would_overflow_is_refused_in_a_line(client, key, value):
    outside = {"azimuth_deg": 0, "elevation_deg": -30, "distance": 5, "at": [0, 0], key: value}
    with browser(client.studio.url) as seen:
        seen.say("watch", outside=outside)
        assert seen.until("refused")["error"].startswith(f"watch.outside.{key}")


@pytest.mark.slow
@pytest.mark.parametrize(("text", "said"), BOMBS.values(), ids=BOMBS)
def test_a_text_that_grows_when_it_is_read_is_refused_at_once(client, tmp_path, capsys, text, said):
    before = time.process_time()
    told = client.post("/api/parse", json={"path": "room.yaml", "text": text})
    assert told.status_code == 200
    assert any(said in problem["message"] for problem in told.json()["problems"])
    with browser(client.studio.url) as seen:
        seen.say("start", path="room.yaml", text=text)
        assert "\n" not in seen.until("refused")["error"]
    (tmp_path / "bomb.yaml").write_text(text)
    with pytest.raises(SystemExit) as ended:
        main(["check", str(tmp_path / "bomb.yaml")])
    assert ended.value.code == 2
    assert said in capsys.readouterr().err
    assert time.process_time() - before < SECONDS


@pytest.mark.parametrize("module", ["ekf_slam.inner", "none.at.all", "", "..cli", "os;x"])
def test_source_of_a_module_that_is_not_there_is_refused_in_a_line(client, module):
    asked = {"path": "room.yaml", "text": "mjsim: 1\n", "use": f"mjsim.algorithms.{module}:Any"}
    answer = client.post("/api/source", json=asked)
    assert (answer.status_code, answer.json()["error"]) == (404, f"mjsim has no module 'mjsim.algorithms.{module}'")


@pytest.mark.parametrize(
    ("range_", "status", "size"),
    [
        ("bytes=0-99", 206, 100),
        ("bytes=-100", 206, 100),
        ("bytes=255990-", 206, 10),
        ("bytes=0-99999999999999999999", 206, 256_000),
        ("bytes=256000-", 416, None),
        ("bytes=9-3", 400, None),
        ("bytes=", 400, None),
        ("bytes=a-b", 400, None),
        ("pages=1-2", 400, None),
        ("bytes=" + ",".join(f"{n}-{n + 1}" for n in range(0, 40_000, 10)), None, None),
        ("bytes=" + ",".join(["0-255999"] * 4000), None, None),
        ("bytes=0-" + "9" * 20_000, None, None),
    ],
)
def test_parts_of_a_file_that_are_asked_for_are_within_it_and_no_more_is_sent(client, folder, range_, status, size):
    whole = (folder / "out" / "film.mp4").read_bytes()
    before = time.process_time()
    answer = client.get("/api/file", params={"path": "out/film.mp4"}, headers={"Range": range_})
    assert time.process_time() - before < SECONDS
    assert answer.status_code == status or (status is None and answer.status_code in (200, 206, 400, 416))
    assert size is None or (len(answer.content) == size and answer.content in whole)
    # Many parts never add up to more than the file with their heads.
    assert len(answer.content) < 3 * len(whole)


def test_a_pipe_or_a_device_in_the_folder_of_results_is_not_downloaded(client, folder):
    os.mkfifo(folder / "out" / "pipe.mp4")
    assert client.get("/api/file", params={"path": "out/pipe.mp4"}).status_code == 400
