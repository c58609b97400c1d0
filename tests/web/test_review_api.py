"""Recordings over HTTP: the whole, ticks, pictures drawn again, figures of a part, films of a part."""

import json
import math
import time
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import cv2
import numpy as np
import pytest

import mjsim
from mjsim.bench.entering import client_of
from mjsim.sim import SEEN_FROM_OUTSIDE, Playback
from mjsim.web.review.open_recordings import Opened
from mjsim.web.review.review_api import ReviewApi
from mjsim.web.review.reviewing import row_json
from mjsim.web.server.server import Server
from mjsim.web.worlds.folder import Folder
from tests.record_ticks import hand_made_ticks, record
from tests.solids import names_of

pytestmark = pytest.mark.slow
ROOM = """
mjsim: 1
name: room
walls: [{points: [[-2, -2], [2, -2], [2, 2], [-2, 2]], closed: true}]
beacons: [{name: lion, image: posters/lion.jpg, at: [1.9, 0], heading_deg: 180, center: 0.5}]
robots:
  - name: scout
    preset: pioneer3dx
    at: [0, 0]
    odometry: {noise: {distance: 0.01, turn: 0.02}}
    sensors: [{camera: front, width: 160, height: 120}, {beacons: ring, noise: {range: 0.05, bearing_deg: 1}}]
run:
  seconds: 3
  events: [{time: 2, light: 0.3}]
  drivers:
    scout:
      estimator: {use: "mjsim.algorithms.ekf_slam:EkfSlam"}
      navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[1, 0], [1, 1]]}
"""
PATIENCE = 60.0
"""No answer takes this long [s], on however loaded a machine."""
RUN = "out/room/run.mcap"


def scene(world):
    return {"items": [], "bounds": [-2.0, -2.0, 2.0, 2.0]}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with one recording, and what must not be given away."""
    root = tmp_path_factory.mktemp("folder")
    with mjsim.Simulation(mjsim.parse_world(ROOM)) as sim:
        mjsim.run(sim, record=root / RUN)
    (root / "secret.txt").write_text("secret")
    (root / "out" / "link.txt").symlink_to(root / "secret.txt")
    return root


@pytest.fixture(scope="module")
def page(folder):
    api = ReviewApi(Folder(folder), scene=scene)
    with (
        Server(api.routes, closing=[api.close]) as server,
        client_of(server.url) as client,
    ):
        yield client


@pytest.fixture(scope="module")
def recording(folder):
    return mjsim.read_recording(folder / RUN)


def get(page, what, **keys):
    answer = page.get(f"/api/recording{what}", params={"path": RUN, **keys})
    assert answer.status_code == 200, answer.text
    return answer


def picture(page, **keys):
    data = np.frombuffer(get(page, "/picture", **keys).content, np.uint8)
    return cv2.imdecode(data, cv2.IMREAD_COLOR_RGB).astype(int)


def test_the_page_receives_all_data_of_a_recording(page, recording):
    told = get(page, "").json()
    assert (told["name"], told["seconds"], told["dt"], told["seed"], told["whole"]) == ("room", 2.96, 0.04, 1, True)
    assert told["bytes"] == recording.path.stat().st_size
    assert told["cameras"] == ["scout/front"]
    assert told["scene"]["bounds"] == [-2.0, -2.0, 2.0, 2.0]
    assert [event["text"] for event in told["events"]] == ["the ambient light is set to 0.3"]
    track = told["tracks"]["scout"]
    np.testing.assert_allclose(track["truth"], recording.robots["scout"].truth, atol=1e-4)
    np.testing.assert_allclose(track["time"], recording.time, atol=1e-9)
    errors = np.linalg.norm(np.array(track["truth"])[:, :2] - np.array(track["estimate"])[:, :2], axis=1)
    np.testing.assert_allclose(track["error"], errors, atol=2e-4)
    assert set(track["timing"]) == {"estimator", "navigator", "sense", "step"}


def test_a_recorded_tick_has_people_as_they_stood_when_a_hand_was_led(tmp_path):
    at = (1.4, 0.2, 1.2)
    event = f"{{time: 0.4, reach: anna, hand: right, to: [{at[0]}, {at[1]}, {at[2]}]}}"
    text = f"""mjsim: 1
people: [{{name: anna, sex: female, at: [1, 0]}}, {{name: eve, sex: female, at: [1, 2]}}]
robots: [{{name: scout, at: [0, 0]}}]
run: {{seconds: 3, events: [{event}]}}
"""
    with mjsim.Simulation(mjsim.parse_world(text)) as sim:
        mjsim.run(sim, record=tmp_path / "run.mcap")
    opened = Opened(mjsim.read_recording(tmp_path / "run.mcap"))
    far = []
    for row in (0, 5, 20, 74):
        told = row_json(opened.recording, row, people=opened.people(row)).get("people", {})
        assert list(told) == (["anna"] if row > 9 else [])
        far += [min(np.linalg.norm(np.mean(outline, axis=0) - at[:2]) for outline in each) for each in told.values()]
    # On its way, and there: the middle of the hand is not far from its grip.
    assert far[0] > 0.1 > 0.06 > far[1]


@pytest.mark.parametrize(("asked", "row"), [(-1.0, 0), (0.0, 0), (1.0, 25), (1.039, 25), (99.0, 74)])
def test_the_tick_of_a_time_is_the_newest_then(page, recording, asked, row):
    tick = get(page, "/tick", time=asked).json()
    assert tick["number"] == row
    assert tick["time"] == pytest.approx(0.04 * row)
    robot = tick["robots"]["scout"]
    np.testing.assert_allclose(robot["estimate"], recording.robots["scout"].estimate[row], atol=1e-4)
    np.testing.assert_allclose(robot["command"], recording.robots["scout"].command[row], atol=1e-4)
    mean = recording.robots["scout"].landmarks.mean[row, 0]
    told = robot["landmarks"].get("lion", [np.nan] * 5)
    np.testing.assert_allclose(told[:2], mean, atol=1e-4)


def test_figures_between_two_times_equal_those_of_errors_summed_by_hand(page, recording):
    figures = get(page, "/statistics", **{"from": 1.0, "to": 2.0}).json()["robots"]["scout"]
    track = recording.robots["scout"]
    errors = np.linalg.norm(track.truth[25:51, :2] - track.estimate[25:51, :2], axis=1)
    assert figures["ticks"] == 26
    assert figures["position_error_m"]["rmse"] == pytest.approx(math.sqrt(np.mean(errors**2)))
    assert figures["position_error_m"]["final"] == pytest.approx(errors[-1])
    steps = np.linalg.norm(np.diff(track.truth[25:51, :2], axis=0), axis=1)
    assert figures["distance_m"] == pytest.approx(steps.sum())
    whole = get(page, "/statistics").json()
    assert whole["robots"]["scout"] == mjsim.statistics(recording)["scout"]


def test_an_onboard_picture_drawn_again_is_the_one_that_was_taken(page, recording):
    for stamp, recorded in list(recording.images("scout", "front"))[::12]:
        drawn = picture(page, time=stamp, view="scout/front")
        # Both are JPEG, of small letters and edges; a picture of another time differs by far more.
        assert np.abs(drawn - recorded).mean() < 5.0
    assert np.abs(picture(page, time=0.0, view="scout/front") - recorded).mean() > 15.0
    assert picture(page, time=1.0, view="scout/front:depth").shape == (120, 160, 3)
    assert picture(page, time=1.0, view="scout/front:segmentation").shape == (120, 160, 3)


def test_the_overview_is_that_of_the_film(page, recording):
    with Playback(
        recording.world, width=960, height=600, groups=SEEN_FROM_OUTSIDE, events=recording.events
    ) as playback:
        for row in (10, 70):
            filmed = playback.picture(recording.qpos[row], "overview", time=recording.time[row])
            drawn = picture(page, time=recording.time[row], view="overview")
            assert np.abs(drawn - filmed).mean() < 2.0
    # The light was lowered between both.
    assert picture(page, time=0.4, view="overview").mean() > 1.5 * picture(page, time=2.8, view="overview").mean()


def test_the_view_from_outside_can_be_turned(page):
    orbit = {"elevation_deg": -40, "distance": 6, "x": 0, "y": 0}
    one, other = (picture(page, time=1.0, view="outside", azimuth_deg=angle, **orbit) for angle in (30, 120))
    assert one.shape == other.shape == (600, 960, 3)
    assert np.abs(one - other).mean() > 5
    assert picture(page, time=1.0, view="chase").shape == (600, 960, 3)


def test_a_section_is_exported_as_video_and_downloaded(page, folder):
    asked = {"path": RUN, "from": 1.0, "to": 2.0, "view": "plan"}
    job = page.post("/api/recording/video", json=asked).json()["job"]
    until = time.monotonic() + PATIENCE
    while (state := page.get("/api/job", params={"id": job}).json())["path"] is None:
        assert state["error"] is None
        assert time.monotonic() < until
    assert (state["done"], state["total"]) == (26, 26)
    film = page.get("/api/file", params={"path": state["path"]})
    assert film.content == (folder / state["path"]).read_bytes()
    assert "attachment" in film.headers["content-disposition"]
    # The same again, twice at once, replaces none.
    again = [page.post("/api/recording/video", json=asked).json()["job"] for _ in range(2)]
    paths = {state["path"]}
    for job in again:
        while (state := page.get("/api/job", params={"id": job}).json())["path"] is None:
            assert state["error"] is None
            assert time.monotonic() < until
        paths.add(state["path"])
    assert len(paths) == 3


def test_a_dropped_file_is_kept_only_if_it_is_a_recording(page, folder):
    data = (folder / RUN).read_bytes()
    brought = page.post("/api/recording/upload", params={"name": "../my run.mcap"}, content=data).json()["path"]
    assert brought == "out/brought/my-run.mcap"
    assert (folder / brought).read_bytes() == data
    with ThreadPoolExecutor(4) as pool:
        put = partial(page.post, "/api/recording/upload", params={"name": "same.mcap"}, content=data)
        answers = [future.result(PATIENCE) for future in [pool.submit(put) for _ in range(4)]]
    assert len({answer.json()["path"] for answer in answers}) == 4
    refused = page.post("/api/recording/upload", params={"name": "x.mcap"}, content=b"no recording at all")
    assert refused.status_code == 400
    assert refused.json()["error"] == ("this cannot be opened: 'x.mcap' is not an MCAP file, so it is not a recording")
    assert sorted(path.name for path in (folder / "out/brought").iterdir()) == [
        "my-run.mcap",
        *("same-2.mcap", "same-3.mcap", "same-4.mcap", "same.mcap"),
    ]


@pytest.mark.parametrize(
    ("address", "keys", "status", "complaint"),
    [
        ("/api/recording", {"path": "../run.mcap"}, 403, "is outside the folder"),
        ("/api/recording", {"path": "none.mcap"}, 404, "no file 'none.mcap'"),
        ("/api/recording", {"path": "secret.txt"}, 400, "is not an MCAP file"),
        ("/api/recording/tick", {"path": RUN, "time": "nan"}, 400, "time is 'nan'; it must be a number"),
        ("/api/recording/picture", {"path": RUN, "time": 1, "view": "scout/bakc"}, 400, "no camera 'scout/bakc'"),
        ("/api/recording/picture", {"path": RUN, "time": 1, "view": "nobody/chase"}, 400, "no camera 'nobody/chase'"),
        (
            "/api/recording/picture",
            {"path": RUN, "time": 1, "view": "outside", "azimuth_deg": 0, "elevation_deg": 0, "distance": 1e308},
            *(400, "distance is 1e+308; it must be from -1000 to 1000"),
        ),
        ("/api/recording/statistics", {"path": RUN, "from": 1.01, "to": 1.02}, 400, "no tick is between"),
        ("/api/job", {"id": "none"}, 404, "no video of that name"),
        ("/api/file", {"path": "secret.txt"}, 403, "is not in 'out'"),
        ("/api/file", {"path": "out/link.txt"}, 403, "is not in 'out'"),
        ("/api/file", {"path": "out/none.mp4"}, 404, "no file"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(page, address, keys, status, complaint):
    answer = page.get(address, params=keys)
    assert answer.status_code == status, answer.text
    assert complaint in answer.json()["error"]
    assert "\n" not in answer.json()["error"]


def test_a_state_that_is_not_of_the_world_cannot_be_drawn_but_all_else_is_told(folder, page):
    record(folder / "hand.mcap", hand_made_ticks(5))
    told = page.get("/api/recording", params={"path": "hand.mcap"}).json()
    tick = page.get("/api/recording/tick", params={"path": "hand.mcap", "time": 0.0}).json()
    (name, corners), *others = tick["robots"]["scout"]["recognised"]
    assert (name, others) == ("lion", [])
    assert np.shape(corners) == (4, 2)
    assert set(told["tracks"]) == {"scout", "7.tip_top-2"}
    refused = page.get("/api/recording/picture", params={"path": "hand.mcap", "time": 0, "view": "overview"})
    assert refused.status_code == 400
    assert refused.json()["error"] == "a state of 14 numbers cannot be drawn; this world has 18"


def test_bodies_stand_in_3d_where_they_were(page, recording):
    names = names_of(get(page, "/scene").content)
    for row in (0, 40):
        data = get(page, "/poses", time=0.04 * row).content
        assert np.frombuffer(data[:8], "<f8") == pytest.approx(0.04 * row)
        bodies, contacts = np.frombuffer(data[8:16], "<u4").tolist()
        poses = dict(zip(names, np.frombuffer(data[16:], "<f4", 7 * bodies).reshape(-1, 7), strict=True))
        # It stands on its wheels and a caster, and what is away has a place of its own.
        touching = np.frombuffer(data[16 + 28 * bodies :], "<f4", 4 * contacts).reshape(-1, 4)
        assert json.loads(data[16 + 28 * bodies + 16 * contacts :]) == []
        np.testing.assert_allclose(touching[:, 2:], [[0, 1]] * len(touching), atol=1e-3)
        assert len(touching) >= 3
        x, y, heading = recording.robots["scout"].truth[row]
        robot = poses["scout/base"]
        np.testing.assert_allclose(robot[:2], [x, y], atol=1e-5)
        assert 2.0 * math.atan2(robot[5], robot[6]) == pytest.approx(heading, abs=1e-3)
        np.testing.assert_array_equal(poses["world"], [0, 0, 0, 0, 0, 0, 1])
