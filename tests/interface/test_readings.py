"""Readings and what follows from them: by finite differences, projections and closed forms."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mjsim.interface import CLOUD_FIELDS, Detection, Intrinsics, PointCloud, Scan, WheelTicks, sightings_from


@pytest.mark.parametrize("seed", range(4))
def test_a_detection_in_a_camera_is_a_sighting_from_the_robots_origin_with_its_covariance(seed):
    rng = np.random.default_rng(seed)
    camera = np.eye(4)
    camera[:3, :3] = Rotation.from_euler("xyz", rng.uniform(-math.pi, math.pi, 3)).as_matrix()
    camera[:3, 3] = rng.uniform(-0.5, 0.5, 3)
    position, A = rng.uniform(1.0, 3.0, 3), rng.normal(0.0, 0.1, (3, 3))
    (seen,) = sightings_from([Detection("one", position, A @ A.T, np.zeros((4, 2)))], camera, stamp=1.5)

    def polar(point: np.ndarray) -> np.ndarray:
        x, y, _, _ = camera @ [*point, 1.0]
        return np.array([math.hypot(x, y), math.atan2(y, x)])

    assert (seen.stamp, seen.name) == (1.5, "one")
    np.testing.assert_allclose([seen.range, seen.bearing], polar(position))
    step = 1e-6
    J = np.stack([(polar(position + d) - polar(position - d)) / (2 * step) for d in step * np.eye(3)], axis=-1)
    np.testing.assert_allclose(seen.covariance, J @ A @ A.T @ J.T, atol=1e-9)
    assert seen.corners.shape == (4, 2)


def test_beams_of_a_scan_are_from_right_to_left_and_the_last_is_at_its_stamp():
    ranges = np.array([1.0, np.inf, 2.0, -np.inf, 3.0])
    scan = Scan(2.0, ranges, -0.5, 0.25, 0.1, 9.0, time_increment=0.01)
    assert scan.angles().tolist() == [-0.5, -0.25, 0.0, 0.25, 0.5]
    np.testing.assert_allclose(scan.times(), [-0.04, -0.03, -0.02, -0.01, 0.0])
    expected = [(math.cos(-0.5), math.sin(-0.5)), (2.0, 0.0), (3 * math.cos(0.5), 3 * math.sin(0.5))]
    np.testing.assert_allclose(scan.points(), expected)
    assert Scan(2.0, ranges, -0.5, 0.25, 0.1, 9.0).times().tolist() == [0.0] * 5


def test_rows_of_a_cloud_have_each_number_under_its_name():
    points = np.arange(6, dtype=np.float32).reshape(2, 3)
    times, intensities, rings = (np.array(each, dtype=np.float32) for each in ([-0.1, 0.0], [0.3, 0.4], [7, 65535]))
    rows = PointCloud(1.0, points, times, intensities, rings.astype(np.uint16)).rows()
    assert rows.dtype.names == tuple(CLOUD_FIELDS)
    assert [*map(tuple, rows.tolist())] == [
        (0.0, 1.0, 2.0, pytest.approx(0.3), pytest.approx(-0.1), 7),
        (3.0, 4.0, 5.0, pytest.approx(0.4), 0.0, 65535),
    ]


def test_counts_wrap_around_and_a_turn_has_as_many_as_the_resolution():
    before, after = (WheelTicks(0.0, counts, 500, 8) for counts in ((120, -120, 3), (-120, 120, -2)))
    assert after.since(before) == (16, -16, -5)
    np.testing.assert_allclose(after.rotations(before), np.array([16, -16, -5]) * math.tau / 500)


@pytest.mark.parametrize(
    ("lens", "distortion", "count", "is_rational"),
    [
        ("pinhole", (), 5, False),
        ("brown", (0.1, 0.2), 5, False),
        ("brown", (0.1, 0.2, 0.3, 0.4, 0.5, 0.0, 0.0, 0.0), 5, False),
        ("brown", (0.1, 0.2, 0.3, 0.4, 0.5, 0.6), 8, True),
        ("fisheye", (0.1, 0.2, 0.3, 0.4), 4, False),
    ],
)
def test_distortion_is_stored_as_four_five_or_eight_numbers(lens, distortion, count, is_rational):
    camera = Intrinsics(640, 480, 500.0, 510.0, 320.5, 240.5, lens, distortion)
    assert camera.is_rational() == is_rational
    assert camera.coefficients() == [*distortion, *[0.0] * 8][:count]
    np.testing.assert_array_equal(camera.matrix() @ [1.0, 2.0, 1.0], [820.5, 1260.5, 1.0])
