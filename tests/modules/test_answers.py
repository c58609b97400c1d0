"""Answers of modules in other languages: each shape that fits, and in one line what is wrong with one that does not."""

import numpy as np
import pytest

from mjsim.interface import Numbers, Observation, Odometry, WheelCommand
from mjsim.modules.covariances import Unfit
from mjsim.modules.foreign.module_answers import NO_STRUCT, command_of, estimate_of, sightings_of, torques_of

NUMBERS = Numbers(("lion", "owl"))
SEEN = Observation(time=2.5, dt=0.04, odometry=Odometry(0.0, 0.0, 0.0, covariance=np.eye(3)))
R = np.array([[[1.0, 2.0], [3.0, 4.0]], [[5.0, 6.0], [7.0, 8.0]], [[9.0, 10.0], [11.0, 12.0]]])
FITS = {"id": [1, 2, 0], "range": [1.5, 2.5, 3.5], "bearing": [0.1, 0.2, 0.3], "R": R}
OCTAVE = {name: np.moveaxis(np.array(value, dtype=float), 0, -1) for name, value in FITS.items()}
ONE_OCTAVE = {"id": 2.0, "range": [[1.5]], "bearing": np.array([[0.1]]), "R": R[0]}
"""Octave drops a last dimension of 1."""


@pytest.mark.parametrize(("answer", "last"), [(FITS, False), (OCTAVE, True)])
def test_sightings_are_taken_item_by_item(answer, last):
    found = sightings_of(answer, NUMBERS, SEEN, counts_last=last)
    assert [(each.name, each.range, each.bearing) for each in found] == [
        ("lion", 1.5, 0.1),
        ("owl", 2.5, 0.2),
        (None, 3.5, 0.3),
    ]
    np.testing.assert_array_equal([each.covariance for each in found], R)
    assert {each.stamp for each in found} == {2.5}


def test_one_sighting_of_octave_is_one():
    (found,) = sightings_of(ONE_OCTAVE, NUMBERS, SEEN, counts_last=True)
    assert (found.name, found.range) == ("owl", 1.5)
    np.testing.assert_array_equal(found.covariance, R[0])
    assert sightings_of({}, NUMBERS, SEEN, counts_last=True) == []


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"id": [1, 2]}, "returned z with 2 id, 3 range, 3 bearing, 3 R; it must have as many of each"),
        ({"id": [1, 2, 3]}, "returned the id 3; the catalogue has 2 beacons"),
        ({"id": [1, 2, -1]}, "returned the id -1; ids are whole numbers, 0 for none"),
        ({"id": [1, 2, 0.5]}, "returned the id 0.5; ids are whole numbers, 0 for none"),
        ({"R": R[:, :1]}, "returned z.R of 3 x 1 x 2; it must be n x 2 x 2"),
        ({"R": R[:2]}, "returned z with 3 id, 3 range, 3 bearing, 2 R; it must have as many of each"),
        ({"range": np.ones((3, 2))}, "returned z.range of 3 x 2; it must be n x 1"),
        ({"range": "complex"}, "returned z.range that is complex; it must hold real numbers"),
        ({"range": "a cell" + NO_STRUCT}, "returned z that is a cell; it must be a struct"),
        ({"range": ["1", "2", "3"]}, "returned z.range that holds text; write numbers without quotes"),
        ({"range": [[1], [2, 3]]}, "returned z.range that holds something other than numbers, or rows that differ"),
        ({"range": [10**400, 1, 2]}, "returned z.range that holds a number beyond 1e308"),
    ],
)
def test_sightings_that_do_not_fit_are_refused(change, message):
    with pytest.raises(Unfit) as refused:
        sightings_of({**FITS, **change}, NUMBERS, SEEN, counts_last=False)
    assert str(refused.value) == message


def test_torques_are_a_row_or_a_column():
    for tau in ([1.0, 2.0], [[1.0, 2.0]], [[1.0], [2.0]]):
        assert torques_of({"": tau}, counts_last=True) == [1.0, 2.0]
    assert torques_of({}, counts_last=True) == []
    with pytest.raises(Unfit, match="returned tau of 2 x 2; it must be 1 x n"):
        torques_of({"": np.eye(2)}, counts_last=True)


BELIEF = {
    "pose": [[1.0], [2.0], [0.5]],
    "covariance": np.eye(3),
    "landmarks": [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]],
    "landmark_covariance": R,
    "ids": [2, 0, 7],
    "innovations": [[0.1, 0.2]],
    "innovation_covariance": R[:1],
    "innovation_ids": [1],
}


def test_an_estimate_names_landmarks_by_beacon_by_number_or_by_place():
    found = estimate_of(BELIEF, NUMBERS, counts_last=False)
    assert (found.pose.x, found.pose.y, found.pose.heading) == (1.0, 2.0, 0.5)
    assert list(found.landmarks) == ["owl", 2, 7]
    np.testing.assert_array_equal(found.landmarks["owl"][0], [1.0, 2.0])
    np.testing.assert_array_equal(found.landmarks[7][1], R[2])
    ((name, nu, S),) = found.innovations
    assert name == "lion"
    np.testing.assert_array_equal(nu, [0.1, 0.2])
    np.testing.assert_array_equal(S, R[0])
    assert found.joint_covariance is None
    without = {name: value for name, value in BELIEF.items() if name not in ("ids", "innovation_ids")}
    found = estimate_of({**without, "joint_covariance": np.eye(9)}, NUMBERS, counts_last=False)
    assert list(found.landmarks) == [1, 2, 3]
    assert found.innovations[0][0] == 1
    np.testing.assert_array_equal(found.joint_covariance, np.eye(9))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"pose": None}, "returned no est.pose"),
        ({"pose": [1, 2]}, "returned est.pose of 2; it must be 3 numbers"),
        ({"pose": np.ones((1, 3, 1, 1))[..., [0, 0]]}, "returned est.pose of 1 x 3 x 1 x 2; it must be 3 numbers"),
        ({"landmarks": [[1, 2, 3]]}, "returned est.landmarks of 1 x 3; it must be n x 2"),
        ({"landmark_covariance": R[:2]}, "returned 3 landmarks with 2 covariances; each needs one"),
        ({"innovations": []}, "returned 0 innovations with 1 covariances; each needs one"),
        ({"ids": [1, 2]}, "returned 3 landmarks with 2 ids; each needs one, 0 for one without a name"),
        ({"ids": [2, 2, 1]}, "returned two landmarks called 'owl'; each id stands for one"),
        ({"ids": [0, 0, 1.5]}, "returned the id 1.5; ids are whole numbers, 0 for none"),
    ],
)
def test_an_estimate_that_does_not_fit_is_refused(change, message):
    with pytest.raises(Unfit) as refused:
        estimate_of({**BELIEF, **change}, NUMBERS, counts_last=False)
    assert str(refused.value) == message


def test_a_command_has_what_is_given_and_zero_else():
    found = command_of({"forward": [[0.5]], "turn": -1}, {}, counts_last=True)
    assert (found.forward, found.left, found.turn, found.messages, dict(found.joints)) == (0.5, 0.0, -1.0, (), {})
    assert command_of({"wheels": [[1.0], [2.0]]}, {}, counts_last=True) == WheelCommand((1.0, 2.0))
    goal = {"q": [[1.0, 2.0]], "qd": [], "qdd": None, "tau": [3.0, 4.0]}
    found = command_of({"joints": {"arm_1": goal}}, {"arm_1": "arm-1"}, counts_last=True).joints["arm-1"]
    assert (found.positions, found.velocities, found.accelerations) == ((1.0, 2.0), None, None)
    assert found.torques == (3.0, 4.0)


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        ({}, "returned a cmd without forward, left, turn, wheels or joints; it must have one of them"),
        ({"forward": [1, 2]}, "returned cmd.forward of 2; it must be one number"),
        ({"joints": 1}, "returned cmd.joints that is not a struct of structs; write cmd.joints.ARM.q = ..."),
        ({"joints": {"arm": 1}}, "returned cmd.joints that is not a struct of structs; write cmd.joints.ARM.q = ..."),
        ({"joints": {"arm": {"qd": [1]}}}, "returned no cmd.joints.arm.q"),
        ({"joints": {"arn": {"q": [1]}}}, "returned cmd.joints.arn; did you mean 'arm'?"),
    ],
)
def test_a_command_that_does_not_fit_is_refused(answer, message):
    with pytest.raises(Unfit) as refused:
        command_of(answer, {"arm": "arm"}, counts_last=False)
    assert str(refused.value) == message
