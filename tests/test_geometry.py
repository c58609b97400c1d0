"""Poses, angles and tracks, compared with complex numbers and with scipy's rotations."""

import itertools
import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp
from scipy.stats import chi2

from mjsim.geometry import (
    Pose,
    Pose3,
    align_rigid,
    ellipse_magnification,
    ellipse_points,
    headings,
    nearest_moments,
    places_at,
    poses_at,
    roll_and_pitch,
    wrap_angle,
    wrap_angles,
)

RNG = np.random.default_rng(11)
POSES = [Pose(*values) for values in RNG.uniform(-3.0, 3.0, (20, 3)).tolist()]
ROTATIONS = Rotation.random(30, rng=np.random.default_rng(12))


def test_an_angle_is_wrapped_by_whole_turns_to_the_half_open_interval():
    for angle in (0.0, 1.0, -1.0, 3.2, -3.2, 7.0, 100.0, -100.0):
        wrapped = wrap_angle(angle)
        assert -math.pi <= wrapped < math.pi
        assert np.exp(1j * wrapped) == pytest.approx(np.exp(1j * angle))
        assert wrap_angles([[angle]])[0, 0] == wrapped
    assert wrap_angle(math.pi) == wrap_angle(-math.pi) == -math.pi


def test_poses_are_turns_and_shifts_of_complex_numbers():
    points = RNG.uniform(-1.0, 1.0, (5, 2))
    for outer, inner in itertools.pairwise(POSES):
        moved = outer.x + 1j * outer.y + np.exp(1j * outer.heading) * (points @ [1.0, 1j])
        np.testing.assert_allclose(outer.transform(points) @ [1.0, 1j], moved)
        both = outer @ inner
        np.testing.assert_allclose(both.matrix(), outer.matrix() @ inner.matrix(), atol=1e-12)
        np.testing.assert_allclose(outer.inverse().matrix(), np.linalg.inv(outer.matrix()), atol=1e-12)
        np.testing.assert_allclose(outer.transform(points[0]), (outer.matrix() @ [*points[0], 1.0])[:2])
        assert -math.pi <= both.heading < math.pi
        assert Pose.from_array(outer.as_array()) == outer


def matrix_of(rotation):
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation.as_matrix(), [1.0, -2.0, 3.0]
    return matrix


@pytest.mark.parametrize("rotation", [*ROTATIONS, *Rotation.from_euler("xyz", np.eye(3) * np.pi)], ids=range(33))
def test_a_pose_in_space_comes_from_its_matrix_and_gives_it_back(rotation):
    pose = Pose3.from_matrix(matrix_of(rotation))
    np.testing.assert_allclose(pose.matrix(), matrix_of(rotation), atol=1e-12)
    assert abs(np.dot(pose.as_array()[3:], rotation.as_quat())) == pytest.approx(1.0)
    np.testing.assert_array_equal(pose.as_array()[:3], [1.0, -2.0, 3.0])


def test_heading_and_lean_are_those_of_the_axes_of_a_body():
    for rotation in ROTATIONS:
        x, z = rotation.apply([1.0, 0.0, 0.0]), rotation.apply([0.0, 0.0, 1.0])
        pose = Pose3.from_matrix(matrix_of(rotation))
        assert pose.planar() == Pose(1.0, -2.0, pytest.approx(math.atan2(x[1], x[0])))
        assert pose.pitch() == pytest.approx(math.atan2(rotation.inv().apply([0.0, 0.0, 1.0])[0] * -1.0, z[2]))
        roll, pitch, _ = rotation.as_euler("xyz")
        np.testing.assert_allclose(roll_and_pitch(rotation.as_quat()), [roll, pitch], atol=1e-9)
    leaning = Pose3.from_matrix(matrix_of(Rotation.from_euler("y", 0.3)))
    assert leaning.pitch() == pytest.approx(0.3), "its nose is down"
    assert roll_and_pitch(ROTATIONS.as_quat().reshape(5, 6, 4)).shape == (5, 6, 2)


def test_a_body_that_stands_upright_has_its_heading_alone():
    for pose in POSES:
        upright = Pose3.from_planar(pose)
        np.testing.assert_allclose(
            upright.matrix()[:3, :3], Rotation.from_euler("z", pose.heading).as_matrix(), atol=1e-12
        )
        assert upright.as_array()[:3].tolist() == [pose.x, pose.y, 0.0]


def test_an_ellipse_is_where_the_mahalanobis_distance_has_its_quantile():
    for probability in (0.5, 0.95):
        roots = RNG.uniform(-1.0, 1.0, (4, 2, 2))
        P, mean = roots @ np.swapaxes(roots, -1, -2), RNG.uniform(-1.0, 1.0, (4, 2))
        points = ellipse_points(mean, P, probability=probability, count=12) - mean[:, None]
        distance = np.einsum("nki,nij,nkj->nk", points, np.linalg.inv(P), points)
        np.testing.assert_allclose(distance, chi2.ppf(probability, 2))
        assert points.shape == (4, 12, 2)
        turns = np.diff(np.unwrap(np.angle(points[0] @ [1.0, 1j])))
        assert abs(turns.sum()) > 1.5 * math.pi, "all around"
    np.testing.assert_array_equal(ellipse_points([1.0, 2.0], np.zeros((2, 2)), count=3), [[1.0, 2.0]] * 3)


def test_ellipses_grow_by_round_factors_and_stay_in_their_circle():
    # 95 % of a Gaussian of 1 cm lie within 2.448 cm.
    for radius, factor in ((0.02, 1), (0.0244, 1), (0.0491, 2), (0.2, 5), (0.25, 10), (9.0, 100)):
        assert ellipse_magnification(np.diag([1e-6, 1e-4]), radius) == factor
    assert ellipse_magnification(np.zeros((2, 2)), 0.1) == 100


def test_points_that_were_moved_are_aligned_back_and_noise_is_averaged():
    source = RNG.uniform(-1.0, 1.0, (20, 2))
    for pose in POSES:
        found = align_rigid(source, pose.transform(source))
        np.testing.assert_allclose(found.matrix(), pose.matrix(), atol=1e-9)
    target = POSES[0].transform(source) + RNG.normal(0.0, 0.1, (20, 2))
    found = align_rigid(source, target)
    least = np.sum((found.transform(source) - target) ** 2)
    for step in np.vstack([np.eye(3), -np.eye(3)]) * 1e-3:
        other = Pose.from_array(found.as_array() + step)
        assert np.sum((other.transform(source) - target) ** 2) > least


@pytest.mark.parametrize(
    ("source", "target"),
    [(np.zeros((1, 2)), np.zeros((1, 2))), (np.zeros((3, 2)), np.zeros((4, 2))), (np.zeros((3, 3)), np.zeros((3, 3)))],
)
def test_shapes_that_cannot_be_aligned_are_refused(source, target):
    with pytest.raises(ValueError, match=r"^shapes are .*; both must be \(n, 2\) with n of at least 2$"):
        align_rigid(source, target)
    assert align_rigid(np.eye(2), np.eye(2)) == Pose(0.0, 0.0, 0.0)


def test_moments_of_inertia_that_no_body_has_are_moved_the_least_way():
    np.testing.assert_array_equal(nearest_moments(np.array([1.0, 2.0, 3.0])), [1.0, 2.0, 3.0])
    moved = nearest_moments(np.array([1.0, 2.0, 6.0]))
    # The normal of the plane m0 + m1 = m2 is (1, 1, -1).
    np.testing.assert_allclose(moved, [2.0, 3.0, 5.0])
    assert moved[0] + moved[1] == pytest.approx(moved[2])


TIMES = np.array([0.0, 1.0, 1.0, 3.0, 10.0])


def test_places_between_rows_are_on_the_line_and_turn_the_short_way():
    track = np.column_stack([TIMES, [0, 1, 2, 4, 5], [0, 2, 2, 6, 6], [3.0, -3.0, -3.0, 1.0, 1.0]])
    found = places_at(np.array([-0.1, 0.0, 0.25, 1.0, 2.0, 3.0, 5.0, 10.0, 10.1]), track, gap=2.0)
    turn = 2 * math.pi - 6.0
    np.testing.assert_allclose(found[1], [0.0, 0.0, 3.0])
    np.testing.assert_allclose(found[2], [0.25, 0.5, wrap_angle(3.0 + 0.25 * turn)])
    np.testing.assert_allclose(found[3], [2.0, 2.0, -3.0], err_msg="of rows with equal times the last counts")
    # From -3 to 1 the short way is 2 pi - 4 backwards.
    np.testing.assert_allclose(found[4], [3.0, 4.0, wrap_angle(-3.0 - (2 * math.pi - 4.0) / 2)])
    np.testing.assert_array_equal(
        np.isnan(found).all(axis=1), [True, False, False, False, False, True, True, True, True]
    )
    np.testing.assert_allclose(places_at(np.array([3.0, 10.0]), track, gap=7.0)[:, 0], [4.0, 5.0])


def test_poses_in_space_between_rows_turn_along_the_shorter_rotation():
    quaternions = Rotation.from_euler("xyz", [[0.1, 0.2, 0.3], [0.2, 0.1, 0.5], [0.4, 0.0, 0.4]]).as_quat()
    signed = quaternions * np.array([[1.0], [-1.0], [1.0]])
    times, places = np.array([0.0, 1.0, 2.0]), np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0], [1.0, 2.0, 4.0]])
    track = np.column_stack([times, places, signed])
    asked = np.array([0.0, 0.5, 1.0, 1.25, 2.0, 2.1])
    found = poses_at(asked, track, gap=1.0)
    slerp = Slerp(times, Rotation.from_quat(quaternions))(asked[:-1])
    # The chord and the arc of these small rotations differ by less than 1e-4.
    apart = (slerp.inv() * Rotation.from_quat(found[:-1, 3:])).magnitude()
    assert apart.max() < 1e-3
    np.testing.assert_allclose(np.linalg.norm(found[:-1, 3:], axis=1), 1.0)
    np.testing.assert_allclose(found[1, :3], [0.5, 1.0, 1.5])
    np.testing.assert_allclose(found[3, :3], [1.0, 2.0, 3.25])
    assert np.isnan(found[-1]).all()
    assert np.isnan(poses_at(np.array([0.5]), track, gap=0.9)).all()


def test_a_row_beside_one_that_is_unknown_is_known_at_its_own_time():
    track = np.array(
        [[0.0, 1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0], [1.0, *[np.nan] * 7], [2.0, 4.0, 5.0, 6.0, 0, 0, 0, 1.0]]
    )
    found = poses_at(np.array([0.0, 0.5, 2.0]), track, gap=1.0)
    np.testing.assert_array_equal(found[[0, 2], :3], [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
    assert np.isnan(found[1]).any()


def test_headings_are_those_of_planar_poses_for_quaternions_of_any_length():
    rng = np.random.default_rng(5)
    quaternions = rng.normal(size=(50, 4))
    unit = quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)
    expected = [Pose3(0.0, 0.0, 0.0, *each).planar().heading for each in unit.tolist()]
    np.testing.assert_allclose(headings(quaternions), expected, atol=1e-12)
