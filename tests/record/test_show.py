"""What an estimator shows is checked, recorded as Foxglove's scene entities, and read back."""

import base64
import json
import struct

import cv2
import foxglove.messages
import numpy as np
import pytest
from mcap.reader import make_reader

import mjsim
from mjsim.geometry import Pose
from mjsim.interface import Estimate, ShownGrid, ShownLines, ShownPoints, ShownText
from mjsim.modules.checks import checked_estimate
from mjsim.modules.covariances import Unfit
from mjsim.record.drawn.shown_entities import grid_png, show_message, shown_of

CELLS = np.array([[0.0, 0.5, 1.0], [np.nan, 1.0, 0.25]])
SHOWN = (
    ShownPoints(name="particles", points=[[1, 2], [3, 4.5]], size=0.1, color="#ff0000"),
    ShownLines(name="path", frame="estimate", points=[[0, 0, 1], [1, 0, 1], [1, 1, 1]]),
    ShownGrid(name="map", cells=CELLS, resolution=0.5, origin=Pose(1.0, 2.0, 0.5)),
    ShownText(name="note", frame="base", text="<b>here</b> & there", at=(1, 1)),
)


class Showing:
    """Stands still and shows; from 0.2 s on nothing."""

    def start(self, robot, catalogue, rng):
        self.prior = robot.prior

    def update(self, seen):
        return Estimate(self.prior, np.eye(3), show=SHOWN if seen.time < 0.19 else ())


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("show") / "run.mcap"
    with mjsim.Simulation(mjsim.parse_world("robots: [{name: scout, at: [0, 0]}]")) as sim:
        mjsim.run(sim, drivers={"scout": mjsim.Driver(estimator=Showing())}, seconds=0.4, record=path)
    return path


def test_another_reader_finds_scene_entities_that_foxglove_takes(recorded):
    with recorded.open("rb") as stream:
        found = list(make_reader(stream).iter_messages(topics=["/scout/show"]))
    # What is the very same is not written again: one message that shows it, one that shows nothing more.
    assert [message.log_time for _, _, message in found] == [0, 200_000_000]
    assert {(schema.name, channel.message_encoding) for schema, channel, _ in found} == {
        ("foxglove.SceneUpdate", "json")
    }
    first, last = (json.loads(message.data) for _, _, message in found)
    update = foxglove.messages.SceneUpdate(
        deletions=[], entities=[_foxglove(foxglove.messages.SceneEntity, entity) for entity in first["entities"]]
    )
    assert len(update.encode()) > 500
    assert [entity["frame_id"] for entity in first["entities"]] == ["world", "scout/estimate", "world", "scout/base"]
    assert first["entities"][1]["lines"][0]["points"][1] == {"x": 1.0, "y": 0.0, "z": 1.0}
    assert first["entities"][3]["texts"][0]["text"] == "<b>here</b> & there"
    assert last["entities"] == []
    assert last["deletions"][0]["type"] == 1


def test_foxglove_gets_points_as_squares_about_them(recorded):
    line = show_message(0.0, "scout", SHOWN[:1])["entities"][0]["lines"][0]
    ends = np.array([[point[axis] for axis in "xyz"] for point in line["points"]]).reshape(2, 2, 3)
    np.testing.assert_allclose(ends.mean(axis=1), [[1, 2, 0], [3, 4.5, 0]], atol=1e-12)
    np.testing.assert_allclose(ends[:, 1] - ends[:, 0], [[line["thickness"], 0, 0]] * 2, atol=1e-12)


def test_foxglove_gets_a_grid_as_a_picture_on_the_floor_with_its_first_row_nearest():
    data = base64.b64decode(show_message(0.0, "scout", SHOWN[2:3])["entities"][0]["models"][0]["data"])
    magic, version, length, size, kind = struct.unpack_from("<4sIII4s", data)
    assert (magic, version, length, kind) == (b"glTF", 2, len(data), b"JSON")
    tree, binary = json.loads(data[20 : 20 + size]), data[28 + size :]
    views = [binary[view["byteOffset"] :][: view["byteLength"]] for view in tree["bufferViews"]]
    corners = np.frombuffer(views[0], "<f4").reshape(4, 3)
    # In glTF y is up: what is +y on the floor is -z there.
    np.testing.assert_array_equal(corners[:, [0, 2]], [[0, 0], [1.5, 0], [1.5, -1], [0, -1]])
    places = np.frombuffer(views[1], "<f4").reshape(4, 2)
    picture = cv2.imdecode(np.frombuffer(views[3], np.uint8), cv2.IMREAD_UNCHANGED)
    opacity = picture[:, :, 3]
    assert opacity.shape == CELLS.shape
    lower_left = opacity[int(places[0][1] * 2) - 1, int(places[0][0])]
    assert lower_left > 0
    assert (opacity == 0).sum() == 1
    assert opacity[0, 0] == 0, "the cell that is not known has the larger y"


def test_what_was_shown_is_read_back_at_each_tick(recorded):
    shown = mjsim.read_recording(recorded).robots["scout"].shown
    assert [len(items) for items in shown] == [4] * 5 + [0] * (len(shown) - 5)
    points, lines, grid, text = shown[4]
    np.testing.assert_array_equal(points.points, SHOWN[0].points)
    assert (points.size, points.color, lines.frame, lines.joined) == (0.1, "#ff0000", "estimate", True)
    np.testing.assert_allclose(grid.cells, CELLS, atol=0.5 / 254)
    assert (grid.origin, grid.resolution) == (SHOWN[2].origin, 0.5)
    assert (text.text, text.at.tolist()) == (SHOWN[3].text, [1.0, 1.0, 0.0])


@pytest.mark.parametrize(
    ("make", "why"),
    [
        (lambda: ShownPoints(name="p", points=[[1, 2, 3, 4]]), r"points have shape \(1, 4\); it must be \(n, 2\)"),
        (lambda: ShownPoints(name="p", points=[[1, np.nan]]), "points hold numbers that are not finite"),
        (lambda: ShownPoints(name="p", points=[[1, 2]], size=0), "size is 0; it must be above 0 m"),
        (lambda: ShownPoints(name="", points=[]), "name is ''; it must be 1 to 200 printable"),
        (lambda: ShownPoints(name="p", points=[], color="red"), "color is 'red'; it must be a text such as"),
        (lambda: ShownPoints(name="p", points=[], frame="map"), "frame is 'map'; it must be one of world, estimate"),
        (lambda: ShownLines(name="l", points=[[0, 0]], joined=False), "1 points of lines that are not joined"),
        (lambda: ShownGrid(name="g", cells=[[2.0]], resolution=1), "cells are from 2 to 2; they must be from 0 to 1"),
        (lambda: ShownGrid(name="g", cells=[], resolution=1), r"cells have shape \(0,\); it must be \(rows, columns\)"),
        (lambda: ShownText(name="t", text="a\nb", at=(0, 0)), "text is .* printable characters"),
    ],
)
def test_what_cannot_be_shown_is_refused_in_one_line(make, why):
    with pytest.raises(ValueError, match=why):
        make()


@pytest.mark.parametrize(
    ("show", "why"),
    [
        ("text", "a show that is a value of type str; it must be a tuple of ShownPoints"),
        ([1], "a value of type int in its show; each must be one of ShownPoints"),
        ([ShownPoints(name="p", points=[])] * 65, "65 items are shown at once; there must be at most 64"),
        ([ShownPoints(name="p", points=np.zeros((15_000, 2)))] * 2, "30000 points are shown at once"),
        ([ShownGrid(name="g", cells=np.zeros((1025, 1024)), resolution=1)], "1049600 cells are shown at once"),
    ],
)
def test_too_much_or_something_else_is_the_modules_fault(show, why):
    with pytest.raises(Unfit, match=why):
        checked_estimate(Estimate(Pose(0, 0, 0), np.eye(3), show=show))


def test_shown_items_may_be_a_list_and_are_copied():
    points = np.zeros((2, 2))
    belief = checked_estimate(Estimate(Pose(0, 0, 0), np.eye(3), show=[ShownPoints(name="p", points=points)]))
    points[:] = 7.0
    assert isinstance(belief.show, tuple)
    assert not belief.show[0].points.any()


def test_a_hostile_message_is_a_value_error_and_not_a_large_array():
    value = show_message(0.0, "r", SHOWN[2:3])["shown"][0]
    bomb = cv2.imencode(".png", np.zeros((2, 2), np.uint8))[1].tobytes()
    bomb = bomb[:16] + struct.pack(">II", 60_000, 60_000) + bomb[24:]
    for cells in (b"", b"no picture", bomb):
        with pytest.raises(ValueError, match=r"."):
            shown_of({"shown": [{**value, "cells": base64.b64encode(cells).decode()}]})


def _foxglove(kind, fields):
    """Return a message of Foxglove's own from its fields as JSON has them; TypeError for one that it does not know."""
    inner = {
        "timestamp": lambda value: foxglove.messages.Timestamp(value["sec"], value["nsec"]),
        "lifetime": lambda value: foxglove.messages.Duration(value["sec"], nsec=value["nsec"]),
        "pose": lambda value: _foxglove(foxglove.messages.Pose, value),
        "position": lambda value: foxglove.messages.Vector3(**value),
        "scale": lambda value: foxglove.messages.Vector3(**value),
        "orientation": lambda value: foxglove.messages.Quaternion(**value),
        "color": lambda value: foxglove.messages.Color(**value),
        "points": lambda values: [foxglove.messages.Point3(**value) for value in values],
        "lines": lambda values: [_foxglove(foxglove.messages.LinePrimitive, value) for value in values],
        "texts": lambda values: [_foxglove(foxglove.messages.TextPrimitive, value) for value in values],
        "models": lambda values: [_foxglove(foxglove.messages.ModelPrimitive, value) for value in values],
        "data": lambda value: base64.b64decode(value),
        "type": lambda value: {
            0: foxglove.messages.LinePrimitiveLineType.LineStrip,
            2: foxglove.messages.LinePrimitiveLineType.LineList,
        }[value],
    }
    return kind(**{key: inner.get(key, lambda value: value)(value) for key, value in fields.items()})


def test_the_first_row_of_a_picture_of_a_grid_has_the_largest_y():
    cells = np.array([[0.0, 1.0], [np.nan, 0.5]])
    grid = ShownGrid(name="map", cells=cells, resolution=0.1, origin=Pose(0.0, 0.0, 0.0))
    picture = cv2.imdecode(np.frombuffer(grid_png(grid), dtype=np.uint8), cv2.IMREAD_GRAYSCALE)
    np.testing.assert_array_equal(picture, [[255, 127], [254, 0]])
    (back,) = shown_of(show_message(1.0, "r", [grid]))
    np.testing.assert_allclose(back.cells, cells, atol=0.5 / 254)
