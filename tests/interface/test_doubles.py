"""The form of trees for Octave, evaluated as Octave does: numbers from 1, arrays column by column."""

import json
import re

import numpy as np
import pytest

from mjsim.geometry import Pose
from mjsim.interface import (
    CameraFrame,
    Command,
    FastReading,
    ImuReading,
    Intrinsics,
    JointGoal,
    JointState,
    WheelCommand,
)
from mjsim.interface.doubles import answer_of, doubles_of, octave_names, quoted
from mjsim.interface.trees import Named, RecordList, Stack, Text, _camera, _sheet, command_tree, fast_tree


def evaluated(tree):
    """Return a tree as Octave would hold it: structs as dicts, cells as lists, tables as lists of dicts."""
    made = doubles_of(tree)
    numbers, ends = made.numbers()
    pixels = np.concatenate([np.zeros(0, np.uint8), *made.bytes])

    def d(first, last=None):
        return float(numbers[first - 1]) if last is None else numbers[first - 1 : last]

    def reshape(values, *shape):
        return np.asarray(values).reshape([-1 if size == () else size for size in shape], order="F")

    def struct(*pairs):
        return dict(
            zip(pairs[::2], (v[0] if isinstance(v, list) and len(v) == 1 else v for v in pairs[1::2]), strict=True)
        )

    code = re.sub(r"\[\]", "()", made.code)
    code = re.sub(r"(?<=[\w)]):(?=[\w(])", ",", code)
    code = code.replace("{", "[").replace("}", "]").replace("true", "True").replace("false", "False")
    places = {"d": d, "e": lambda k: int(ends[k - 1]), "b": lambda first, last: pixels[first - 1 : last]}
    return eval(code, {"__builtins__": {}}, {**places, "reshape": reshape, "struct": struct, "char": lambda v: v})


def test_numbers_texts_and_truth_values_are_put_in_order():
    assert evaluated({"a": 1.5, "b": True, "c": np.bool_(False), "d": 3, "e": "x", "f": np.float32(0.5)}) == {
        "a": 1.5,
        "b": True,
        "c": False,
        "d": 3.0,
        "e": "x",
        "f": 0.5,
    }
    assert evaluated({"none": None})["none"] == ()


@pytest.mark.parametrize("shape", [(3,), (2, 3), (4, 20), (100,), (2, 3, 4)])
def test_arrays_come_back_column_by_column_small_and_large(shape):
    array = np.arange(float(np.prod(shape))).reshape(shape)
    found = evaluated({"before": 7.0, "array": array, "after": 8.0})
    np.testing.assert_array_equal(found["array"], array if array.ndim > 1 else array[:, None])
    assert (found["before"], found["after"]) == (7.0, 8.0)


def test_stacks_lie_along_the_last_axis_whatever_their_number():
    items = np.arange(24.0).reshape(4, 2, 3)
    found = evaluated({"a": Stack(items), "b": Stack(np.arange(3.0)), "c": Stack(np.zeros((0, 2))), "d": np.eye(9)})
    np.testing.assert_array_equal(found["a"], np.moveaxis(items, 0, -1))
    np.testing.assert_array_equal(found["b"], [[0.0, 1.0, 2.0]])
    assert found["c"].shape == (2, 0)
    np.testing.assert_array_equal(found["d"], np.eye(9))
    assert doubles_of({"a": Stack(items)}).code == doubles_of({"a": Stack(items[:1])}).code


def test_pictures_are_bytes_one_after_the_other():
    one, two = (np.random.default_rng(k).integers(0, 256, (3, 4, 3), dtype=np.uint8) for k in (0, 1))
    found = evaluated({"one": one, "two": two})
    np.testing.assert_array_equal(found["one"], one)
    np.testing.assert_array_equal(found["two"], two)


def test_lists_become_rows_matrices_or_cells():
    found = evaluated({"row": [1, 2, 3], "rows": [[1, 2], [3, 4]], "texts": ["a", "b"], "uneven": [[1, 2], [3]]})
    np.testing.assert_array_equal(found["row"], [[1.0, 2.0, 3.0]])
    np.testing.assert_array_equal(found["rows"], [[1.0, 2.0], [3.0, 4.0]])
    assert found["texts"] == ["a", "b"]
    np.testing.assert_array_equal(found["uneven"][1], [[3.0]])


def test_tables_are_arrays_of_structs_with_the_same_keys():
    assert evaluated({"t": RecordList(("a", "b"), [{"b": 1.0, "a": "x"}, {"a": "y", "b": 2.0}])})["t"] == [
        {"a": "x", "b": 1.0},
        {"a": "y", "b": 2.0},
    ]
    assert doubles_of(RecordList(("a", "b"), [])).code == "struct('a',{},'b',{})"


def test_names_of_the_users_become_fields_and_keep_themselves_beside():
    found = evaluated(Named({"my-arm": {"q": 1.0}, "plain": 2.0}))
    (field,) = set(found) - {"plain"}
    assert found[field] == {"q": 1.0, "name": "my-arm"}
    assert octave_names(["a", "b"]) == {"a": "a", "b": "b"}
    with pytest.raises(ValueError, match=f"'my-arm' and 'my.arm' both become the field '{field}'; rename one"):
        octave_names(["my-arm", "my.arm"])


def test_texts_are_quoted_or_bytes():
    assert quoted("it's") == "'it''s'"
    assert quoted("a\n") == "char([97 10])"
    assert quoted("ü") == "char([195 188])"
    np.testing.assert_array_equal(evaluated({"t": Text("aü")})["t"], [[97.0, 195.0, 188.0]])


def packed(*fields):
    return np.concatenate(
        [np.array([kind, np.ndim(v), *np.shape(v), *np.ravel(v, order="F")], float) for kind, v in fields]
    ).tobytes()


def test_an_answer_of_octave_is_read_field_by_field():
    matrix = np.arange(6.0).reshape(2, 3)
    said = np.frombuffer("ü!".encode(), np.uint8)[None]
    record = np.frombuffer(json.dumps({"a": [1]}).encode(), np.uint8)[None]
    found = answer_of(packed((1, matrix), (0, np.zeros((0, 0))), (2, said), (3, record)), ["a", "b", "c", "d"])
    np.testing.assert_array_equal(found["a"], matrix)
    assert {key: found[key] for key in ("c", "d")} == {"c": "ü!", "d": {"a": [1]}}
    assert "b" not in found


def test_commands_have_a_twist_and_goals_or_the_speeds_of_wheels():
    goal = JointGoal(positions=(1.0, 2.0), accelerations=(3.0, 4.0), torques=(5.0, 6.0))
    tree = command_tree(Command(0.1, left=0.2, turn=0.3, joints={"arm": goal}))
    assert (tree["forward"], tree["left"], tree["turn"]) == (0.1, 0.2, 0.3)
    parts = tree["joints"]["arm"]
    np.testing.assert_array_equal([parts["q"], parts["qdd"], parts["tau"]], [[1, 2], [3, 4], [5, 6]])
    assert parts["qd"] is None
    np.testing.assert_array_equal(command_tree(WheelCommand((1.0, 2.0)))["wheels"].items, [1.0, 2.0])


def test_a_goal_goes_on_with_its_speeds_and_accelerations():
    goal = JointGoal(positions=(1.0, 2.0), velocities=(0.5, -1.0), accelerations=(2.0, 4.0), torques=(7.0, 8.0))
    later = goal.after(0.5)
    assert later.positions == pytest.approx((1.0 + 0.25 + 0.25, 2.0 - 0.5 + 0.5))
    assert later.velocities == pytest.approx((1.5, 1.0))
    assert (later.accelerations, later.torques) == (goal.accelerations, goal.torques)
    still = JointGoal(positions=(1.0,))
    assert still.after(3.0) == still
    assert JointGoal(positions=(1.0,), velocities=(2.0,)).after(0.5).positions == (2.0,)


def test_readings_between_ticks_have_joints_wheels_and_inertial_rows():
    state = JointState(0.4, np.array([1.0]), np.array([2.0]), np.array([3.0]))
    imu = ImuReading(0.3, np.array([1.0, 2.0, 3.0]), np.array([4.0, 5.0, 6.0]))
    tree = fast_tree(FastReading(0.5, 0.004, {"arm": state}, state, (imu,)))
    assert (tree["time"], tree["dt"]) == (0.5, 0.004)
    for part in (tree["joints"]["arm"], tree["wheels"]):
        assert [part["stamp"], *part["q"], *part["qd"], *part["tau"]] == [0.4, 1.0, 2.0, 3.0]
    np.testing.assert_array_equal(tree["imu"].items, [[0.3, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]])


def test_pictures_have_depth_and_instances_where_they_are_measured():
    lens = Intrinsics(4, 3, 10.0, 11.0, 1.5, 1.0, "brown", (0.1, 0.2))
    frame = CameraFrame(0.1, np.zeros((3, 4, 3), np.uint8), lens)
    assert set(_camera(frame)) == {"stamp", "image"}
    both = CameraFrame(0.1, frame.image, lens, np.ones((3, 4)), np.full((3, 4), -1, np.int32), ("wall",))
    assert set(_camera(both)) == {"stamp", "image", "depth", "segmentation", "instances"}
    told = _sheet(lens)
    np.testing.assert_array_equal(told["matrix"], [[10.0, 0.0, 1.5], [0.0, 11.0, 1.0], [0.0, 0.0, 1.0]])
    np.testing.assert_array_equal(told["distortion"].items, [0.1, 0.2])
    assert Pose(0.0, 0.0, 0.0).as_array().shape == (3,)
