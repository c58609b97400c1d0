"""Noise of ranges as a scan shows it by itself, and what is made of it."""

import numpy as np
import pytest

from mjsim.algorithms.scans.scan_matching import WallField, align
from mjsim.algorithms.scans.scan_noise import range_noise, smoothed
from mjsim.algorithms.scans.scan_walls import surface_of
from mjsim.geometry import wrap_angle
from mjsim.interface import Scan

WIDTH, LENGTH = 5.0, 7.0


def scan_of_a_room(*, beams=360, noise=0.0, seed=0, pose=(2.0, 2.0, 0.3)):
    """Return what a lidar all around sees of a room without furniture, by the distances of its four walls."""
    x, y, heading = pose
    increment = 2.0 * np.pi / beams
    angles = -np.pi + increment * np.arange(beams)
    c, s = np.cos(angles + heading), np.sin(angles + heading)
    with np.errstate(divide="ignore"):
        along = np.where(c > 0.0, (LENGTH - x) / c, -x / c)
        across = np.where(s > 0.0, (WIDTH - y) / s, -y / s)
    ranges = np.minimum(along, across) + np.random.default_rng(seed).normal(0.0, noise, beams)
    return Scan(1.0, ranges, -np.pi, increment, 0.05, 30.0)


@pytest.mark.parametrize("beams", [60, 360, 1440])
def test_a_scan_of_straight_walls_without_noise_shows_none(beams):
    assert range_noise(scan_of_a_room(beams=beams)) < 1e-9


@pytest.mark.parametrize("beams", [120, 360, 1440])
@pytest.mark.parametrize("noise", [0.01, 0.05])
def test_a_scan_shows_by_how_much_its_ranges_err(beams, noise):
    shown = np.mean([range_noise(scan_of_a_room(beams=beams, noise=noise, seed=seed)) for seed in range(8)])
    assert shown == pytest.approx(noise, rel=0.2)


def test_a_scan_that_meets_little_shows_no_noise():
    scan = scan_of_a_room(noise=0.05)
    for nothing in (np.inf, -np.inf, np.nan):
        scan.ranges[15:] = nothing
        assert range_noise(scan) == 0.0
        np.testing.assert_array_equal(smoothed(scan, 0.05).ranges[15:], nothing)
    for few in (0, 1, 2):
        assert range_noise(Scan(1.0, np.ones(few), 0.0, 0.0, 0.05, 30.0)) == 0.0
        assert len(smoothed(Scan(1.0, np.ones(few), 0.0, 0.0, 0.05, 30.0), 0.05).ranges) == few


def test_smoothing_bends_no_straight_wall_and_halves_the_noise():
    clean, noisy = scan_of_a_room(), scan_of_a_room(noise=0.05)
    # Corners of the room are rounded off; a beam in thirty is within three of one.
    bent = np.abs(smoothed(clean, 0.05).ranges - clean.ranges)
    assert np.sort(bent)[: 360 - 4 * 7].max() < 1e-9
    off = smoothed(noisy, 0.05).ranges - clean.ranges
    assert np.median(np.abs(off)) < 0.5 * np.median(np.abs(noisy.ranges - clean.ranges))
    assert smoothed(noisy, 0.01) is noisy


def test_a_match_of_scans_that_err_by_five_centimetres_says_how_far_it_is_off():
    poses = [np.array([2.0, 2.0, 0.3]), np.array([2.2, 2.1, 0.35])]
    step, squares = np.array([*(_turned(poses[1] - poses[0], -0.3)), 0.05]), []
    for seed in range(0, 60, 2):
        old, new = (_surface(scan_of_a_room(noise=0.05, seed=seed + k, pose=pose)) for k, pose in enumerate(poses))
        (match,) = align(WallField(old), new, step, 1e-6 * np.eye(3), step[None])
        off = match.pose - step
        off[2] = wrap_angle(float(off[2]))
        squares.append(off @ match.information @ off)
    assert 1.0 < np.mean(squares) < 6.0


def _surface(scan):
    noise = range_noise(scan)
    return surface_of(smoothed(scan, noise).points(), noise=noise, increment=scan.angle_increment)


def _turned(step, angle):
    c, s = np.cos(angle), np.sin(angle)
    return c * step[0] - s * step[1], s * step[0] + c * step[1]
