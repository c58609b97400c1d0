"""What the page is told of a recording made by hand: compared with the recording, without a server."""

import json
import math
import os

import httpx
import numpy as np
import pytest
from starlette.applications import Starlette

import mjsim
from mjsim.geometry import wrap_angle
from mjsim.record import raw_messages
from mjsim.web.review import review_api
from mjsim.web.review.fields import column_json, fields_json, message_json, numbers_in
from mjsim.web.review.review_api import ReviewApi
from mjsim.web.review.reviewing import default_film, events_json, recording_json, row_at, row_json
from mjsim.web.run.measured import SensorPast
from mjsim.web.worlds.folder import Folder
from tests.loops import in_a_loop
from tests.record_ticks import DT, ROBOTS, hand_made_ticks, record

COUNT = 6
RUN = "out/hand/run.mcap"


@pytest.fixture(scope="module")
def root(tmp_path_factory):
    root = tmp_path_factory.mktemp("folder")
    (root / "out" / "hand").mkdir(parents=True)
    modules = json.dumps({"scout": {"estimator": "EkfSlam"}})
    record(root / RUN, hand_made_ticks(COUNT), note="by hand", modules=modules)
    (root / "secret.txt").write_text("secret")
    (root / "out" / "link.txt").symlink_to(root / "secret.txt")
    return root


@pytest.fixture(scope="module")
def recording(root):
    return mjsim.read_recording(root / RUN)


@pytest.fixture(scope="module")
def ticks():
    return list(hand_made_ticks(COUNT))


@pytest.fixture
def ask(root):
    api = ReviewApi(Folder(root), scene=lambda world: {"items": [world.name]})

    async def sent(method, address, **more):
        transport = httpx.ASGITransport(app=Starlette(routes=api.routes))
        async with httpx.AsyncClient(transport=transport, base_url="http://page") as client:
            return await client.request(method, address, **more)

    yield lambda address, method="GET", **more: in_a_loop(lambda: sent(method, address, **more))
    api.close()


def test_a_recording_is_told_with_its_times_cameras_and_views(recording):
    told = recording_json(recording, path=RUN, scene={"items": []})
    assert told["path"] == RUN
    assert told["bytes"] == recording.path.stat().st_size
    assert (told["begin"], told["ticks"], told["seed"], told["whole"]) == (0.0, COUNT, 5, True)
    assert told["seconds"] == pytest.approx((COUNT - 1) * DT)
    assert told["dt"] == 1.0 / recording.world.run.rate_hz
    assert told["metadata"]["note"] == "by hand"
    assert told["cameras"] == ["scout/front"]
    assert told["views"] == ["frame", "plan", "chase", "overview", "scout/front"]
    assert told["has_states"]
    assert told["joints"] == {}
    assert told["name"] == "hand-made"
    assert sorted(told["tracks"]) == sorted(ROBOTS)
    track = told["tracks"]["scout"]
    np.testing.assert_allclose(track["truth"], recording.robots["scout"].truth, atol=1e-4)
    np.testing.assert_allclose(track["estimate"], recording.robots["scout"].estimate, atol=1e-4)
    np.testing.assert_allclose(track["odometry"], recording.robots["scout"].odometry, atol=1e-4)
    deviations = [np.sqrt(np.diag(P)) for P in recording.robots["scout"].covariance]
    np.testing.assert_allclose(track["sigma"], deviations, atol=1e-4)


def test_the_times_of_modules_are_in_milliseconds(recording):
    timing = recording_json(recording, path=RUN, scene={})["tracks"]["scout"]["timing"]
    assert sorted(timing) == ["estimator", "sense", "step"]
    assert timing["sense"] == [1.0] * COUNT
    assert timing["step"] == [2.0] * COUNT
    assert timing["estimator"] == [1.0, None] * (COUNT // 2)


@pytest.mark.parametrize(
    ("time", "row"), [(-1.0, 0), (0.0, 0), (DT - 1e-3, 0), (DT - 1e-9, 1), (DT, 1), (2.5 * DT, 2), (99.0, COUNT - 1)]
)
def test_a_time_shows_the_last_tick_that_is_not_after_it(recording, time, row):
    assert row_at(recording, time) == row


@pytest.mark.parametrize("row", range(COUNT))
def test_a_tick_is_told_as_it_was_written(recording, ticks, row):
    told, tick = row_json(recording, row), ticks[row]
    assert (told["kind"], told["number"], told["time"]) == ("tick", row, pytest.approx(row * DT))
    assert "people" not in told
    assert "joints" not in told
    assert "removed" not in told
    for name in ROBOTS:
        robot, order = told["robots"][name], tick.orders[name]
        truth, pose = tick.truth[name], order.estimate.pose
        P = order.estimate.covariance
        np.testing.assert_allclose(robot["truth"], truth.as_array(), atol=1e-4)
        np.testing.assert_allclose(robot["estimate"], pose.as_array(), atol=1e-4)
        np.testing.assert_allclose(robot["odometry"], order.dead_reckoning.as_array(), atol=1e-4)
        np.testing.assert_allclose(robot["covariance"], P.ravel(), atol=1e-8)
        assert robot["error"] == pytest.approx(abs(complex(truth.x - pose.x, truth.y - pose.y)), abs=1e-5)
        turned = wrap_angle(pose.heading - truth.heading)
        assert abs(robot["heading_error"]) == pytest.approx(abs(turned), abs=1e-5)
        difference = np.array([pose.x - truth.x, pose.y - truth.y, turned])
        nees = difference @ np.linalg.inv(P) @ difference
        assert robot["estimated"] == (name == "scout")
        assert robot["nees"] == (pytest.approx(nees, abs=1e-3, rel=1e-6) if name == "scout" else None)
        assert robot["sightings"] == [
            (each.name, pytest.approx(each.range, abs=1e-4), pytest.approx(each.bearing, abs=1e-5))
            for each in order.sightings
        ]
        assert [corners for _, corners in robot["recognised"]] == [
            pytest.approx(np.round(each.corners, 2)) for each in order.sightings if each.corners is not None
        ]
        expected = {"sense": 1.0, "step": 2.0, **({"estimator": 1.0} if row % 2 == 0 else {})}
        assert robot["timing"] == expected
        assert ("show" in robot) == (row == 3)
        assert "proximity" not in robot
        assert set(robot["landmarks"]) == {str(name) for name in order.estimate.landmarks}
        for mark, (mean, S) in {str(key): value for key, value in order.estimate.landmarks.items()}.items():
            if sum(str(key) == mark for key in order.estimate.landmarks) == 1:
                np.testing.assert_allclose(robot["landmarks"][mark], [*mean, S[0, 0], S[0, 1], S[1, 1]], atol=1e-5)


def test_what_sensors_read_is_told_at_their_tick(recording, ticks):
    measured = SensorPast(recording)
    try:
        assert measured.whole.wait(10.0)
        for row, tick in enumerate(ticks):
            robot = row_json(recording, row, measured=measured)["robots"]["scout"]
            near = tick.seen["scout"].proximity
            assert robot["proximity"] == [
                pytest.approx(value, abs=1e-3) if math.isfinite(value) else None for value in near
            ]
            assert robot["bump"] == list(tick.seen["scout"].bump)
            assert robot["scans"] == {}
    finally:
        measured.close()


def test_events_are_told_in_order_of_time(recording):
    told = [
        {"kind": "event", "time": 4 * DT, "robot": name, "event": "bump", "text": "touched the wall"} for name in ROBOTS
    ]
    found = events_json(recording)
    assert sorted(found, key=lambda event: event["robot"]) == sorted(told, key=lambda event: event["robot"])


@pytest.mark.parametrize(
    ("path", "view", "name"),
    [
        ("out/room/run.mcap", "frame", "out/films/room-run-frame-0.5-2s.mp4"),
        ("run.mcap", "scout/front", "out/films/run-scout-front-0.5-2s.mp4"),
    ],
)
def test_a_film_is_named_by_its_recording_its_view_and_its_section(path, view, name):
    assert default_film(path, view=view, begin=0.5, end=2.0).as_posix() == name


def test_each_number_of_a_recording_is_a_field(recording):
    fields = fields_json(recording)["fields"]
    assert fields == sorted(set(fields))
    assert all(len(field) == 2 for field in fields)
    topics = {topic for topic, _ in fields}
    assert {message.topic for message in raw_messages(recording.path, topics=topics)} == topics
    topic, field = next(each for each in fields if each[0].startswith("/scout"))
    column = column_json(recording, topic, field)
    expected = [
        (message.time / 1e9, dict(numbers_in(json.loads(message.data)))[field])
        for message in raw_messages(recording.path, topics={topic})
        if field in dict(numbers_in(json.loads(message.data)))
    ]
    assert list(zip(column["time"], column["values"], strict=True)) == [
        (pytest.approx(time, abs=1e-6), pytest.approx(value, abs=1e-9)) for time, value in expected
    ]
    assert column_json(recording, topic, "none") == {"time": [], "values": []}


def test_a_topic_has_its_type_and_the_units_that_its_schema_names(recording):
    topics = fields_json(recording)["topics"]
    estimate, command = topics["/scout/estimate"], topics["/scout/command"]
    assert (estimate["type"], estimate["units"]["heading"]) == ("foxglove.PoseInFrame", "rad")
    assert estimate["units"]["pose.position"] == "m"
    assert command["units"]["command.turn"] == "rad/s"
    assert command["count"] == len(list(raw_messages(recording.path, topics={"/scout/command"})))


def test_the_message_of_a_time_is_the_last_one_until_then(recording):
    told = [json.loads(message.data) for message in raw_messages(recording.path, topics={"/scout/command"})]
    found = message_json(recording, "/scout/command", 2.5 * DT)
    assert (found["time"], found["content"]) == (pytest.approx(2 * DT), told[2])
    assert message_json(recording, "/scout/command", -1.0) is None
    assert message_json(recording, "/tf", 0.0)["content"] is None  # Protobuf


NESTED = {"a": {"b": {"c": {"d": {"e": {"f": 1}, "n": 2}}}}}


@pytest.mark.parametrize(
    ("value", "found"),
    [
        ({"x": 1, "flag": True, "text": "1"}, {"x": 1.0, "flag": 1.0}),
        ({"time": 1, "timestamp": {"sec": 1}, "entities": [1], "shown": 2, "deletions": 3, "k": 4}, {"k": 4.0}),
        ({"list": [5, [6]]}, {"list[0]": 5.0, "list[1][0]": 6.0}),
        ({"list": [{"name": "lion", "x": 1}, {"part": "step", "x": 2}, {"name": 3}]},
         {"list[lion].x": 1.0, "list[step].x": 2.0, "list[2].name": 3.0}),
        ({"long": [1] * 65, "short": [1] * 64}, {f"short[{k}]": 1.0 for k in range(64)}),
        (NESTED, {"a.b.c.d.n": 2.0, "a.b.c.d.e.f": 1.0}),
        ({"z": NESTED}, {"z.a.b.c.d.n": 2.0}),
        (None, {}),
    ],
)  # fmt: skip
def test_numbers_are_named_by_keys_names_and_indices(value, found):
    assert dict(numbers_in(value)) == found


def test_the_page_asks_for_the_whole_a_tick_fields_and_statistics(ask, recording):
    whole = ask(f"/api/recording?path={RUN}").json()
    assert whole["scene"] == {"items": ["hand-made"]}
    assert whole["path"] == RUN
    assert ask(f"/api/recording/tick?path={RUN}&time={1.5 * DT}").json()["number"] == 1
    found = ask(f"/api/recording/fields?path={RUN}").json()
    assert found == json.loads(json.dumps(fields_json(recording)))
    topic, field = found["fields"][0]
    last = ask("/api/recording/message", params={"path": RUN, "topic": topic, "time": "1e6"}).json()
    assert last == message_json(recording, topic, 1e6)
    asked = ask(f"/api/recording/column?path={RUN}", params={"path": RUN, "topic": topic, "field": field}).json()
    assert asked == column_json(recording, topic, field)
    part = ask(f"/api/recording/statistics?path={RUN}&from={DT}&to={3 * DT}").json()
    assert part == json.loads(json.dumps(mjsim.report.statistics_file(recording.between(DT, 3 * DT))))
    assert ask(f"/api/recording/statistics?path={RUN}").json() != part


@pytest.mark.parametrize(
    ("address", "status", "word"),
    [
        ("recording?path=out/none.mcap", 404, "no file 'none.mcap'"),
        (f"recording/tick?path={RUN}&time=soon", 400, "time is 'soon'; it must be a number"),
        (f"recording/tick?path={RUN}&time=nan", 400, "must be a number"),
        (f"recording/tick?path={RUN}", 400, "time is ''"),
        (f"recording/picture?path={RUN}&time=0&distance=2000&azimuth_deg=0&elevation_deg=0", 400, "from -1000 to 1000"),
        (f"recording/picture?path={RUN}&time=0&distance=2&azimuth_deg=0&elevation_deg=91", 400, "elevation_deg is 91"),
        ("file?path=secret.txt", 403, "is not in 'out'"),
        ("file?path=out/../secret.txt", 403, ""),
        ("file?path=out/link.txt", 403, ""),
        ("file?path=out/none", 404, "no file 'out/none'"),
        ("job?id=none", 404, "no video of that name"),
    ],
)
def test_what_does_not_exist_or_is_not_the_pages_is_refused_in_one_line(ask, address, status, word):
    answer = ask(f"/api/{address}")
    assert answer.status_code == status
    assert word in answer.json()["error"]


def test_a_file_of_out_is_given_for_download(ask, root):
    answer = ask(f"/api/file?path={RUN}")
    assert answer.content == (root / RUN).read_bytes()
    assert 'filename="run.mcap"' in answer.headers["content-disposition"]


@pytest.mark.parametrize(
    ("name", "kept"),
    [("My run.mcap", "My-run.mcap"), ("..\\a\\b c?.MCAP", "b-c.mcap"), (".hidden", "hidden.mcap"), ("//", "run.mcap"),
     ("n" * 90 + ".mcap", "n" * 60 + ".mcap")],
)  # fmt: skip
def test_an_upload_is_kept_under_a_plain_name(ask, root, name, kept):
    data = (root / RUN).read_bytes()
    answer = ask("/api/recording/upload", method="POST", params={"name": name}, content=data)
    assert answer.json() == {"path": f"out/brought/{kept}"}
    assert (root / "out/brought" / kept).read_bytes() == data
    again = ask("/api/recording/upload", method="POST", params={"name": name}, content=data)
    assert again.json()["path"] != answer.json()["path"]
    assert not list((root / "out/brought").glob(".*"))


def test_an_upload_that_is_no_recording_or_too_large_leaves_nothing(ask, root, monkeypatch):
    before = sorted((root / "out/brought").glob("*"))
    answer = ask("/api/recording/upload?name=x.mcap", method="POST", content=b"nothing")
    assert answer.status_code == 400
    assert "cannot be opened: 'x.mcap' is not" in answer.json()["error"]
    monkeypatch.setattr(review_api, "MAX_UPLOAD_BYTES", 6)
    answer = ask("/api/recording/upload?name=x.mcap", method="POST", content=b"nothing")
    assert answer.status_code == 413
    assert sorted((root / "out/brought").glob("*")) == before
    assert not list((root / "out/brought").glob(".*"))


def test_recordings_are_listed_with_their_world_robots_and_length_the_newest_first(root, recording, ask):
    (root / "none.mcap").write_bytes(b"nothing")
    cut = root / "cut.mcap"
    cut.write_bytes((root / RUN).read_bytes()[:-200])
    os.utime(root / RUN, (1e9, 1e9))
    cards = {card["path"]: card for card in ask("/api/recordings").json()}
    assert list(cards)[-1] == RUN
    whole = {"world": recording.world.name, "robots": ["scout"], "seconds": pytest.approx(recording.time[-1])}
    assert cards[RUN] == {"path": RUN, "when": 1e9, "bytes": (root / RUN).stat().st_size, **whole}
    assert cards["cut.mcap"] == {**cards["cut.mcap"], **whole, "seconds": None}
    assert [cards["none.mcap"][key] for key in ("world", "robots", "seconds")] == ["", [], None]
    plan = ask(f"/api/recording/plan?path={RUN}&theme=dark")
    assert plan.headers["content-type"].startswith("image/svg+xml")
    assert b"<svg" in plan.content
    assert ask("/api/recording/plan?path=none.mcap").status_code == 400
    for name in ("none.mcap", "cut.mcap"):
        (root / name).unlink()
