"""The run over a WebSocket: real servers, real sockets; orders, news, pictures, and who is slow."""

import struct
import threading
from time import monotonic

import numpy as np
import pytest
from websockets.exceptions import ConnectionClosedOK

import mjsim
from mjsim.bench.entering import client_of
from mjsim.web.run.run_api import RunApi
from mjsim.web.server.server import Server
from mjsim.web.worlds.folder import Folder
from mjsim.web.worlds.trust import Trust
from tests.browser import browser
from tests.solids import names_of
from tests.web.rounds import ROOM, scene, start

pytestmark = pytest.mark.slow  # Each starts a server.


@pytest.fixture
def page(tmp_path):
    """The address of a page, and the folder that it is of."""
    api = RunApi(Folder(tmp_path), Trust(), scene=scene)
    with Server(api.routes, closing=[api.close]) as server:
        server.api = api
        yield server


@pytest.fixture(scope="module")
def running(tmp_path_factory):
    """A page on which a robot goes its rounds, faster than real time."""
    root = tmp_path_factory.mktemp("folder")
    api = RunApi(Folder(root), Trust(), scene=scene)
    with Server(api.routes, closing=[api.close]) as server:
        server.root = root
        with browser(server.url) as seen:
            start(seen, speed=2.0)
            seen.until("run", state="running")
            seen.until("tick")
        yield server


ARM = """
mjsim: 1
robots: [{name: r, base: fixed, at: [1, 2], arms: [{preset: puma560}]}]
run: {seconds: 1000}
"""


def test_each_target_of_a_drag_is_answered_the_drag_is_one_event_and_a_paused_run_does_not_go_on(page):
    def drag(seen, number, tool):
        seen.say("touch", event={"reach": "r", "arm": "arm", "tool": tool}, drag="next" if number else "first")
        while (kind := seen.take()) not in ("touched", "short", "refused"):
            pass
        return seen.news[kind]

    with browser(page.url) as seen:
        seen.say("start", path="arm.yaml", text=ARM, speed=1.0)
        seen.until("run", state="running")
        seen.until("tick")
        for k in range(5):
            assert drag(seen, k, [0.5, 0.1 - 0.02 * k, 0.4])["kind"] == "touched"
            for _ in range(3):  # of two targets before a tick the first would not count
                seen.until("tick")
        # Out of reach it comes as near as it can.
        short = drag(seen, 5, [0.5, 0.1, 3.0])
        assert (short["kind"], short["of"], short["part"]) == ("short", "r", "arm")
        assert 1.0 < short["metres"] < 2.5
        # The list of touches follows the drag.
        while not (touched := seen.news["run"]["touched"]) or len(touched[0].get("then", ())) < 5:
            seen.take()
        (event,) = seen.news["run"]["touched"]
        _, *edge = event["then"][-1]
        assert np.linalg.norm(np.subtract(edge, [0.5, 0.1, 3.0])) == pytest.approx(short["metres"], abs=2e-3)
        # All targets are one line in the list of events, which is told after the list of touches.
        while not any("through 6 targets" in each["text"] for each in seen.events):
            seen.take()
        events = [each for each in seen.events if each["event"] == "reach"]
        assert {each["motion"] for each in events} == {events[0]["motion"]}
        seen.say("pause")
        at = seen.until("run", state="paused")["time"]
        assert drag(seen, 0, [0.5, 0.1, 0.4])["kind"] == "touched"
        assert drag(seen, 1, [0.5, 0.1, 9.0])["kind"] == "short"
        seen.until("run")
        assert seen.news["tick"]["time"] == pytest.approx(at)


def test_a_page_without_a_run_says_so(page):
    with browser(page.url) as seen:
        assert seen.until("run")["state"] == "idle"
        for do in ("pause", "go", "tick", "restart", "stop"):
            seen.say(do)
            assert seen.until("refused", do=do)["error"] == "no run has begun; start one"


@pytest.mark.slow
def test_a_run_is_started_paused_ticked_restarted_and_stopped(page):
    with browser(page.url) as seen:
        start(seen, seed=3, speed=1.0, seconds=50.0)
        run = seen.until("run", state="running")
        assert (run["name"], run["path"], run["seed"], run["seconds"], run["dt"]) == (
            "room",
            "room.yaml",
            3,
            50.0,
            0.04,
        )
        assert run["robots"][0]["cameras"] == [{"name": "front", "width": 160, "height": 120}]
        assert run["controllable"]
        assert run["drivers"]["scout"]["navigator"] == "mjsim.algorithms.waypoints:Waypoints"
        seen.until("tick")
        assert seen.news["scene"]["bounds"] == [-2.0, -2.0, 2.0, 2.0]
        seen.say("pause")
        at = seen.until("run", state="paused")["time"]
        seen.say("tick")
        # What was on its way comes first.
        while seen.until("tick")["time"] < at + 0.04 - 1e-6:
            pass
        seen.say("speed", value=4.0)
        assert seen.until("run", speed=4.0)["state"] == "paused"
        seen.say("restart")
        assert not seen.until("past")["events"]
        assert seen.until("tick")["time"] == 0.0
        seen.say("stop")
        assert seen.until("run", state="ended")["error"] is None


@pytest.mark.slow
def test_a_tick_tells_what_the_loop_had(running):
    with browser(running.url) as seen:
        told = seen.until("tick")
    robot = told["robots"]["scout"]
    assert set(robot) >= {"truth", "estimate", "odometry", "covariance", "landmarks", "sightings", "command"}
    x, y, _ = robot["truth"]
    assert robot["error"] == pytest.approx(np.hypot(robot["estimate"][0] - x, robot["estimate"][1] - y), abs=2e-4)
    assert robot["estimate"] == robot["odometry"]
    assert len(robot["covariance"]) == 9
    assert len(robot["proximity"]) == 16
    assert set(robot["timing"]) == {"observer", "navigator", "sense", "step"}


@pytest.mark.slow
def test_a_camera_is_sent_while_it_is_watched_with_what_was_recognised_in_it(running):
    with browser(running.url) as seen:
        seen.until("tick")
        assert not seen.pictures
        seen.say("watch", cameras=["scout/front"], depth=True, segmentation=True)
        head, picture = seen.picture("scout/front")
        assert picture.shape == (120, 160, 3)
        while not head["recognised"]:
            head, _ = seen.picture("scout/front")
        name, corners = head["recognised"][0]
        assert name == "lion"
        assert np.shape(corners) == (4, 2)
        # The camera gives neither to modules; they are drawn beside the run.
        head, depth = seen.picture("scout/front:depth")
        assert depth.shape == (120, 160, 3)
        assert head["scale"][0] < head["scale"][1]
        assert seen.picture("scout/front:segmentation")[1].shape == (120, 160, 3)


def test_where_bodies_are_comes_with_each_tick_once_the_scene_was_asked_for(page):
    with browser(page.url) as seen, client_of(page.url) as client:
        start(seen, speed=1.0)
        tick = seen.until("tick")
        seen.say("watch", bodies=True)
        while seen.until("tick")["time"] < tick["time"] + 0.5:
            assert not seen.pictures
        bodies = names_of(client.get("/api/run/scene").content)
        seen.say("watch", bodies=True)
        times = [seen.picture("bodies")[0]["time"] for _ in range(10)]
        assert times == sorted(set(times))
        seen.say("pause")
        at = seen.until("run", state="paused")["time"]
        seen.say("watch", cameras=[])
        seen.say("watch", bodies=True)  # as when the view in 3-D is opened again
        while (moment := seen.picture("bodies"))[0]["time"] < at:
            pass
        while (tick := seen.news["tick"])["time"] < at:
            seen.until("tick")
        truth = tick["robots"]["scout"]["truth"]
    data = moment[1].tobytes()
    time, count, _ = struct.unpack_from("<dII", data)
    assert (time, count) == (at, len(bodies))
    places = np.frombuffer(data, "<f4", 7 * count, offset=16).reshape(count, 7)
    x, y, _, *quaternion = places[bodies.index("scout/base")]
    assert [x, y] == pytest.approx(truth[:2], abs=1e-3)
    assert 2.0 * np.arctan2(quaternion[2], quaternion[3]) == pytest.approx(truth[2], abs=1e-3)


@pytest.mark.slow
def test_the_view_from_outside_follows_its_orbit(running):
    orbit = {"azimuth_deg": 40, "elevation_deg": -40, "distance": 6, "at": [0, 0]}
    with browser(running.url) as seen:
        seen.say("watch", outside=orbit)
        head, first = seen.picture("outside")
        again, same = seen.picture("outside")
        assert again["time"] > head["time"]
        seen.say("watch", outside={**orbit, "azimuth_deg": 130})
        # Those come first that were drawn before.
        for _ in range(4):
            turned = seen.picture("outside")[1]
    # The same room from another side: most of the picture differs, not only the robot.
    assert np.abs(first.astype(int) - same).mean() < 2 < 5 < np.abs(first.astype(int) - turned).mean()


@pytest.mark.slow
def test_two_pictures_are_on_their_way_at_most_and_others_are_dropped(running):
    with browser(running.url) as slow, browser(running.url) as quick:
        slow.say("watch", cameras=["scout/front"])
        quick.say("watch", cameras=["scout/front"])
        times = [quick.picture("scout/front")[0]["time"] for _ in range(10)]
        assert times == sorted(set(times))
        # It has shown none of them, so it got the first two alone.
        while slow.news.get("tick", {"time": 0.0})["time"] < times[-1]:
            slow.take()
        assert len(slow.pictures) == 2
        slow.say("shown", number=slow.pictures[0][0]["number"])
        newest, _ = slow.picture("scout/front")
        assert newest["time"] >= times[-1]


@pytest.mark.slow
def test_ticks_are_the_newest_and_at_most_thirty_a_second(running):
    with browser(running.url) as seen:
        seen.until("tick")
        began = monotonic()
        numbers = [seen.until("tick")["number"] for _ in range(15)]
        took = monotonic() - began
    # Fifty a second are made, of which some are left out; a slow machine makes fewer.
    assert len(set(numbers)) == 15
    assert numbers[-1] - numbers[0] >= 15 or took > 14 / 30


@pytest.mark.slow
def test_who_comes_late_gets_what_was(running):
    with browser(running.url) as first:
        now = first.until("tick")["time"]
    with browser(running.url) as late:
        past = late.until("past")
        track = past["robots"]["scout"]
        assert track["time"][0] == 0.0
        assert track["time"][-1] >= now
        columns = [column for name, column in track.items() if name not in ("timing", "estimated")]
        assert {len(column) for column in columns} == {len(track["time"])}
        assert {len(column) for column in track["timing"].values()} == {len(track["time"])}
        assert late.news["run"]["name"] == "room"
        assert "scene" in late.news


@pytest.mark.slow
def test_a_robot_is_driven_by_hand_relative_to_its_limits_and_released(page):
    with browser(page.url) as seen:
        start(seen, text=ROOM.replace("at: [0, 0]", "at: [-1, -1]"), speed=1.0)
        seen.until("tick")
        seen.say("drive", robot="scout", forward=-0.5, left=0.0, turn=0.0)
        while seen.until("tick")["robots"]["scout"]["command"][0] >= 0.0:
            pass
        limit = 0.7
        assert seen.news["tick"]["robots"]["scout"]["command"] == [-0.5 * limit, 0.0, 0.0]
        seen.say("drive", robot="scout")
        while seen.until("tick")["robots"]["scout"]["command"][0] < 0.0:
            pass
        seen.say("drive", robot="scut", forward=1.0)
        assert "did you mean 'scout'" in seen.until("refused", do="drive")["error"]
        seen.say("drive", robot="scout", forward=2.0)
        assert seen.until("refused")["error"].startswith("drive.forward: input should be less than or equal to 1")


@pytest.mark.slow
def test_noise_changes_while_it_runs_and_all_browsers_are_told(page):
    key = "robots.scout.odometry.noise.turn"
    with browser(page.url) as one, browser(page.url) as other:
        start(one, speed=1.0)
        one.until("tick")
        one.say("set", key=key, value=0.3)
        for each in (one, other):
            while {noise["key"]: noise["value"] for noise in each.until("run").get("noise", [])}.get(key) != 0.3:
                pass
        one.say("set", key="robots.scout.body.mass", value=3.0)
        told = one.until("refused", do="set")["error"]
        assert told.startswith("robots.scout.body.mass cannot change during a run")
        assert "refused" not in other.news


@pytest.mark.slow
def test_modules_are_chosen_and_a_failing_one_reaches_every_browser(page):
    with browser(page.url) as one, browser(page.url) as other:
        use = {"use": "mjsim.algorithms.waypoints:Waypoints", "points": [[1, 1]], "laps": 1}
        start(one, drivers={"scout": {"navigator": use, "observer": None, "avoidance": True}})
        drivers = one.until("run", state="running")["drivers"]["scout"]
        assert drivers["observer"] is None
        assert drivers["avoidance"] is True
        start(one, drivers={"scout": {"navigator": {**use, "points": ["nowhere"]}}})
        for each in (one, other):
            error = each.until("run", state="failed")["error"]
            assert error.startswith(
                "navigator Waypoints of robot 'scout' at 0.00 s raised ValueError: could not convert"
            )


@pytest.mark.parametrize(
    ("keys", "complaint"),
    [
        ({"text": "mjsim: 1\nwals: []"}, "room.yaml:2:1: unknown key 'wals'; did you mean 'walls'?"),
        ({"path": "../room.yaml"}, "is outside the folder"),
        ({"record": "/tmp/run.mcap"}, "is outside the folder"),
        ({"record": "run.txt"}, "cannot record as 'run.txt'; name it .mcap"),
        ({"drivers": {"scut": {}}}, "no robot 'scut' to drive in this world; did you mean 'scout'"),
        ({"drivers": {"scout": {"navigator": {"use": "my.py:Mine"}}}}, "no file 'my.py'"),
        ({"speed": 0}, "start.speed: input should be greater than 0"),
        ({"sped": 0}, "start.sped: extra inputs are not permitted"),
    ],
)
def test_a_run_that_cannot_be_is_refused_in_one_line_and_the_other_goes_on(running, keys, complaint):
    with browser(running.url) as seen:
        start(seen, **keys)
        error = seen.until("refused")["error"]
        assert complaint in error
        assert "\n" not in error
        seen.until("tick")
        assert seen.news["run"]["state"] == "running"


def test_code_that_came_with_a_world_does_not_run_before_it_is_allowed(page, tmp_path):
    (tmp_path / "mine.py").write_text("raise SystemExit('this must not run')\nclass Mine: pass\n")
    text = ROOM.replace("mjsim.algorithms.waypoints:Waypoints", "mine.py:Mine")
    with browser(page.url) as seen:
        start(seen, text=text)
        refused = seen.until("refused", do="start")
    assert list(refused["needs_trust"]) == ["mine.py"]
    assert "mine.py" in refused["error"]


@pytest.mark.slow
def test_a_run_is_recorded_below_the_folder(page, tmp_path):
    with browser(page.url) as seen:
        start(seen, seconds=0.4, record="out/room/run.mcap")
        assert seen.until("run", state="ended")["recording"] == "out/room/run.mcap"
    assert len(mjsim.read_recording(tmp_path / "out/room/run.mcap").time) == 10


@pytest.mark.slow
def test_neither_a_start_nor_a_restart_replaces_a_recording(page, tmp_path):
    with browser(page.url) as seen:
        names = []
        for do in ("start", "restart", "start"):
            if do == "start":
                start(seen, seconds=0.2, record="out/room/run.mcap")
            else:
                seen.say("restart")
            seen.until("run", state="loading")
            names.append(seen.until("run", state="ended")["recording"])
    assert names == ["out/room/run.mcap", "out/room/run-2.mcap", "out/room/run-3.mcap"]
    assert [len(mjsim.read_recording(tmp_path / name).time) for name in names] == [5, 5, 5]


def test_a_file_that_is_no_recording_and_one_that_is_hidden_are_never_recorded_to(running):
    folder = running.root
    (folder / "notes.mcap").write_bytes(b"precious")
    (folder / "empty.mcap").touch()
    with browser(running.url) as seen:
        for name in ("notes.mcap", "empty.mcap", ".git/run.mcap"):
            start(seen, record=name)
            said = "exists and is not a recording; name another file" if "/" not in name else "without a dot in front"
            assert said in seen.until("refused")["error"]
    assert (folder / "notes.mcap").read_bytes() == b"precious"
    assert sorted(path.name for path in folder.iterdir()) == ["empty.mcap", "notes.mcap"]


def test_what_is_no_order_is_refused_and_nothing_breaks(running):
    with browser(running.url) as seen:
        for text in ("", "nonsense", "[]", "{}", '{"do": "fly"}', '{"do": "watch", "cameras": 3}', b"\0\1"):
            seen.socket.send(text)
            assert "\n" not in seen.until("refused")["error"]
        seen.say("shown", number=12345)
        seen.say("watch", cameras=["nobody/nothing"])
        seen.until("tick")


@pytest.mark.slow
def test_at_the_end_who_watches_gets_the_last_tick_and_is_let_go(tmp_path):
    before = threading.enumerate()
    api = RunApi(Folder(tmp_path), Trust(), scene=scene)
    server = Server(api.routes, closing=[api.close])
    with browser(server.url) as seen:
        start(seen, speed=1.0)
        seen.until("tick")
        threading.Thread(target=server.close).start()
        with pytest.raises(ConnectionClosedOK) as ended:
            seen.until("nothing that there is")
        assert ended.value.rcvd.reason == "ended"
        assert seen.news["run"]["state"] == "ended"
    server.close()
    left = set(threading.enumerate()) - set(before)
    assert not [thread.name for thread in left if thread.name.startswith("mjsim-")]
