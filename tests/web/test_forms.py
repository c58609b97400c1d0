"""What the page gets, by small functions: numbers, views, pictures and shown items; no server."""

import base64
import math

import cv2
import numpy as np
import pytest

from mjsim.errors import UsageError
from mjsim.geometry import Pose, wrap_angle
from mjsim.interface import ShownGrid, ShownLines, ShownPoints, ShownText
from mjsim.models import bounded
from mjsim.web.review.fields import MAX_DEPTH, MAX_LIST_LENGTH, numbers_in
from mjsim.web.review.review_api import _number
from mjsim.web.run.history import plain, track_json
from mjsim.web.run.shots import depth_shown, instance_colour
from mjsim.web.run.showing import shown_json
from mjsim.web.server.answers import RefusedError
from mjsim.web.worlds.folder import Folder
from mjsim.web.worlds.mechanism_poses import moved, sliders, start_values
from mjsim.web.worlds.own_robots import preset_of
from mjsim.web.worlds.shipped_parts import SHIPPED, is_shipped, shipped
from mjsim.web.worlds.uploaded_pictures import MAX_SIDE, _plain, bring_picture, decoded, encoded, small_picture
from mjsim.web.worlds.viewpoints import look_at
from mjsim.web.worlds.world_files import listed, new_world, read_world, source_of, stamp_of
from mjsim.world import load_world, parse_world


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "room.yaml").write_text("mjsim: 1\n")
    return Folder(tmp_path)


def png(pixels):
    return cv2.imencode(".png", pixels)[1].tobytes()


def jpg(pixels):
    return cv2.imencode(".jpg", pixels)[1].tobytes()


def test_numbers_are_rounded_and_what_is_no_number_is_none():
    assert plain([[1.23456789, math.inf], [math.nan, -0.00004]], 4) == [[1.2346, None], [None, -0.0]]
    assert plain(2.5) == 2.5
    assert plain(math.nan) is None
    assert plain([1e308], 9) == [1e308], "it overflows when it is rounded"


def test_a_track_has_deviations_errors_and_nees_of_each_row():
    rng = np.random.default_rng(0)
    truth, estimate, odometry = rng.normal(size=(3, 5, 3))
    root = rng.normal(size=(5, 3, 3))
    P = root @ np.swapaxes(root, -1, -2)
    told = track_json(
        np.arange(5.0),
        truth=truth,
        estimate=estimate,
        odometry=odometry,
        covariance=P.reshape(5, 9),
        timing={"estimator": np.full(5, 0.002)},
        estimated=True,
    )
    off = estimate - truth
    off[:, 2] = [wrap_angle(angle) for angle in off[:, 2]]
    np.testing.assert_allclose(told["sigma"], np.sqrt([np.diag(each) for each in P]), atol=1e-4)
    np.testing.assert_allclose(told["error"], np.hypot(off[:, 0], off[:, 1]), atol=1e-4)
    np.testing.assert_allclose(np.abs(told["heading_error"]), np.abs(off[:, 2]), atol=1e-4)
    np.testing.assert_allclose(
        told["nees"], [e @ np.linalg.solve(C, e) for e, C in zip(off, P, strict=True)], atol=1e-3
    )
    assert told["timing"] == {"estimator": [2.0] * 5}, "milliseconds"
    none = track_json(
        np.arange(5.0),
        truth=truth,
        estimate=odometry,
        odometry=odometry,
        covariance=P.reshape(5, 9),
        timing={},
        estimated=False,
    )
    assert none["nees"] == [None] * 5


def test_numbers_of_a_message_have_the_names_of_their_keys():
    message = {"a": 1, "b": {"c": [True, "x", 2.5]}, "time": 3, "list": [{"name": "hip", "q": 4}, {"q": 5}]}
    assert list(numbers_in(message)) == [
        ("a", 1.0),
        ("b.c[0]", 1.0),
        ("b.c[2]", 2.5),
        ("list[hip].q", 4.0),
        ("list[1].q", 5.0),
    ]
    assert list(numbers_in({"a": [0.0] * (MAX_LIST_LENGTH + 1)})) == []
    assert len(list(numbers_in({"a": [0.0] * MAX_LIST_LENGTH}))) == MAX_LIST_LENGTH
    deep = 1.0
    for _ in range(MAX_DEPTH):
        deep = {"k": deep}
    assert len(list(numbers_in(deep))) == 1
    assert list(numbers_in({"k": deep})) == []


def test_views_from_the_side_and_the_front_have_their_axes_right_up_and_towards_the_viewer():
    at, heading = (2.0, 3.0), 0.7
    ahead, left = np.array([math.cos(0.7), math.sin(0.7), 0.0]), np.array([-math.sin(0.7), math.cos(0.7), 0.0])
    up = np.array([0.0, 0.0, 1.0])
    np.testing.assert_array_equal(look_at("above", at, heading), np.eye(4)[:3])
    for look, right, towards in (("side", ahead, -left), ("front", left, ahead)):
        drawing = look_at(look, at, heading)
        origin = np.array([*at, 0.0])
        np.testing.assert_allclose(drawing[:, :3] @ origin + drawing[:, 3], 0.0, atol=1e-12)
        for k, axis in enumerate((right, up, towards)):
            np.testing.assert_allclose(drawing[:, :3] @ axis, np.eye(3)[k], atol=1e-12)


def test_what_an_estimator_shows_is_told_by_its_kind():
    points = np.arange(6.0).reshape(2, 3)
    grid = ShownGrid(name="map", cells=np.zeros((2, 3)), resolution=0.5, origin=Pose(1.0, 2.0, 0.5))
    one, two, three, four = shown_json(
        [
            ShownPoints(name="p", points=points, size=0.1),
            ShownLines(name="l", points=points, joined=True, width=0.2),
            ShownText(name="t", text="hello", at=points[0]),
            grid,
        ]
    )
    assert (one["points"], one["size"]) == ([0.0, 1.0, 2.0, 3.0, 4.0, 5.0], 0.1)
    assert (two["joined"], two["size"], two["lines"]) == (True, 0.2, one["points"])
    assert (three["text"], three["points"]) == ("hello", [0.0, 1.0, 2.0])
    assert (four["size"], four["origin"], four["cells"]) == (0.5, (1.0, 2.0, 0.5), (3, 2))
    assert base64.b64decode(four["png"]).startswith(b"\x89PNG")


def test_near_things_are_warm_and_what_is_not_measured_is_told_apart():
    colours = depth_shown(np.array([[0.3, 8.0, np.inf, -np.inf]])).astype(int)
    assert colours[0, 0, 0] > colours[0, 0, 2], "red"
    assert colours[0, 1, 2] > colours[0, 1, 0], "blue"
    np.testing.assert_array_equal(colours[0, 2], colours[0, 3])
    assert instance_colour("obstacle/a") == instance_colour("obstacle/a") != instance_colour("obstacle/b")
    assert instance_colour("wall") == (150, 155, 164)


def test_a_picture_keeps_its_kind_and_gets_a_free_name_beside_its_world(folder):
    pixels = np.full((4, 6, 3), 90, np.uint8)
    told = [
        bring_picture(folder, data, name="my lion!.x", world="deep/room.yaml")
        for data in (png(pixels), jpg(pixels), png(pixels))
    ]
    assert [each["file"] for each in told] == ["deep/my-lion.png", "deep/my-lion.jpg", "deep/my-lion-2.png"]
    assert (folder.root / told[0]["file"]).read_bytes().startswith(b"\x89PNG")
    assert (folder.root / told[1]["file"]).read_bytes().startswith(b"\xff\xd8")
    assert bring_picture(folder, png(pixels), name="../..", world=None)["file"] == "picture.png"
    assert bring_picture(folder, png(pixels), name="кот 1/海报.png", world=None)["file"] == "海报.png"
    with pytest.raises(RefusedError, match=r"^'notes\.txt' is not a PNG or JPEG picture; convert it$"):
        bring_picture(folder, b"hello", name="notes.txt", world=None)
    assert small_picture(folder, "my-lion.png", size=64, world="deep/room.yaml").startswith(b"\xff\xd8")
    with pytest.raises(RefusedError) as caught:
        small_picture(folder, "none.png", size=64, world=None)
    assert caught.value.status == 404


TWO_WHEELS = """\
<robot name="own"><link name="base"><inertial><mass value="8"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0"
iyz="0"/></inertial><collision><geometry><cylinder radius="0.2" length="0.15"/></geometry></collision></link>
<link name="l"><visual><origin rpy="1.5708 0 0"/><geometry><cylinder radius="0.08" length="0.04"/></geometry></visual>
</link><link name="r"><visual><origin rpy="1.5708 0 0"/><geometry><cylinder radius="0.08" length="0.04"/></geometry>
</visual></link><joint name="lw" type="continuous"><parent link="base"/><child link="l"/><origin xyz="0 0.2 0"/>
<axis xyz="0 1 0"/></joint><joint name="rw" type="continuous"><parent link="base"/><child link="r"/>
<origin xyz="0 -0.2 0"/><axis xyz="0 1 0"/></joint></robot>
"""


@pytest.mark.slow
def test_a_robot_of_the_folder_is_offered_and_becomes_a_preset_that_worlds_beside_it_name(folder):
    place = folder.root / "deep"
    (place / "own.urdf").write_text(TWO_WHEELS)
    (place / "vase.urdf").write_text("<robot name='vase'><link name='all'/></robot>")
    assert listed(folder)["robots"] == ["deep/own.urdf", "deep/vase.urdf"]
    assert preset_of(folder, "own.urdf", world="deep/room.yaml")["path"] == "own.yaml"
    assert listed(folder)["robots"] == ["deep/own.yaml", "deep/vase.urdf"]
    (place / "room.yaml").write_text("mjsim: 1\nrobots: [{name: me, preset: own.yaml, at: [1, 1]}]\n")
    (robot,) = load_world(place / "room.yaml").robots
    assert robot.drive.track == pytest.approx(0.4)
    for file in ("own.urdf", "vase.urdf", "../own.urdf", "/etc/passwd"):  # is there, has no wheels, lies elsewhere
        with pytest.raises((UsageError, RefusedError)):
            preset_of(folder, file, world="deep/room.yaml")


def test_pictures_become_eight_bits_and_three_colours_within_a_size():
    deep = (np.arange(12).reshape(3, 4) * 4096).astype(np.uint16)
    np.testing.assert_array_equal(_plain(deep)[..., 0], deep // 256)
    clear = np.full((2, 2, 4), 100, np.uint8)
    clear[0, 0, 3], clear[1, 1, 3] = 0, 255
    blended = _plain(clear)
    np.testing.assert_array_equal(blended[0, 0], 255)
    np.testing.assert_array_equal(blended[1, 1], 100)
    np.testing.assert_allclose(blended[0, 1], 255 - 155 * 100 / 255, atol=1.0)
    assert bounded(np.zeros((10, 3 * MAX_SIDE, 3), np.uint8), MAX_SIDE).shape == (3, MAX_SIDE, 3)
    assert bounded(np.zeros((5, 6, 3), np.uint8), 6).shape == (5, 6, 3)
    np.testing.assert_array_equal(decoded(encoded(blended, ".png")), blended)
    for data in (b"", b"no picture", png(blended)[:30]):
        with pytest.raises(RefusedError) as caught:
            decoded(data)
        assert caught.value.status == 415


def test_worlds_that_come_along_are_those_of_the_list(folder):
    name = shipped()["worlds"][0]
    assert is_shipped(f"{SHIPPED}{name}")
    assert not is_shipped(name)
    assert not is_shipped(f"{SHIPPED}../{name}")
    text, stamp = read_world(folder, f"{SHIPPED}{name}")
    assert "mjsim: 1" in text
    assert stamp is None
    for path in (f"{SHIPPED}none", "none.yaml"):
        with pytest.raises(RefusedError) as caught:
            read_world(folder, path)
        assert caught.value.status == 404
    assert read_world(folder, "deep/room.yaml") == ("mjsim: 1\n", stamp_of(folder.root / "deep" / "room.yaml"))
    assert source_of(folder, "deep/room.yaml").folder == folder.root / "deep"
    assert source_of(folder, f"{SHIPPED}{name}").folder == folder.root
    assert new_world(folder, None, template=None)[0] == "room.yaml"
    (folder.root / "room.yaml").write_text("")
    assert new_world(folder, None, template=None)[0] == "room-2.yaml"
    assert new_world(folder, "mine.yaml", template=None)[0] == "mine.yaml"


class Request:
    """What a request's address holds."""

    def __init__(self, **words):
        self.query_params = words


def test_a_number_in_an_address_is_finite_and_within_its_limit():
    assert _number(Request(x="1.5"), "x") == 1.5
    assert _number(Request(x="-2"), "x", limit=2.0) == -2.0
    for words, limit in (({}, math.inf), ({"x": "nan"}, math.inf), ({"x": "inf"}, math.inf), ({"x": "-2.1"}, 2.0)):
        with pytest.raises(RefusedError, match="x is"):
            _number(Request(**words), "x", limit=limit)


ARM = """
mjsim: 1
mechanisms:
  - name: m
    bodies: [{name: rod, rod: [1.0, 0.05]}, {name: cart, box: [0.2, 0.2, 0.2]}]
    joints:
      - {revolute: q, of: [ground, rod], axis: [0, 1, 0], start_deg: 30}
      - {prismatic: x, of: [rod.end, cart], axis: [1, 0, 0], range: [-0.5, 2], start: 0.25}
"""


def test_sliders_have_degrees_and_metres_and_move_the_start():
    mechanism = parse_world(ARM).mechanisms[0]
    turn, slide = sliders(mechanism)
    assert (turn["name"], turn["value"], turn["unit"]) == ("q", 30.0, "°")
    assert turn["low"] < -90.0 < 90.0 < turn["high"]
    assert (slide["name"], slide["value"], slide["low"], slide["high"], slide["unit"]) == ("x", 0.25, -0.5, 2.0, "m")
    assert start_values(mechanism, 0) == {"start_deg": 30.0}
    assert start_values(mechanism, 1) == {"start": 0.25}
    other, changes = moved(mechanism, {"q": 45.0, "x": 0.5})
    np.testing.assert_allclose(other.assembly.start, [math.pi / 4, 0.5])
    assert dict(changes) == {("joints", 0, "start_deg"): 45.0, ("joints", 1, "start"): 0.5}
