"""Every derivative that the algorithms write down is what central differences give; those of EKF-SLAM are elsewhere."""

import dataclasses

import numpy as np
import pytest

from mjsim.algorithms.beacon_vision.picture_alignment import corners_by_correction
from mjsim.algorithms.beacon_vision.picture_templates import apply_homography, make_templates, warp_slopes
from mjsim.algorithms.beacon_vision.planar_pose import corner_error, picture_corners, rotation_of
from mjsim.algorithms.estimation.ekf_models import landmark_from
from mjsim.algorithms.estimation.pose_graph import carried, step_between, step_errors
from mjsim.algorithms.fastslam import FastSlam, particle_innovations
from mjsim.algorithms.filterpy_slam import FilterpySlam
from mjsim.algorithms.scans.scan_matching import misses
from mjsim.algorithms.scans.scan_walls import rotation
from mjsim.geometry import Pose
from mjsim.interface import Intrinsics, Observation, Odometry, Sighting
from tests.robots import pioneer

STEP = 1e-6


def slopes(function, at):
    """Return the derivative of a function of a vector by central differences, the vector's axis last."""
    steps = np.eye(len(at)) * STEP
    return np.stack([(function(at + step) - function(at - step)) / (2 * STEP) for step in steps], axis=-1)


def test_of_the_distance_of_scan_points_from_lines():
    rng = np.random.default_rng(0)
    points, places, angles = rng.uniform(-3, 3, (20, 2)), rng.uniform(-3, 3, (20, 2)), rng.uniform(-3, 3, 20)
    normals = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    away = np.sum(normals * places, axis=1)

    def found(pose):
        arm = (rotation(pose[2]) @ points.T)[:, None]
        return misses(arm, arm + pose[:2, None, None], np.array([*normals.T, away, away])[:, None])[:, 0]

    for pose in rng.uniform(-2, 2, (10, 3)):
        np.testing.assert_allclose(found(pose)[:3].T, slopes(lambda p: found(p)[3], pose), atol=1e-8)


def test_of_the_error_of_a_step_in_a_graph_of_poses():
    rng = np.random.default_rng(1)
    for one, other in rng.uniform(-1.5, 1.5, (10, 2, 3)):
        step = rng.uniform(-0.1, 0.1, 3)
        _, A, B = step_errors(one[None], other[None], step[None])
        for J, moved in (
            (A, lambda p, other=other, step=step: step_errors(p[None], other[None], step[None])[0][0]),
            (B, lambda p, one=one, step=step: step_errors(one[None], p[None], step[None])[0][0]),
        ):
            np.testing.assert_allclose(J[0], slopes(moved, one if J is A else other), atol=1e-8)


def test_of_a_pose_by_the_first_one_of_its_graph():
    rng = np.random.default_rng(8)
    for first, pose in rng.uniform(-1.5, 1.5, (10, 2, 3)):
        step = step_between(first, pose)
        J = slopes(lambda f, step=step: (Pose(*f) @ Pose(*step)).as_array(), first)
        np.testing.assert_allclose(carried(pose, first), J, atol=1e-8)


def test_of_a_new_beacon_in_the_filter_of_filterpy():
    prior, spread = np.array([1.0, 2.0, 0.7]), np.diag([0.1, 0.2, 0.05]) ** 2
    look = Sighting(0.0, "post", 2.0, 0.4, np.diag([0.05, 0.02]) ** 2)
    estimator = FilterpySlam()
    robot = dataclasses.replace(pioneer(), prior=Pose(*prior), prior_covariance=spread)
    estimator.start(robot, {}, np.random.default_rng(0))
    still = Odometry(0.0, 0.0, 0.0, np.zeros((3, 3)))
    _, covariance = estimator.update(Observation(0.0, 0.1, still, sightings=(look,))).landmarks["post"]
    z = np.array([look.range, look.bearing])
    J = slopes(lambda v: landmark_from(v[:3], v[3:])[0], np.append(prior, z))
    errors = np.block([[spread, np.zeros((3, 2))], [np.zeros((2, 3)), look.covariance]])
    np.testing.assert_allclose(covariance, J @ errors @ J.T, rtol=1e-6)


def test_of_a_particles_innovation_and_of_its_new_landmark():
    rng = np.random.default_rng(2)
    look = Sighting(0.0, "post", 2.0, 0.4, np.diag([0.05, 0.02]) ** 2)
    for pose, place in zip(rng.uniform(-1, 1, (10, 3)), rng.uniform(2, 3, (10, 2)), strict=True):
        # nu is what is seen less what is expected, H the slope of the latter.
        _, H, H_landmark = particle_innovations(pose[None], place[None], look)
        by_pose = slopes(lambda p, place=place: particle_innovations(p[None], place[None], look)[0][0], pose)
        by_place = slopes(lambda p, pose=pose: particle_innovations(pose[None], p[None], look)[0][0], place)
        np.testing.assert_allclose(H[0], -by_pose, atol=1e-8)
        np.testing.assert_allclose(H_landmark[0], -by_place, atol=1e-8)
    estimator = FastSlam(particles=2)
    estimator.start(dataclasses.replace(pioneer(), prior=Pose(1, 2, 0.7)), {}, rng)
    still = Odometry(0.0, 0.0, 0.0, np.zeros((3, 3)))
    _, covariance = estimator.update(Observation(0.0, 0.1, still, sightings=(look,))).landmarks["post"]
    J = slopes(lambda z: landmark_from(np.array([1, 2, 0.7]), z)[0], np.array([look.range, look.bearing]))
    np.testing.assert_allclose(covariance, J @ look.covariance @ J.T, rtol=1e-3)


def test_of_a_pictures_corners_by_its_pose():
    rng, lens = np.random.default_rng(3), Intrinsics(640, 480, 554.0, 556.0, 319.5, 239.5)
    points, corners = picture_corners(0.6, 0.8), np.zeros((4, 2))
    for _ in range(10):
        R, t = rotation_of(rng.uniform(-0.6, 0.6, 3)), np.array([*rng.uniform(-0.5, 0.5, 2), rng.uniform(2, 4)])
        _, H = corner_error(points @ R.T, t, corners, lens)

        def predicted(v, R=R, t=t):
            return -corner_error(points @ (rotation_of(v[3:]) @ R).T, t + v[:3], corners, lens)[0]

        # Corners lie hundreds of pixels away: rounding alone makes 1e-7 of them.
        np.testing.assert_allclose(H, slopes(predicted, np.zeros(6)), atol=1e-4)


def correction(p):
    """Return the homography that eight numbers stand for."""
    return np.append(p, 0.0).reshape(3, 3) + np.eye(3)


def test_of_a_pictures_corners_by_the_correction_of_its_homography():
    rng = np.random.default_rng(4)
    template = make_templates(rng.integers(0, 255, (80, 60)).astype(np.uint8), 0.6)[0]
    homography = np.array([[300.0, 20.0, 320.0], [-10.0, 310.0, 240.0], [0.1, 0.05, 1.0]])
    unit = np.diag([template.unit, template.unit, 1.0])

    def corners(p):
        moved = homography @ np.linalg.inv(unit) @ np.linalg.inv(correction(p)) @ unit
        return apply_homography(moved, template.corners).ravel()

    np.testing.assert_allclose(corners_by_correction(template, homography), slopes(corners, np.zeros(8)), atol=1e-4)


def test_of_a_smooth_picture_by_its_homography():
    columns, rows, step = 64, 48, 2.0 / 64
    x, y = np.meshgrid((np.arange(columns) - 31.5) * step, (np.arange(rows) - 23.5) * step)
    places = np.stack([x.ravel(), y.ravel()], axis=-1)

    def picture(p):
        u, v = apply_homography(correction(p), places).T
        return 100.0 + 40.0 * np.sin(2.0 * u + 1.0) * np.cos(1.5 * v)

    drawn = picture(np.zeros(8)).reshape(rows, columns).astype(np.float32)
    found = warp_slopes(drawn, (x[0, 0], y[0, 0]), (step, step)).reshape(rows, columns, 12)[1:-1, 1:-1, :8]
    expected = slopes(picture, np.zeros(8)).reshape(rows, columns, 8)[1:-1, 1:-1]
    # Neighbours stand for the slope: a thousandth of it for a picture as smooth as this.
    assert np.abs(found - expected).max() < 3e-3 * np.abs(expected).max()


@pytest.mark.parametrize("angle", [0.0, 1e-10, 0.4, 3.0])
def test_a_rotation_vector_is_the_rotation_about_it(angle):
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    R = rotation_of(angle * axis)
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(R @ axis, axis, atol=1e-12)
    assert np.trace(R) == pytest.approx(1.0 + 2.0 * np.cos(angle))
