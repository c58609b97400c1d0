"""Depth by stereo matching: steps, correlated errors and holes where geometry and texture have them."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from mjsim.interface import CameraFrame
from mjsim.sim import Canvas, OnboardCamera, Simulation, streams_of
from mjsim.sim.imaging.lens import intrinsics_of
from mjsim.sim.imaging.stereo import StereoDepth
from mjsim.world import Camera, Stereo, parse_world

WIDE, TALL = 160, 120
CAMERA = Camera.model_validate({"camera": "c", "width": WIDE, "height": TALL, "fov_deg": 80})
SCALE = CAMERA.focal * 0.05
"""Disparity of a point at 1 m [px]."""
TEXTURE = np.random.default_rng(1).integers(0, 256, (TALL, WIDE, 3), dtype=np.uint8)


def stereo(number: int = 0, **keys: object) -> StereoDepth:
    return StereoDepth(Stereo.model_validate(keys), intrinsics_of(CAMERA), np.random.default_rng(number))


def measured(depth: NDArray[np.float64], picture: NDArray[np.uint8] = TEXTURE, **keys: object) -> NDArray[np.float64]:
    return stereo(**keys).measured(depth, picture)


def wall(distance: float) -> NDArray[np.float64]:
    return np.full((TALL, WIDE), distance)


@pytest.mark.parametrize("distance", [0.5, 1.0, 2.0])
def test_errors_grow_with_the_square_of_the_distance(distance):
    depth = measured(wall(distance), step=0)[:, 20:]
    assert np.isfinite(depth).all()
    # 320 windows of 7 x 7 pixels are independent.
    assert depth.std() == pytest.approx(distance**2 * 0.08 / SCALE, rel=0.12)
    assert stereo().deviation == pytest.approx(0.08 / SCALE)


def test_errors_within_a_window_are_alike():
    rows = SCALE / np.concatenate([stereo(n, step=0).measured(wall(1.0), TEXTURE) for n in range(6)])[:, 20:]
    errors = rows - rows.mean()
    for lag in (0, 1, 3, 5, 7, 10):
        alike = (errors[:, : 130 - lag] * errors[:, lag:130]).mean() / errors.var()
        # The overlap of two windows of 7 px.
        assert alike == pytest.approx(max(1 - lag / 7, 0), abs=0.08), lag


def test_disparities_are_whole_steps():
    disparity = SCALE / measured(wall(1.3), step=0.125)[:, 20:]
    np.testing.assert_allclose(disparity / 0.125, np.rint(disparity / 0.125), atol=1e-4)
    assert len(np.unique(np.rint(disparity / 0.125))) > 1


def test_the_second_camera_does_not_see_a_strip_at_the_left_and_a_shadow_left_of_what_is_near():
    depth = wall(3.0)
    depth[40:80, 70:110] = 0.6
    holes = np.isnan(measured(depth, window=1, texture=0, subpixel=1e-3))
    assert holes[20, : math.floor(SCALE / 3.0)].all()
    assert not holes[20, math.ceil(SCALE / 3.0) + 1 :].any()
    shadow = SCALE / 0.6 - SCALE / 3.0
    found = np.flatnonzero(holes[60, 30:75])
    assert len(found) == pytest.approx(shadow, abs=2)
    assert found.max() + 30 in (69, 70)
    assert not holes[60, 112:].any()


def test_windows_across_an_edge_find_nothing():
    depth = wall(3.0)
    depth[:, 100:] = 0.6
    holes = np.isnan(measured(depth, window=9))
    assert holes[60, 96:104].all()
    assert not holes[60, 108:].any()


@pytest.mark.parametrize("tilt_deg", [40, 70, 84])
def test_a_surface_seen_from_its_side_has_no_depth(tilt_deg):
    """A wall turned about the vertical: a line of sight at the angle a from the axis meets it at the angle tilt - a."""
    angles = np.arctan((np.arange(WIDE) - (WIDE - 1) / 2) / CAMERA.focal)
    tilt = math.radians(tilt_deg)
    distance = 1.5 * math.cos(tilt) / (np.cos(tilt) + np.tan(angles) * math.sin(tilt))
    seen = np.degrees(np.abs(tilt - angles))
    depth = np.broadcast_to(np.where(distance > 0, distance, np.inf), (TALL, WIDE))
    holes = np.isnan(measured(np.array(depth), steepest_deg=60, window=1, texture=0))[TALL // 2]
    middle = slice(70, 120)
    assert (np.cos(tilt) + np.tan(angles) * math.sin(tilt) > 0)[middle].all()
    expected = seen[middle] > 60
    clear = np.abs(seen[middle] - 60) > 1.5
    np.testing.assert_array_equal(holes[middle][clear], expected[clear])


def test_a_plain_wall_has_depth_only_as_far_as_the_projector_reaches():
    plain = np.full((TALL, WIDE, 3), 130, dtype=np.uint8)
    assert np.isnan(measured(wall(1.0), plain)).all()
    assert np.isfinite(measured(wall(1.0), plain, texture=0)[:, 20:]).all()
    for distance, found in ((1.9, True), (2.1, False)):
        depth = measured(wall(distance), plain, texture=2.0, projector=8.0)[:, 20:]
        assert np.isfinite(depth).all() if found else np.isnan(depth).all()


def test_a_picture_passed_over_takes_the_same_random_numbers():
    one, two = stereo(4), stereo(4)
    one.measured(wall(1.0), TEXTURE)
    two.pass_over()
    np.testing.assert_array_equal(one.measured(wall(1.0), TEXTURE), two.measured(wall(1.0), TEXTURE))


def frame(keys: str) -> CameraFrame:
    world = parse_world(f"""
mjsim: 1
walls: [{{points: [[2, -2], [2, 2]], texture: walls/brick.jpg}}]
robots: [{{name: r, at: [0, 0], sensors: [{{camera: c, width: 96, height: 72, noise: 0, {keys}}}]}}]
""")
    with Simulation(world) as sim:
        robot = world.robots[0]
        canvas = Canvas(sim.model)
        camera = OnboardCamera(sim.model, robot, robot.sensors[0], streams=streams_of(0, "r", "c"), canvas=canvas)
        found = camera.frame(sim.data, 0.0)
        canvas.close()
    return found


def test_a_camera_measures_by_stereo_within_its_range():
    exact, seen = frame("depth: true").depth, frame("depth: {range: [0.3, 3], stereo: {texture: 0.5}}").depth
    both = np.isfinite(seen)
    assert both.mean() > 0.4
    assert np.nanmax(np.where(both, seen, 0.0)) <= 3.0
    wall = both & (np.abs(exact - exact[36, 48]) < 0.01)
    assert np.abs(seen - exact)[wall].mean() < 0.1
    assert np.abs(seen - exact)[wall].max() > 0.0
