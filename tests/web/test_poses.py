"""What the page asks for while a mechanism or a person is posed."""

import pytest

from mjsim.web.edit.poses import PoseAsk, pose_json
from mjsim.web.server.answers import RefusedError
from mjsim.world import Change, edit_text, parse_world

WORLD = """\
mjsim: 1
mechanisms:
  - name: press   # heavy
    at: [2, 1]
    heading_deg: 90
    elevation: 1
    bodies: [{name: sled, box: [0.5, 0.3, 0.2]}, {name: arm, rod: [1, 0.1]}]
    joints:
      - {prismatic: slide, of: [ground, sled], axis: [1, 0, 0]}   # to and fro
      - {revolute: swing, of: [sled, arm], axis: [0, 1, 0], start_deg: 20}
people:
  - {name: eve, sex: female, at: [0, 0], joints_deg: {neck_twist: 10}}   # looks aside
"""
PRESS, EVE = ("mechanisms", 0), ("people", 0)


def posed(item, text=WORLD, **keys):
    return pose_json(parse_world(text), PoseAsk(path="room.yaml", text=text, item=item, **keys))


def written(changes, text=WORLD):
    return edit_text(text, [Change(each["op"], tuple(each["path"]), each["value"]) for each in changes])


def test_a_slide_is_pulled_on_the_plan_and_lands_in_the_text_with_all_comments():
    found = posed(PRESS, pull={"look": "above", "part": "slide", "start": [2, 1], "end": [2.1, 1.4]})
    assert [item["path"] for item in found["items"]] == [[*PRESS], [*PRESS, "joints", 0]]
    assert found["items"][1]["at"] == pytest.approx([2.0, 1.4])  # heading 90 degrees: along y
    text = written(found["changes"])
    assert "start: 0.4" in text
    assert [line for line in text.splitlines() if "#" in line][1].endswith("# to and fro")
    assert parse_world(text).mechanisms[0].assembly.start[0] == pytest.approx(0.4)


def test_an_arm_about_a_level_axis_is_pulled_in_the_drawing_from_the_side():
    shown = posed(PRESS)
    assert {part["name"]: part["pull"] for part in shown["parts"]} == {"sled": "slide", "arm": "swing"}
    found = posed(PRESS, pull={"look": "side", "part": "swing", "start": [0.5, 0.8], "end": [0.0, 0.5]})
    assert found["changes"][0]["path"] == [*PRESS, "joints", 1, "start_deg"]
    assert found["changes"][0]["value"] == pytest.approx(88.2, abs=0.1)  # about [0, 1]: from atan(0.4) down, by 20 less


def test_sliders_hold_what_joints_are_and_move_them():
    values = {each["name"]: each for each in posed(PRESS)["values"]}
    assert values["swing"] == {"name": "swing", "value": 20.0, "low": -180.0, "high": 180.0, "unit": "°", "free": True}
    moved = posed(PRESS, values={"slide": 0.25})
    assert moved["changes"] == [{"op": "set", "path": [*PRESS, "joints", 0, "start"], "value": 0.25}]


@pytest.mark.parametrize("look", ["above", "side", "front"])
def test_a_hand_that_is_pulled_in_any_drawing_goes_there_in_it(look):
    side = {"above": (0, 1), "side": (0, 2), "front": (1, 2)}[look]
    before = posed(EVE)["hands"]["right"]
    by = {"above": (0.25, 0.1), "side": (0.25, 0.2), "front": (0.1, 0.2)}[look]
    found = posed(EVE, pull={"look": look, "part": "right", "start": [0, 0], "end": by})
    after = found["hands"]["right"]
    # The text has hundredths of a degree.
    assert [after[axis] - before[axis] for axis in side] == pytest.approx(by, abs=2e-3)
    text = written(found["changes"])
    assert "# looks aside" in text
    assert posed(EVE, text)["hands"]["right"] == pytest.approx(after, abs=1e-4)


def test_joints_of_a_person_stay_within_their_ranges():
    found = posed(EVE, values={"left_elbow_flexion": 400, "neck_twist": -5})
    assert {each["path"][-1]: each["value"] for each in found["changes"]} == {
        "left_elbow_flexion": 145,
        "neck_twist": -5,
    }


def test_what_is_out_of_reach_says_how_far():
    found = posed(EVE, hands={"left": [2.0, 0.0, 1.0]})
    assert found["note"].startswith("the left hand does not reach: 1.")
    assert found["changes"]


SEATED = """\
mjsim: 1
obstacles: [{name: stool, box: [0.4, 0.4, 0.4], at: [1, 1], seat: {at: [0, 0, 0.5]}}]
people: [{name: ann, sex: female, seat: stool}]
"""


@pytest.mark.parametrize(
    ("item", "keys", "message"),
    [
        (("mechanisms", 3), {}, "no mechanisms[3] in this text; there are 1"),
        (("people", -1), {}, "no people[-1] in this text; there are 1"),
        (PRESS, {"values": {"slid": 1}}, "no joint 'slid' in this mechanism; did you mean 'slide'?"),
        (PRESS, {"hands": {"left": [0, 0, 1]}}, "a mechanism has no hands; give values, or pull a joint"),
        (EVE, {"values": {"knee": 1}}, "no joint 'knee'; there are head_bend"),
        (EVE, {"pull": {"look": "side", "part": "nose", "start": [0, 0], "end": [1, 1]}}, "'nose' is not a hand"),
    ],
)
def test_what_cannot_be_posed_is_refused_in_one_line(item, keys, message):
    with pytest.raises(RefusedError) as refused:
        posed(item, **keys)
    assert refused.value.message.startswith(message)
    assert refused.value.status == (404 if "in this text" in message else 409)


def test_who_sits_is_posed_by_the_seat():
    shown = posed(EVE, SEATED)
    assert (shown["hands"], {each["free"] for each in shown["values"]}) == ({}, {False})
    assert {part["pull"] for part in shown["parts"]} == {None}
    for keys in ({"values": {"neck_twist": 3}}, {"hands": {"left": (0, 0, 1)}}):
        with pytest.raises(RefusedError, match="the seat and its targets define the posture of a seated person"):
            posed(EVE, SEATED, **keys)
