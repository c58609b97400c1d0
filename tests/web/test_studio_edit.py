"""Editing over HTTP: worlds are opened, read with all their mistakes, changed, seen, and saved without losing work."""

import json
import math
import os

import numpy as np
import pytest
from shapely import Point, Polygon, unary_union

import mjsim
from mjsim.bench.entering import client_of
from mjsim.web import Studio
from mjsim.web.worlds.items import scene_of
from mjsim.web.worlds.offered_modules import KINDS
from mjsim.world import wall_polygons

PATIENCE = 60.0
"""No answer takes this long [s], on however loaded a machine."""
ROOM = """\
mjsim: 1
# a room
walls:
  - points: [[0, 0], [6, 0], [6, 4], [0, 4]]   # the outer one
    closed: true
    openings:
      - {segment: 0, at: 1.0, width: 1.0, door: {hinge: left, angle_deg: 90}}
      - {segment: 2, at: 3.0, width: 1.2, sill: 0.9, head: 2.0}
  - {points: [[3, "${1 + 1}"], [3, 3]], repeat: {times: 2, offset: [1, 0]}}
obstacles:
  - {box: [1, 0.5, 1], at: [2, 2], heading_deg: 90}
  - {name: cart, box: [0.4, 0.4, 0.4], at: [5, 1], path: {points: [[5, 3]]}}
beacons:
  - {name: lion, image: posters/lion.jpg, at: [5.94, 2], heading_deg: 180}
  - {name: tag, marker: {id: 3}, at: [0.21, 0], on: cart}
robots:
  - {name: scout, preset: pioneer3dx, at: [1, 2], sensors: [{camera: front, at: [0.1, 0, 1], width: 160, height: 120}]}
"""
MODULE = '''
class Base:
    def start(self, robot, map, rng):
        pass


class Wiggle(Base):
    """Goes to and fro.

    More about it.
    """

    def __init__(self, points, *, speed: float = 0.5, sides=("left", "right"), far=2 * 3):
        """Set it up.

        Args:
            points: Where to go,
                each [x, y].
            speed: How fast [m/s].
        """

    def command(self, seen, belief):
        pass
'''


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("studio")
    (place / "room.yaml").write_text(ROOM)
    (place / "wiggle.py").write_text(f"raise RuntimeError('it was run')\n{MODULE}")
    (place / "notes.yaml").write_text("shopping: [bread]\n")
    (place / "deep").mkdir()
    (place / "deep" / "hall.yaml").write_text("mjsim: 1\n")
    return place


@pytest.fixture(scope="module")
def client(folder):
    with (
        Studio(folder, world="room.yaml") as page,
        client_of(page.url) as browser,
    ):
        yield browser


def told(client, address, *, status=200, **keys):
    answer = client.post(f"/api/{address}", json=keys)
    assert answer.status_code == status, answer.text
    return answer.json()


def parse(client, text):
    return told(client, "parse", path="room.yaml", text=text)


def item(parsed, *path):
    return next(item for item in parsed["items"] if item["path"] == list(path))


HOSTILE = ("{x}", "{{name}}", "%s", "<img src=x onerror=alert(1)>", "line\nbreak", "\u202eright to left", "x" * 10_000)


@pytest.mark.parametrize("value", HOSTILE, ids=lambda value: ascii(value)[:20])
def test_what_a_hostile_world_holds_is_in_values_and_never_in_a_template(client, value):
    def sentences(value):
        robot = f"{{name: r, preset: {json.dumps(value)}, at: [1, 1]}}"
        wall = f"{{points: [[0, 0], [1, 1]], height: {json.dumps(value)}}}"
        parsed = parse(client, f"mjsim: 1\nwalls: [{wall}]\nrobots: [{robot}]\n")
        messages = [problem["message"] for problem in parsed["problems"]]
        assert len(messages) == 2
        assert all(message.isprintable() and len(message) < 410 for message in messages)
        return parsed["sentences"]

    found = sentences(value)
    assert all(template.format_map(values) == english for english, (template, values) in found.items())
    assert {template for template, _ in found.values()} <= {template for template, _ in sentences("odd").values()}


def test_the_folder_tells_what_there_is(client, folder):
    found = client.get("/api/folder").json()
    assert found["folder"] == str(folder)
    assert found["worlds"] == ["deep/hall.yaml", "room.yaml"]
    assert (found["world"], found["mode"]) == ("room.yaml", "studio")
    shipped = found["shipped"]
    assert {"gallery", "classic/slam"} <= set(shipped["worlds"])
    assert {"posters/lion.jpg", "floors/oak.jpg"} <= set(shipped["pictures"])
    assert {"name": "pioneer3dx", "about": "Pioneer 3-DX"} in shipped["presets"]
    assert "office" in shipped["templates"]


@pytest.mark.slow
def test_the_schema_tells_units_and_meanings(client):
    answer = client.get("/api/schema", headers={"Accept-Encoding": "gzip"})
    assert answer.headers["content-encoding"] == "gzip"
    assert client.get("/api/schema", headers={"Accept-Encoding": "identity"}).content == answer.content
    schema = answer.json()
    wall, camera = schema["$defs"]["Wall"]["properties"], schema["$defs"]["Camera"]["properties"]
    assert (wall["height"]["unit"], camera["fov_deg"]["unit"], camera["rate_hz"]["unit"]) == ("m", "deg", "Hz")
    assert camera["width"]["unit"] == "px"
    assert "unit" not in wall["name"]
    assert wall["points"]["description"].startswith("Corners of the centreline")


@pytest.mark.slow
def test_modules_are_found_with_their_keys_and_none_is_run(client):
    found = client.get("/api/modules").json()
    by_use = {module["use"]: module for role in KINDS.values() for module in found[role]}
    (wiggle,) = [module for module in found["navigators"] if module["use"] == "wiggle.py:Wiggle"]
    assert wiggle["about"] == "Goes to and fro."
    options = wiggle["options"]
    assert options["required"] == ["points"]
    assert options["properties"]["points"] == {"description": "Where to go, each [x, y]."}
    assert options["properties"]["speed"] == {"description": "How fast [m/s].", "default": 0.5, "type": "number"}
    assert options["properties"]["sides"] == {"description": "", "default": ["left", "right"]}
    assert "wiggle.py:Base" not in by_use
    assert by_use["mjsim.algorithms.waypoints:Waypoints"] in found["navigators"]
    assert by_use["mjsim.algorithms.ekf_slam:EkfSlam"] in found["estimators"]
    assert by_use["mjsim.algorithms.beacon_vision:BeaconVision"] in found["observers"]
    assert "mjsim.algorithms.cooperative_slam:ReportingWaypoints" in by_use


def test_a_world_is_opened_with_its_items_where_they_are(client):
    opened = told(client, "open", path="room.yaml")
    assert opened["text"] == ROOM
    assert (opened["problems"], opened["needs_trust"], opened["name"]) == ([], {}, "world")
    box = item(opened, "obstacles", 0)
    assert (box["at"], box["heading_deg"], box["type"], box["line"]) == ([2, 2], 90, "BoxObstacle", 11)
    assert (box["label"], box["name"], box["kind"]) == ("obstacle 1", None, "obstacle")
    assert Polygon(box["polygons"][0]).equals(Polygon([(1.75, 1.5), (2.25, 1.5), (2.25, 2.5), (1.75, 2.5)]))
    assert box["written"] == ["box", "at", "heading_deg"]
    assert (box["values"]["color"], box["values"]["movable"]) == ("#8a6f4d", False)
    assert box["raw"] == {"box": [1, 0.5, 1], "at": [2, 2], "heading_deg": 90}
    # A beacon on a thing is told where it hangs.
    assert item(opened, "beacons", 1)["at"] == [5.21, 1.0]
    assert [item(opened, "beacons", k)["kind"] for k in (0, 1)] == ["beacon", "marker"]
    robot = item(opened, "robots", 0)
    assert Polygon(robot["polygons"][0]).centroid.distance(Point(robot["at"])) < 0.1
    assert robot["values"]["body"]["mass"] == 9.0
    assert "body" not in robot["written"]
    assert opened["world"]["written"] == ["mjsim"]
    assert opened["world"]["values"]["floor"]["friction"] == 1.0
    assert opened["run"]["seconds"] == 60.0


def test_a_fixed_arm_is_drawn_on_the_plan_as_it_stands_at_its_start():
    arms = "[{preset: puma560, start_deg: [0, 45, 0, 0, 30, 0]}]"
    robots = f"robots: [{{name: r, base: fixed, at: [2, 2], heading_deg: 90, arms: {arms}}}]"
    world = mjsim.parse_world(f"mjsim: 1\n{robots}\n")
    (item,) = (each for each in scene_of(world)["items"] if each["kind"] == "robot")
    _, *links = (Polygon(points) for points in item["polygons"])
    arm = world.robots[0].arms[0]
    tool = arm.arm.posture(np.array(arm.start())).tool[:2, 3]
    # The robot is turned by a quarter to the left.
    place = Point(2 - tool[1], 2 + tool[0])
    assert min(link.distance(place) for link in links) < 0.1
    assert unary_union(links).area > 0.05


def test_walls_are_drawn_as_they_are_with_gaps_and_leaves(client):
    opened = told(client, "open", path="room.yaml")
    world = mjsim.parse_world(ROOM)
    drawn = unary_union([Polygon(p) for i in opened["items"] if i["kind"] == "wall" for p in i["polygons"]])
    solid = unary_union([Polygon(p) for p in wall_polygons(world)])
    # Coordinates are told to a tenth of a millimetre.
    assert drawn.symmetric_difference(solid).area < 1e-3
    door, window = (item(opened, "walls", 0, "openings", k) for k in (0, 1))
    assert door["at"] == [1.5, 0.0]
    assert Polygon(door["polygons"][0]).intersection(drawn).area < 1e-3
    # Its leaf stands open at a right angle, inwards.
    assert Polygon(door["polygons"][1]).bounds == pytest.approx((0.98, 0.0, 1.02, 1.0))
    assert (window["heading_deg"], window["values"]["sill"]) == (180.0, 0.9)
    assert opened["bounds"] == [-0.05, -0.05, 6.05, 4.05]


@pytest.mark.slow
def test_what_cannot_be_changed_here_says_so(client):
    opened = told(client, "open", path="room.yaml")
    for index in (1, 2):
        assert item(opened, "walls", index)["fixed"] == ("one repetition of the item in line 9; change it in the text")
    answer = told(
        client,
        "edit",
        status=409,
        path="room.yaml",
        text=ROOM,
        changes=[{"op": "set", "path": ["walls", 1, "height"], "value": 1}],
    )
    assert answer["error"].startswith("walls[1] is one repetition of the item in line 9")
    assert answer["path"] == ["walls", 1]
    own = parse(client, ROOM.replace(", repeat: {times: 2, offset: [1, 0]}", ""))
    assert (item(own, "walls", 1)["fixed"], item(own, "walls", 1)["computed"]) == (None, ["points"])
    assert item(own, "walls", 1)["raw"]["points"] == [[3, "${1 + 1}"], [3, 3]]


def test_a_change_gives_the_new_text_and_what_it_says(client):
    changes = [
        {"op": "set", "path": ["obstacles", 0, "at"], "value": [2.5, 2]},
        {"op": "add", "path": ["obstacles"], "value": {"sphere": 0.3, "at": [4, 1]}},
    ]
    new = told(client, "edit", path="room.yaml", text=ROOM, changes=changes)
    assert new["text"] == ROOM.replace("at: [2, 2]", "at: [2.5, 2]").replace(
        "points: [[5, 3]]}}\n", "points: [[5, 3]]}}\n  - {sphere: 0.3, at: [4, 1]}\n"
    )
    assert item(new, "obstacles", 0)["at"] == [2.5, 2]
    assert item(new, "obstacles", 2)["type"] == "SphereObstacle"
    # Undo gives the page the old text back, which says what it said.
    assert parse(client, ROOM)["items"] == told(client, "open", path="room.yaml")["items"]


def test_of_a_text_that_is_wrong_in_part_the_rest_is_seen(client):
    wrong = ROOM.replace("box: [1, 0.5, 1]", "box: [1, -0.5, 1]").replace("name: lion", "nme: lion")
    found = parse(client, wrong)
    messages = {(problem["line"], problem["kind"], problem["message"]) for problem in found["problems"]}
    assert (11, "error", "box[1] is -0.5 m; it must be above 0") in messages
    assert any("unknown key 'nme'; did you mean 'name'?" in message for _, _, message in messages)
    assert found["problems"][0]["path"] == ["obstacles", 0, "box", 1]
    paths = [found["path"] for found in found["items"]]
    # The others keep their places in the text.
    assert ["obstacles", 0] not in paths
    assert ["obstacles", 1] in paths
    assert ["beacons", 0] not in paths
    assert ["beacons", 1] in paths
    assert item(found, "obstacles", 1)["name"] == "cart"
    no_robot = parse(client, ROOM + "run: {drivers: {rover: {}}}\n")
    assert len(no_robot["items"]) == 10
    carried = "".join(f"  - {{name: b{k}, at: [0.3, 0], on: scout}}\n" for k in range(6))
    without = parse(
        client, ROOM.replace("beacons:\n", f"beacons:\n{carried}").replace("at: [1, 2], sens", "at: [1], sens")
    )
    assert [found["path"] for found in without["items"]][-2:] == [["beacons", 6], ["beacons", 7]]
    broken = parse(client, ROOM + "beacons: [")
    assert broken["items"] is None
    assert broken["problems"][0]["kind"] == "error"
    assert parse(client, "")["items"] is None
    assert parse(client, "3")["items"] is None


def test_what_cannot_be_meant_is_a_warning(client):
    found = parse(client, ROOM.replace("at: [1, 2], sensors", "at: [0, 2], sensors"))
    (problem,) = found["problems"]
    assert (problem["kind"], problem["path"]) == ("warning", ["robots", 0, "at"])
    assert "starts inside walls[0]" in problem["message"]
    assert len(found["items"]) == 10


def test_saving_never_overwrites_what_somebody_else_wrote(client, folder):
    path = folder / "mine.yaml"
    first = told(client, "save", path="mine.yaml", text="mjsim: 1\n")["stamp"]
    assert path.read_text() == "mjsim: 1\n"
    second = told(client, "save", path="mine.yaml", text="mjsim: 1\nname: a\n", stamp=first)["stamp"]
    assert second != first
    path.write_text("mjsim: 1\nname: theirs\n")
    for stamp in (second, first, None, ""):
        answer = told(client, "save", status=409, path="mine.yaml", text="mjsim: 1\nname: b\n", stamp=stamp)
        assert "overwrite it, or save under another name" in answer["error"]
    assert path.read_text() == "mjsim: 1\nname: theirs\n"
    assert told(client, "open", path="mine.yaml")["stamp"] == answer["stamp"]
    told(client, "save", path="mine.yaml", text="mjsim: 1\nname: b\n", stamp=second, overwrite=True)
    assert path.read_text() == "mjsim: 1\nname: b\n"
    told(client, "save", path="new/room.yaml", text="mjsim: 1\n")
    assert (folder / "new" / "room.yaml").is_file()
    path.unlink()


def test_a_save_that_fails_leaves_the_old_text_and_nothing_else(client, folder, monkeypatch):
    stamp = told(client, "save", path="kept.yaml", text="mjsim: 1\n")["stamp"]

    def full(descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    answer = told(client, "save", status=409, path="kept.yaml", text="mjsim: 1\nname: lost\n", stamp=stamp)
    assert answer["error"] == "'kept.yaml' cannot be written: No space left on device; choose another place"
    monkeypatch.undo()
    assert (folder / "kept.yaml").read_text() == "mjsim: 1\n"
    assert not [path for path in folder.iterdir() if path.name.endswith(".new")]
    (folder / "kept.yaml").unlink()


def test_ends_of_lines_and_the_byte_order_mark_of_a_file_are_kept(client, folder):
    path = folder / "windows.yaml"
    path.write_bytes(b"\xef\xbb\xbfmjsim: 1\r\nname: a\r\n")
    opened = told(client, "open", path="windows.yaml")
    text = opened["text"].replace("\r\n", "\n").replace("name: a", "name: b")
    told(client, "save", path="windows.yaml", text=text, stamp=opened["stamp"])
    assert path.read_bytes() == b"\xef\xbb\xbfmjsim: 1\r\nname: b\r\n"
    path.unlink()


@pytest.mark.slow
def test_new_worlds_begin_empty_or_as_a_template_and_are_not_written_before_they_are_saved(client, folder):
    before = sorted(folder.rglob("*"))
    new = told(client, "new")
    assert (new["path"], new["stamp"], new["items"], new["problems"]) == ("room-2.yaml", None, [], [])
    assert told(client, "new", template="gallery")["text"].startswith("# Two rooms of a gallery")
    assert client.post("/api/new", json={"template": "palace"}).json()["error"].startswith("no template 'palace'")
    shipped = told(client, "open", path="shipped:gallery")
    assert shipped["stamp"] is None
    assert len(shipped["items"]) > 40
    assert client.post("/api/open", json={"path": "shipped:../room"}).status_code == 404
    assert client.post("/api/open", json={"path": "nowhere.yaml"}).status_code == 404
    assert sorted(folder.rglob("*")) == before


def test_a_world_built_in_python_has_items_too():
    world = mjsim.World(robots=[{"name": "scout", "at": (1.0, 2.0), "heading_deg": 45.0}])
    (robot,) = scene_of(world)["items"]
    assert (robot["at"], robot["written"], robot["fixed"], robot["line"]) == ([1.0, 2.0], [], None, 1)
    assert math.isclose(robot["heading_deg"], 45.0)
    assert json.dumps(robot)


def test_a_text_that_was_parsed_before_is_parsed_anew_once_a_file_that_it_names_is_another(client, folder):
    hall = folder / "hall.yaml"
    text = "mjsim: 1\ninclude: [hall.yaml]\nrobots: [{name: scout, at: [1, 1]}]\n"

    def walls() -> int:
        told = client.post("/api/parse", json={"path": "room.yaml", "text": text}).json()
        assert told["problems"] == []
        return sum(item["kind"] == "wall" for item in told["items"])

    hall.write_text("walls: [{points: [[0, 0], [3, 0]]}]\n")
    assert [walls(), walls()] == [1, 1]
    hall.write_text("walls: [{points: [[0, 0], [3, 0]]}, {points: [[0, 3], [3, 3]]}]\n")
    assert walls() == 2
