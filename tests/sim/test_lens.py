"""Lenses: held to OpenCV's own projections, and pictures to where things must be seen in them."""

import cv2
import numpy as np
import pytest

from mjsim.errors import WorldError
from mjsim.geometry import Array
from mjsim.interface import CameraFrame
from mjsim.sim import Simulation
from mjsim.world import Lens, parse_world

BARREL = Lens(brown=(-0.25, 0.05, 0.003, -0.002, 0.01))
CUSHION = Lens(brown=(0.2, -0.03, 0.0, 0.001))
FISHEYE = Lens(fisheye=(0.03, -0.01, 0.002, 0.0))
EQUAL_ANGLES = Lens(fisheye=(0.0, 0.0, 0.0, 0.0))
LENSES = [BARREL, CUSHION, FISHEYE, EQUAL_ANGLES]


def grid(half: float) -> Array:
    return np.stack(np.meshgrid(np.linspace(-half, half, 15), np.linspace(-half, half, 15)), axis=-1).reshape(-1, 2)


@pytest.mark.parametrize("lens", LENSES, ids=["barrel", "cushion", "fisheye", "equal-angles"])
def test_a_lens_bends_as_opencv_does_and_straightens_what_it_bent(lens):
    points = grid(0.8)
    rays, still, eye = np.column_stack([points, np.ones(len(points))]), np.zeros(3), np.eye(3)
    if lens.brown is not None:
        expected = cv2.projectPoints(rays, still, still, eye, np.array(lens.brown))[0]
    else:
        expected = cv2.fisheye.projectPoints(rays[None], still, still, eye, np.array(lens.fisheye))[0]
    np.testing.assert_allclose(lens.bend(points), expected.reshape(-1, 2), atol=1e-12)
    np.testing.assert_allclose(lens.straighten(lens.bend(points)), points, atol=1e-9)


def test_what_lies_beyond_where_a_lens_folds_is_seen_by_no_way_of_light():
    # x (1 - 0.3 x^2) grows up to x = 1.054, where it is 0.703.
    straight = Lens(brown=(-0.3, 0.0, 0.0, 0.0)).straighten(np.array([[0.70, 0.0], [0.71, 0.0]]))
    assert np.isfinite(straight[0]).all()
    assert np.isnan(straight[1]).any()


def room(camera: str, more: str = "") -> str:
    """Return a room with red posts at known places before a camera at (0, 0, 0.5)."""
    posts = "".join(
        f"  - {{name: p{k}, cylinder: [0.03, 1.0], at: [{x}, {y}], color: '#ff0000'}}\n"
        for k, (x, y) in enumerate([(3.0, 0.0), (2.5, 1.2), (3.2, -1.0), (2.0, 1.9)])
    )
    sensor = f"{{camera: c, at: [0, 0, 0.5], width: 320, height: 240, rate_hz: 25, {camera}}}"
    return f"mjsim: 1\nobstacles:\n{posts}robots: [{{name: r, at: [0, 0], sensors: [{sensor}{more}]}}]\n"


def frame(camera: str) -> CameraFrame:
    with Simulation(parse_world(room(camera))) as sim:
        return sim.sense("r").cameras["c"]


@pytest.mark.parametrize("lens", LENSES, ids=["barrel", "cushion", "fisheye", "equal-angles"])
def test_things_are_seen_where_the_lens_puts_them(lens):
    text = lens.model_dump_json(exclude_none=True)
    seen = frame(f"fov_deg: 100, segmentation: true, depth: true, lens: {text}")
    K = seen.intrinsics
    assert K.lens == ("brown" if lens.brown else "fisheye")
    assert seen.segmentation is not None
    assert seen.depth is not None
    for name, (x, y) in {"p0": (3.0, 0.0), "p1": (2.5, 1.2), "p2": (3.2, -1.0), "p3": (2.0, 1.9)}.items():
        # Points of the post's axis, in the camera's optical frame.
        rays = np.array([[-y / x, height / x] for height in np.linspace(-0.4, 0.4, 9)])
        u, v = (lens.bend(rays) * [K.fx, K.fy] + [K.cx, K.cy]).T
        inside = (np.rint(v) >= 0) & (np.rint(v) < K.height) & (u >= 0) & (u < K.width - 1)
        assert inside.sum() >= 5, name
        columns, rows = np.rint(u[inside]).astype(int), np.rint(v[inside]).astype(int)
        instances = [seen.instances[index] for index in seen.segmentation[rows, columns]]
        assert instances == [f"obstacle/{name}"] * len(instances)
        np.testing.assert_allclose(seen.depth[rows, columns], x - 0.03, atol=0.02)
        colors = seen.image[rows, columns].astype(int)
        assert (colors[:, 0] > colors[:, 1] + 60).all()


def test_a_wide_lens_sees_a_wall_at_one_depth_and_in_one_tone_across_its_pictures():
    wall = "walls: [{points: [[1, -9], [1, 9]], height: 9, thickness: 0.2, color: '#808080'}]"
    keys = "at: [0, 0, 4], width: 96, height: 72, noise: 0"
    wide = f"{{camera: c, {keys}, fov_deg: 120, lens: {{fisheye: [0, 0, 0, 0]}}, depth: true}}"
    world = f"mjsim: 1\n{wall}\nrobots: [{{name: r, at: [0, 0], sensors: [{wide}, {{camera: plain, {keys}}}]}}]"
    with Simulation(parse_world(world)) as sim:
        seen, plain = (sim.sense("r").cameras[name] for name in ("c", "plain"))
    assert seen.depth is not None
    near = seen.depth < 1.0
    assert near[:, 10:-10].all()  # as far as 60 degrees to the sides
    np.testing.assert_allclose(seen.depth[near], 0.9, atol=1e-3)
    assert np.ptp(seen.image[near].astype(int), axis=0).max() <= 1
    middle = (36, 48)
    np.testing.assert_allclose(seen.image[middle].astype(int), plain.image[middle], atol=1)


@pytest.mark.slow
def test_half_the_field_of_view_is_still_at_the_edge():
    for lens in LENSES:
        text = lens.model_dump_json(exclude_none=True)
        K = frame(f"fov_deg: 80, lens: {text}").intrinsics
        edge = lens.bend(np.array([[np.tan(np.radians(40)), 0.0]]))[0, 0]
        assert K.fx * edge == pytest.approx(160.0)


def test_a_lens_that_folds_the_picture_and_one_of_two_models_are_refused():
    for keys, message in (
        ("fov_deg: 140, lens: {brown: [-0.3, 0, 0, 0]}", "the lens model is not invertible"),
        ("lens: {brown: [0, 0, 0, 0], fisheye: [0, 0, 0, 0]}", "a lens is of one model"),
    ):
        with pytest.raises(WorldError, match=message):
            parse_world(room(keys))
