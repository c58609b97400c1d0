"""What modules return is checked against eigenvalues that are computed, and what is well meant passes."""

import copy
import pickle
from collections import deque
from dataclasses import dataclass, fields, replace

import numpy as np
import pytest

import mjsim
from mjsim.interface import Numbers, Observation, WheelTicks, observation_tree
from mjsim.modules import checked_command, checked_estimate, checked_sightings, sealed_observation
from mjsim.modules.covariances import Unfit, covariance, is_plainly_good
from mjsim.modules.given import _READINGS

ORIGIN, EYE = mjsim.Pose(0.0, 0.0, 0.0), np.eye(3)
ROOM = "mjsim: 1\nrobots: [{name: scout, at: [0, 0]}]\n"


@dataclass(frozen=True, slots=True, eq=False)
class WithReport(mjsim.Estimate):
    """An estimate that tells its navigator more."""

    report: str = ""


@pytest.fixture(scope="module")
def robot():
    with mjsim.Simulation(mjsim.parse_world(ROOM)) as sim:
        yield sim.robots["scout"]


@pytest.mark.slow
@pytest.mark.parametrize("size", [2, 3])
def test_the_closed_form_agrees_with_eigenvalues(size):
    rng = np.random.default_rng(size)
    signs = set()
    for _ in range(3000):
        eigenvalues = rng.uniform(-0.05, 1.0, size)
        axes, _ = np.linalg.qr(rng.normal(size=(size, size)))
        P = axes * eigenvalues @ axes.T
        # Rows of different units: metres, centimetres, radians.
        units = 10.0 ** rng.uniform(-3.0, 3.0, size)
        P = 0.5 * (P + P.T) * units[:, None] * units
        good = bool(np.linalg.eigvalsh(P / units[:, None] / units).min() >= 0.0)
        signs.add(good)
        assert is_plainly_good(P, size) is good
    assert signs == {True, False}


@pytest.mark.parametrize("size", [2, 3, 9])
def test_a_covariance_that_became_singular_by_rounding_passes(size):
    rng = np.random.default_rng(size)
    for _ in range(200):
        column = rng.normal(size=(size, 1)) * 10.0 ** rng.uniform(-3.0, 3.0, (size, 1))
        P = column @ column.T
        assert np.shape(covariance("P", P, size)) == (size, size)
    covariance("P", np.zeros((size, size)), size)


@pytest.mark.parametrize("size", [2, 3, 9])
def test_the_worst_eigenvalue_is_named_as_numpy_computes_it(size):
    rng = np.random.default_rng(size)
    for _ in range(100):
        A = rng.normal(size=(size, size))
        P = 0.5 * (A + A.T)
        worst = np.linalg.eigvalsh(P)[0]
        if worst > -1e-3:
            continue
        with pytest.raises(Unfit, match=r"returned P with the eigenvalue .*; a covariance has none below 0") as caught:
            covariance("P", P, size)
        assert float(str(caught.value).split()[5].rstrip(";")) == pytest.approx(worst, rel=1e-4)


def test_what_an_exact_measurement_leaves_of_a_covariance_passes():
    rng = np.random.default_rng(0)
    for _ in range(200):
        A = rng.normal(size=(3, 3))
        P = A @ A.T + EYE
        P = P - P @ np.linalg.inv(P) @ P
        covariance("P", 0.5 * (P + P.T), 3)


def test_a_negative_variance_hides_behind_no_other_unit():
    # 100 km^2 beside a heading whose variance is negative, but for 1e-16 of it.
    with pytest.raises(Unfit, match="eigenvalue -1e-08"):
        covariance("P", np.diag([1e8, 1e8, -1e-8]), 3)


@pytest.mark.parametrize(
    "P",
    [
        np.eye(3, dtype=np.float32),
        np.eye(3, dtype=int),
        np.eye(3).tolist(),
        np.array([[1.0, 0.5, 0.1], [0.5 + 1e-9, 1.0, 0.2], [0.1, 0.2, 1.0]]),
        np.array([[1.0, 0.1, 0.2], [0.1 + 1e-5, 1.0, 0.0], [0.2, 0.0, 1.0]], dtype=np.float32),
        np.diag([1e-300, 1e300, 1.0]),
        np.zeros((3, 3)),
        np.broadcast_to(np.zeros(3), (3, 3)),  # read-only
        np.asfortranarray(np.diag([1.0, 2.0, 3.0])),
    ],
)
def test_a_covariance_in_other_precision_or_with_rounding_is_an_array_of_doubles_then(P):
    checked = checked_estimate(mjsim.Estimate(ORIGIN, P)).covariance
    assert checked.dtype == np.float64
    np.testing.assert_array_equal(checked, P)


def test_masked_numbers_are_refused_and_a_mask_without_any_is_not():
    masked = np.ma.masked_less(np.diag([1.0, 2.0, 3.0]), 0.0)
    assert not checked_estimate(mjsim.Estimate(ORIGIN, masked)).covariance[0, 1]
    masked[0, 0] = np.ma.masked
    with pytest.raises(Unfit, match=r"^returned the covariance of the pose with masked numbers; fill them$"):
        checked_estimate(mjsim.Estimate(ORIGIN, masked))


def test_an_estimate_that_is_right_stays_the_same_object():
    belief = WithReport(
        ORIGIN, EYE, {"lion": (np.zeros(2), np.eye(2))}, (("lion", np.zeros(2), np.eye(2)),), report="r"
    )
    assert checked_estimate(belief) is belief


def test_a_subclass_of_estimate_keeps_its_own_fields_when_a_number_is_converted():
    checked = checked_estimate(WithReport(mjsim.Pose(np.float32(1.5), 2, np.array(0.25)), EYE, report="r"))
    assert (type(checked), checked.report) == (WithReport, "r")
    assert checked.pose == mjsim.Pose(1.5, 2.0, 0.25)
    assert type(checked.pose.x) is type(checked.pose.y) is type(checked.pose.heading) is float


def test_landmarks_and_innovations_as_lists_become_arrays():
    belief = mjsim.Estimate(
        ORIGIN, EYE, {4: [[1, 2], [[1, 0], [0, 1]]]}, [["lion", [0, 0], np.eye(2, dtype=np.float32)]]
    )
    checked = checked_estimate(belief)
    mean, P = checked.landmarks[4]
    assert (mean.tolist(), P.dtype) == ([1.0, 2.0], np.float64)
    ((name, nu, S),) = checked.innovations
    assert (name, nu.dtype, S.dtype) == ("lion", np.float64, np.float64)


def test_the_joint_covariance_is_looked_at_whole_or_by_its_diagonal():
    P = np.eye(7)
    P[3, 4] = P[4, 3] = 2.0
    belief = mjsim.Estimate(ORIGIN, EYE, {k: (np.zeros(2), np.eye(2)) for k in range(2)}, (), P)
    assert checked_estimate(belief, whole=False) is belief
    with pytest.raises(Unfit, match="joint covariance with the eigenvalue -1;"):
        checked_estimate(belief)
    for bad in (np.nan, -1.0):
        Q = np.eye(7)
        Q[6, 6] = bad
        with pytest.raises(Unfit, match="joint covariance"):
            checked_estimate(replace(belief, joint_covariance=Q), whole=False)


def test_numbers_of_commands_become_floats(robot):
    command = checked_command(mjsim.Command(np.float32(0.5), 0, np.array(1), [np.arange(2)]), robot)
    assert (command.forward, command.left, command.turn) == (0.5, 0.0, 1.0)
    assert {type(value) for value in (command.forward, command.left, command.turn)} == {float}
    assert checked_command(mjsim.WheelCommand(np.array([1, 2])), robot) == mjsim.WheelCommand((1.0, 2.0))
    plain = mjsim.Command(0.1, 0.0, 0.2)
    assert checked_command(plain, robot) is plain


def test_sightings_come_in_any_sequence():
    seen = mjsim.Sighting(0.0, "lion", 1.0, 0.5, np.eye(2))
    (same,) = checked_sightings(deque([seen]))
    assert same is seen
    (other,) = checked_sightings((replace(seen, range=np.float32(2.0), covariance=[[1, 0], [0, 1]]),))
    assert type(other.range) is float
    assert other.covariance.dtype == np.float64
    assert checked_sightings([]) == []


def test_a_sealed_observation_is_read_only_and_a_copy_of_it_is_not():
    odometry = mjsim.Odometry(0.0, 0.0, 0.0, np.eye(3))
    scan = mjsim.Scan(0.0, np.ones(4), 0.0, 0.1, 0.1, 8.0)
    seen = sealed_observation(mjsim.Observation(0.0, 0.04, odometry, scans={"scan": scan}))
    for array in (seen.odometry.covariance, seen.scans["scan"].ranges, seen.proximity):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    changes = [
        lambda scans: scans.update(x=1),
        lambda scans: scans.pop("scan"),
        lambda scans: scans.__setitem__("x", 1),
        lambda scans: scans.__delitem__("scan"),
        lambda scans: scans.setdefault("x", 1),
        lambda scans: scans.popitem(),
        lambda scans: scans.__ior__({"x": 1}),
    ]
    for change in changes:
        with pytest.raises(TypeError, match="copy them first"):
            change(seen.scans)
    assert list(seen.scans) == ["scan"]
    with pytest.raises(TypeError, match="copy them first"):
        seen.ranges["x"] = 1  # Nothing is due: it is as read-only.
    assert set(_READINGS) >= {"cameras", "scans", "ranges", "encoders"}
    for mine in (copy.deepcopy(seen), pickle.loads(pickle.dumps(seen))):
        mine.scans["other"] = mine.ranges["x"] = mine.scans["scan"]
        mine.scans["scan"].ranges[0] = 2.0
        mine.odometry.covariance[0, 0] = 2.0
    assert seen.scans["scan"].ranges[0] == 1.0


def test_modules_in_other_languages_are_told_every_field_of_an_observation():
    seen = Observation(
        time=0.0,
        dt=0.04,
        odometry=mjsim.Odometry(0.0, 0.0, 0.0, np.zeros((3, 3))),
        encoders={"wheels": WheelTicks(0.04, (3, -4), 500, 16)},
    )
    told = observation_tree(seen, Numbers(), pictures=True)
    assert {part.name for part in fields(Observation)} - set(told) == {"sightings"}  # they are z, id, R and stamp
    counts = told["encoders"]["wheels"]["counts"]
    assert (counts.items.tolist(), told["encoders"]["wheels"]["bits"]) == ([3.0, -4.0], 16)
