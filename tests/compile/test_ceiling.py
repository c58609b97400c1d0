"""The ceiling: seen from below, and in nobody's way."""

import numpy as np
import pytest

from mjsim.bench.rooms import cast, forwarded, look_from
from mjsim.compile import compile_world
from mjsim.sim import Renderer
from mjsim.world import parse_world

ROOM = """
mjsim: 1
walls: [{{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true, height: 3}}]
{}
robots: [{{name: r, at: [3, 2], sensors: [{{camera: up, at: [0, 0, 0.4]}}]}}]
"""


def compiled(ceiling: str):
    return compile_world(parse_world(ROOM.format(ceiling))).compile()


def seen_upwards(model, renderer: Renderer):
    data = forwarded(model)
    look_from(model, data, "r/up", [3.0, 2.0, 0.5], [0.0, 0.0, 1.0])
    return renderer.render(data, "r/up"), renderer.depth(data, "r/up")


@pytest.mark.parametrize(("keys", "height"), [("", 3.0), ("height: 2.4", 2.4)])
def test_a_ceiling_is_as_high_as_it_says_or_as_the_highest_wall(keys, height):
    model = compiled(f'ceiling: {{color: "#ff0000", {keys}}}')
    with Renderer(model, width=64, height=48) as renderer:
        picture, depth = seen_upwards(model, renderer)
    np.testing.assert_allclose(depth, height - 0.5, atol=1e-3)
    assert (picture[..., 0] > 120).all()
    assert (picture[..., 1:] < 5).all()


@pytest.mark.slow
def test_its_tiles_are_as_large_as_they_say():
    model = compiled("ceiling: {texture: floors/oak.jpg, tile: 0.5}")
    with Renderer(model, width=400, height=400) as renderer:
        picture, _ = seen_upwards(model, renderer)
    # One metre at a distance of 2.5 m, in pixels; the picture repeats after half of that.
    metre = 200 / np.tan(np.radians(model.cam_fovy[model.camera("r/up").id]) / 2) / 2.5
    tile = metre * 0.5
    gray = picture.mean(axis=2)
    apart = [np.abs(gray[:, shift:] - gray[:, : 400 - shift]).mean() for shift in range(10, round(1.4 * tile))]
    assert np.argmin(apart) + 10 == pytest.approx(tile, abs=1)


def test_views_from_above_and_rays_go_through_it():
    with_ceiling, without = compiled("ceiling: {}"), compiled("")
    pictures = []
    for model in (with_ceiling, without):
        with Renderer(model, width=160, height=90) as renderer:
            pictures.append(renderer.render(forwarded(model), "overview"))
    np.testing.assert_array_equal(*pictures)
    start, up = np.array([3.0, 2.0, 1.0]), np.array([[0.0, 0.0, 1.0]])
    assert np.isinf(cast(with_ceiling, forwarded(with_ceiling), start, up)).all()
