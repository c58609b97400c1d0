"""What the studio answers about runs, worlds and modules, without a server."""

import asyncio
import json
import math
import time

import cv2
import numpy as np
import pytest

from mjsim.web.edit.edit_api import EditApi
from mjsim.web.run.current_run import FAREWELL_SECONDS
from mjsim.web.run.run_api import RunApi
from mjsim.web.worlds.items import scene_of, world_values
from mjsim.web.worlds.offered_modules import KINDS, PREFERRED, modules_in
from mjsim.web.worlds.trust import Trust
from mjsim.world import parse_world
from tests.loops import in_a_loop
from tests.web.in_process import ROOM, Page, asked, folder_in


@pytest.fixture
def folder(tmp_path):
    return folder_in(tmp_path)


@pytest.fixture
def run(folder):
    """Runs a test's coroutine with the API of runs of a folder."""
    api = RunApi(folder, Trust(), scene=scene_of)

    def run(talk):
        async def all_of():
            try:
                async with Page(api.routes, "/api/run") as page:
                    await talk(page, api)
            finally:
                if api.stage.session is not None:
                    await asyncio.to_thread(api.stage.session.close)

        in_a_loop(all_of)

    yield run
    api.close()


def test_before_a_run_the_page_is_told_that_there_is_none(run):
    async def talk(page, _):
        assert (await page.until("run"))["state"] == "idle"
        for do, more in (("pause", {}), ("speed", {"value": 1}), ("drive", {"robot": "scout"})):
            assert await page.refused(do, **more) == "no run has begun; start one"
        assert "do" in await page.refused("dance")
        assert "no robot 'scot'" in await page.refused("start", text=ROOM, drivers={"scot": {}})
        assert "name it .mcap" in await page.refused("start", text=ROOM, record="run.txt")
        assert "without a dot" in await page.refused("start", text=ROOM, record="out/.run.mcap")
        assert "is not a recording" in await page.refused("start", text=ROOM, record="not.mcap")
        assert "(and 1 more)" in await page.refused("start", text=ROOM + "a: 1\nb: 2\n")

    (run.__closure__[0].cell_contents._folder.root / "not.mcap").write_text("no")
    run(talk)


def test_a_run_is_started_steered_and_seen(run):
    async def talk(page, api):
        page.say("start", text=ROOM, path="room.yaml", seed=3, seconds=500, speed=1.0, record="out/room/run.mcap")
        told = await page.until("run", lambda news: news["state"] == "running")
        assert (told["path"], told["name"], told["seed"], told["seconds"]) == ("room.yaml", "room", 3, 500.0)
        assert (told["speed"], told["controllable"], told["recording"]) == (1.0, True, "out/room/run.mcap")
        assert [robot["name"] for robot in told["robots"]] == ["scout"]
        first = await page.until("tick")
        assert (await page.until("tick"))["time"] > first["time"]
        page.say("speed", value=2.0)
        assert (await page.until("run", lambda news: news["speed"] == 2.0))["state"] == "running"
        robot = api.stage.session.world.robots[0]
        page.say("drive", robot="scout", forward=0.5, turn=-0.25)
        driven = await page.until("tick", lambda news: news["robots"]["scout"]["command"] != [0.0, 0.0, 0.0])
        expected = [0.5 * robot.drive.max_speed, 0.0, -0.25 * math.radians(robot.drive.max_turn_deg)]
        assert driven["robots"]["scout"]["command"] == pytest.approx(expected, abs=1e-4)
        page.say("drive", robot="scout")
        await page.until("tick", lambda news: news["robots"]["scout"]["command"] == [0.0, 0.0, 0.0])
        assert "no robot 'scut' to drive" in await page.refused("drive", robot="scut", forward=1)
        key = told["noise"][0]["key"]
        page.say("set", key=key, value=0.5)
        noise = (await page.until("run", lambda news: news["noise"][0]["value"] == 0.5))["noise"][0]
        assert noise["initial"] == told["noise"][0]["value"] != 0.5
        page.say("pause")
        await page.until("run", lambda news: news["state"] == "paused")
        before = api.stage.time()
        page.say("touch", event={"light": 0.5})
        now = await page.until("tick", lambda news: news["time"] > before)
        assert now["time"] == pytest.approx(before + told["dt"])
        page.say("watch", cameras=["scout/none"], depth=True)
        page.say("shown", number=1)
        page.say("tick")
        await page.until("tick", lambda news: news["time"] > now["time"])
        assert {"kind": "touched"} in page.told
        assert [news["event"] for news in page.told if news["kind"] == "event"] == ["noise", "light"]
        async with Page(api.routes, "/api/run") as late:
            assert (await late.until("run"))["state"] == "paused"
            assert {item["kind"] for item in (await late.until("scene"))["items"]} == {"wall", "light", "robot"}
            track = (await late.until("past"))["robots"]["scout"]
            assert track["time"][0] == 0.0
            assert track["time"][-1] == pytest.approx(api.stage.time())
        page.say("stop")
        await page.until("run", lambda news: news["state"] == "ended")
        assert (api._folder.root / "out/room/run.mcap").is_file()

    run(talk)


def test_all_that_listen_are_told_that_it_ends(run):
    async def talk(page, api):
        await page.until("run")
        closing = asyncio.create_task(asyncio.to_thread(api.close))
        while (message := await page.next())["type"] != "websocket.close":
            pass
        assert message["code"] == 1000
        page.leave()
        await closing

    run(talk)


ARM = """mjsim: 1
robots: [{name: r, base: fixed, at: [1, 2], arms: [{preset: puma560}]}]
run: {seconds: 1000}
"""


def test_a_tool_goes_as_near_as_it_can_and_the_page_is_told_how_far_it_is(run):
    def reach(tool, **more):
        return {"event": {"reach": "r", "arm": "arm", "tool": tool}, **more}

    async def talk(page, api):
        page.say("start", text=ARM, speed=1.0)
        await page.until("tick")
        page.say("touch", **reach([0.5, 0.1, 3.0]))
        short = await page.until("short")
        assert (short["of"], short["part"]) == ("r", "arm")
        assert 1.0 < short["metres"] < 2.5
        assert api.stage.session.touched == ()
        page.say("touch", **reach([0.5, 0.1, 0.4], drag="first"))
        assert await page.until("touched") == {"kind": "touched"}
        for _ in range(3):  # Of two targets before a tick the first would not count.
            await page.until("tick")
        page.say("touch", **reach([0.5, 0.1, 3.0], drag="next"))
        assert (await page.until("short"))["metres"] == short["metres"]
        (event,) = api.stage.session.touched
        assert math.dist(event.then[-1][1:], (0.5, 0.1, 3.0)) == pytest.approx(short["metres"], abs=2e-3)
        assert "no robot" in await page.refused("touch", event={"reach": "q", "arm": "arm", "tool": [1, 0, 0]})

    run(talk)


def test_a_run_without_viewers_is_closed_at_once(folder):
    api = RunApi(folder, Trust(), scene=scene_of)

    async def visit():
        async with Page(api.routes, "/api/run") as page:
            await page.until("run")

    in_a_loop(visit)
    began = time.monotonic()
    api.close()
    assert time.monotonic() - began < 0.5 * FAREWELL_SECONDS


@pytest.mark.slow
def test_a_picture_from_where_a_robot_is_moved_shows_what_stands_there(edit):
    def seen(text=LOOKING, status=200, **keys):
        asks = {"path": "room.yaml", "text": text, "robot": "scout", "camera": "front", "at": [0, 0], "width": 64}
        answer = in_a_loop(lambda: asked(edit.routes, "POST", "/api/preview", json={**asks, **keys}))
        assert answer.status_code == status, answer.text
        if status != 200:
            return answer.json()["error"]
        assert answer.headers["server-timing"].startswith("draw;dur=")
        return cv2.imdecode(np.frombuffer(answer.content, np.uint8), cv2.IMREAD_COLOR)

    def blue(picture):
        shade = picture.astype(int)
        return ((shade[..., 0] > shade[..., 1] + 40) & (shade[..., 0] > shade[..., 2] + 40)).mean()

    ahead = seen()
    assert ahead.shape == (48, 64, 3)
    assert blue(ahead) > 0.01
    assert blue(seen(heading_deg=180)) == 0.0
    assert blue(seen(at=[0.6, 0])) > 1.5 * blue(ahead)
    assert seen(width=9).shape[1] == 64
    wide = seen(width=5000, at=[0.6, 0])
    assert wide.shape[1] == 1280
    moved = LOOKING.replace("at: [0, 0], sensors", "at: [0.3, 0.3], sensors")
    np.testing.assert_array_equal(seen(moved), ahead)
    assert blue(seen(LOOKING.replace("at: [1.5, 0]", "at: [-1.5, 0]"))) == 0.0
    fixed = LOOKING.replace("{name: scout,", "{name: scout, base: fixed,")
    assert blue(seen(fixed, heading_deg=180)) == 0.0
    assert blue(seen(fixed)) > 0.01
    assert seen(status=404, camera="rear") == "no camera 'scout/rear' in this world"
    assert seen(status=404, robot="other") == "no camera 'other/front' in this world"
    coded = f'{LOOKING}run: {{drivers: {{scout: {{estimator: {{use: "own.py:Mine"}}}}}}}}\n'
    np.testing.assert_array_equal(seen(coded), ahead)  # a picture runs no estimator: nobody is asked


LOOKING = """mjsim: 1
obstacles: [{box: [0.3, 0.5, 1], at: [1.5, 0], color: "#0000ff"}]
robots: [{name: scout, at: [0, 0], sensors: [{camera: front, width: 160, height: 120}]}]
"""


@pytest.fixture
def edit(folder):
    saved = []
    api = EditApi(folder, Trust(), world="room.yaml", saved=lambda: saved.append(1))

    def ask(what, status=200, **keys):
        answer = in_a_loop(lambda: asked(api.routes, "POST" if keys else "GET", f"/api/{what}", json=keys or None))
        assert answer.status_code == status, answer.text
        return answer.json()

    ask.saved, ask.root, ask.routes = saved, folder.root, api.routes
    yield ask
    api.close()


def test_a_folder_is_listed_with_the_world_to_open_first(edit):
    told = edit("folder")
    assert (told["world"], told["mode"]) == ("room.yaml", "studio")
    assert "room.yaml" in json.dumps(told["worlds"])


def test_a_world_is_opened_edited_and_saved(edit):
    told = edit("open", path="room.yaml")
    assert (told["path"], told["text"], told["problems"], told["needs_trust"]) == ("room.yaml", ROOM, [], {})
    change = {"op": "set", "path": ["robots", 0, "at"], "value": [1, 0]}
    changed = edit("edit", path="room.yaml", text=ROOM, changes=[change])
    assert "at: [1, 0]" in changed["text"]
    stamp = edit("save", path="room.yaml", text=changed["text"], stamp=told["stamp"])["stamp"]
    assert stamp != told["stamp"]
    assert edit.saved == [1]
    assert (edit.root / "room.yaml").read_text() == changed["text"]
    refused = edit("edit", 409, path="room.yaml", text=ROOM, changes=[{**change, "path": ["robots", 7, "at"]}])
    assert refused["path"] == ["robots", 7]


@pytest.mark.parametrize("path", [".room.yaml", ".hidden/room.yaml", "a/.b.yaml"])
def test_hidden_files_are_not_written(edit, path):
    edit("save", 403, path=path, text=ROOM, stamp=None)
    assert not (edit.root / path).exists()


def test_values_of_a_world_that_belong_to_no_item_are_told_as_they_are_written():
    text = ROOM.replace("run: {seconds: 1000}", 'run: {seconds: "${500 * 2}"}')
    told = world_values(parse_world(text))
    assert told["written"] == ["mjsim", "name", "run"]
    assert told["raw"]["name"] == told["values"]["name"] == "room"
    assert told["values"]["run"]["seconds"] == 1000.0
    assert not {"walls", "lamps", "robots"} & told["values"].keys()


def test_a_new_world_has_a_name_of_its_own_and_no_stamp(edit):
    told = edit("new", path=None)
    assert told["stamp"] is None
    assert told["path"].endswith(".yaml")
    assert told["path"] != "room.yaml"
    assert told["problems"] == []


def test_items_in_a_pasted_text_are_named_by_their_lists(edit):
    assert edit("items", text="lamps: [{at: [1, 2]}]") == {"items": [{"list": "lamps", "value": {"at": [1, 2]}}]}
    assert edit("items", 409, text="nothing of ours")["error"]


OWN = ROOM.replace("run: {seconds: 1000}", 'run: {seconds: 1000, drivers: {scout: {estimator: {use: "own.py:Mine"}}}}')
SHIPPED = OWN.replace("own.py:Mine", "mjsim.algorithms.ekf_slam:EkfSlam")


def test_the_source_of_a_module_is_shown_from_the_line_of_its_class(edit):
    own = edit("source", path="room.yaml", text=OWN, use="own.py:Mine")
    assert own == {"name": "own.py", "text": (edit.root / "own.py").read_text(), "line": 4}
    shipped = edit("source", path="room.yaml", text=SHIPPED, use="mjsim.algorithms.ekf_slam:EkfSlam")
    assert shipped["text"].splitlines()[shipped["line"] - 1].startswith("class EkfSlam")
    assert edit("source", path="room.yaml", text=OWN, use="own.py:Other")["line"] == 1
    for use, word in (
        ("other.py:A", "not a source file beside"),
        ("../own.py:A", "not a source file beside"),
        (f"{edit.root}/own.py:Mine", "not a source file beside"),
        ("mjsim.algorithms.none:A", "mjsim has no module 'mjsim.algorithms.none'"),
        ("mjsim.algorithms.a.b:A", "mjsim has no module"),
    ):
        assert word in edit("source", 404, path="room.yaml", text=OWN, use=use)["error"]


def test_code_is_asked_for_until_it_is_allowed_as_it_was_shown(edit):
    asks = edit("parse", path="room.yaml", text=OWN)["needs_trust"]
    assert list(asks) == ["own.py"]
    edit("trust", 409, path="room.yaml", text=OWN, code={"own.py": "0" * 64})
    assert edit("trust", path="room.yaml", text=OWN, code=asks) == {"needs_trust": {}}
    assert edit("parse", path="room.yaml", text=OWN)["needs_trust"] == {}


@pytest.mark.slow
def test_modules_are_offered_by_role_the_preferred_first_with_what_they_need_and_their_options(edit):
    told = edit("modules?path=room.yaml")
    assert set(told) == {*KINDS.values(), "sensors", "faults", "programs"}
    assert [offer["use"].rpartition(":")[2] for offer in told["estimators"][:2]] == ["EkfSlam", "LidarSlam"]
    assert [offer["needs"] for offer in told["estimators"][:2]] == [["sightings"], ["scans"]]
    assert {offer["use"] for role in KINDS.values() for offer in told[role]} >= set(PREFERRED)
    assert told["sensors"]["lidar"] == "scans"
    (waypoints,) = (offer for offer in told["navigators"] if offer["use"].endswith(":Waypoints"))
    assert waypoints["needs"] == []
    (explore,) = (offer for offer in told["navigators"] if offer["use"].endswith(":Explore"))
    assert explore["needs"] == ["scans"]  # it reads more, but has a key `lidar`
    assert waypoints["options"]["required"] == ["points"]
    parts = {offer["use"].rpartition(":")[2]: offer["parts"] for role in KINDS.values() for offer in told[role]}
    assert [parts[name] for name in ("Crab", "PickUp", "ToolPath", "Lqr")] == [
        ["max_left"],
        ["arms"],
        ["arms"],
        ["balancing"],
    ]


def test_where_all_files_are_executable_only_those_that_start_as_programs_are_offered(folder, monkeypatch):
    monkeypatch.setattr("mjsim.web.worlds.offered_modules.shipped_modules", tuple)
    heads = {
        "slam": b"\x7fELF",
        "slam.py": b"#!/usr/bin/env python3\n",
        "a.png": b"\x89PNG",
        "b.stl": b"solid b\n",
        "c.py": b"",
    }
    for name, head in heads.items():
        (folder.root / name).write_bytes(head)
        (folder.root / name).chmod(0o755)
    (folder.root / "asleep").write_bytes(b"#!/bin/sh\n")
    assert modules_in(folder)["programs"] == ["exec:./slam", "exec:./slam.py"]


@pytest.mark.parametrize(
    ("what", "status", "word"),
    [
        ("portrait?kind=tree&name=x", 400, "no pictures of kind 'tree'; there are model, robot, arm"),
        ("picture?path=x.png&size=big", 400, "size is big"),
        ("picture?path=x.png&size=1234567", 400, "size is 1234567"),
    ],
)
def test_what_is_no_picture_is_refused(edit, what, status, word):
    assert word in edit(what, status)["error"]


def test_a_text_that_is_wrong_names_its_line(edit):
    wrong = ROOM.replace("at: [0, 0], odometry", "at: 5, odometry") + "more: 1\n"
    error = edit("source", 409, path="room.yaml", text=wrong, use="a.py:A")["error"]
    assert error.startswith("line ")
    assert error.endswith("(and 1 more)")
