"""What walls hide is not drawn, and no pixel changes for it."""

from ctypes import byref, c_int, c_uint, c_void_p

import mujoco
import numpy as np
import pytest

from mjsim.bench.scenes import office, office_places
from mjsim.geometry import Pose
from mjsim.sim import Renderer, Simulation
from mjsim.sim.rendering import in_view
from mjsim.world import parse_world

pytestmark = pytest.mark.slow

SIGNS = "".join(
    f"  - {{name: sign{k}, at: [{1 + 0.4 * (k % 20)}, {3.9 if k < 20 else 0.1}], heading_deg: {-90 if k < 20 else 90},"
    " width: 0.3, center: 1.2}\n"
    for k in range(40)
)


def two_rooms(*, wall: float, sign: float = 1.2, camera: float = 1.0) -> str:
    """Return two rooms side by side with a wall between, signs on both long sides; the robot looks along them."""
    signs = SIGNS.replace("center: 1.2", f"center: {sign}")
    return f"""\
mjsim: 1
name: rooms
walls:
  - {{points: [[0, 0], [10, 0], [10, 4], [0, 4]], closed: true, height: 3}}
  - {{points: [[3, 0], [3, 4]], height: {wall}}}
beacons:
{signs}robots: [{{name: scout, preset: pioneer3dx, at: [1, 2], sensors: [{{camera: eye, at: [0, 0, {camera}]}}]}}]
"""


def drawn(world, *, hidden, monkeypatch, place=None):
    """Return the picture, the depth and how many geoms were drawn, with or without asking what is hidden."""
    monkeypatch.setattr(in_view, "MIN_GEOMS", 1 if hidden else 10**9)
    with Simulation(world) as sim, Renderer(sim.model, width=160, height=120) as renderer:
        if place is not None:
            sim.move("scout", place)
        camera = f"scout/{world.robots[0].sensors[0].camera}"
        return renderer.render(sim.data, camera), renderer.depth(sim.data, camera), renderer.drawn


def both_ways(text, monkeypatch):
    """Return how many geoms are drawn when what is hidden is left out, and how many else; the pictures are equal."""
    world = parse_world(text)
    picture, depth, few = drawn(world, hidden=True, monkeypatch=monkeypatch)
    whole, whole_depth, many = drawn(world, hidden=False, monkeypatch=monkeypatch)
    np.testing.assert_array_equal(picture, whole)
    np.testing.assert_array_equal(depth, whole_depth)
    return few, many


def test_signs_behind_a_wall_are_not_drawn(monkeypatch):
    few, many = both_ways(two_rooms(wall=3.0), monkeypatch)
    # Those at x = 1 to 2.6 are on the robot's side of the wall, some of them beside its view.
    assert few <= 4 + 10 < 20 < many


def test_over_a_low_wall_everything_is_drawn(monkeypatch):
    few, many = both_ways(two_rooms(wall=1.5), monkeypatch)
    assert few == many > 20


def test_from_above_the_walls_everything_is_drawn(monkeypatch):
    few, many = both_ways(two_rooms(wall=3.0, camera=3.5), monkeypatch)
    assert few == many


def test_what_is_higher_than_the_walls_is_drawn(monkeypatch):
    few, many = both_ways(two_rooms(wall=3.0, sign=2.95), monkeypatch)
    assert few == many > 20


def test_no_pixel_of_an_office_changes_and_few_of_its_rooms_are_drawn(monkeypatch):
    world = office(500, 160, 120)
    with Simulation(world) as sim, Renderer(sim.model, width=160, height=120) as renderer:
        counts = []
        for place in [*office_places(500, 40), Pose(-5.0, -5.0, 0.8)]:
            sim.move("scout", place)
            seen = []
            for worth in (1, 10**9):
                monkeypatch.setattr(in_view, "MIN_GEOMS", worth)
                seen.append((renderer.render(sim.data, "scout/front"), renderer.drawn))
            np.testing.assert_array_equal(seen[0][0], seen[1][0])
            counts.append([seen[0][1], seen[1][1]])
    few, many = np.mean(counts, axis=0)
    assert few < many / 2


def test_what_moves_behind_a_wall_is_not_drawn(monkeypatch):
    carts = "".join(
        f"  - {{name: cart{k}, box: [0.2, 0.2, 1.0], at: [{4 + 0.3 * (k % 10)}, {1 + k // 10}],"
        f" path: {{points: [[{4 + 0.3 * (k % 10)}, {1.5 + k // 10}]], speed: 0.1}}}}\n"
        for k in range(20)
    )
    text = two_rooms(wall=3.0).replace("beacons:", f"obstacles:\n{carts}beacons:")
    few, many = both_ways(text, monkeypatch)
    assert few <= 4 + 10 < 40 < many


def test_what_is_drawn_first_changes_no_pixel(monkeypatch):
    world = office(500, 160, 120)
    with Simulation(world) as sim, Renderer(sim.model, width=160, height=120) as renderer:
        sort = in_view.InView.sort
        for place in office_places(500, 10):
            sim.move("scout", place)
            seen = []
            for order in (sort, lambda self, scene, view: None):
                monkeypatch.setattr(in_view.InView, "sort", order)
                seen += [renderer.render(sim.data, "scout/front"), renderer.depth(sim.data, "scout/front")]
            np.testing.assert_array_equal(seen[0], seen[2])
            np.testing.assert_array_equal(seen[1], seen[3])


SAMPLES_PASSED, QUERY_RESULT = 0x8914, 0x8866


def fragments(renderer, data, camera, monkeypatch):
    """Return how many pixels of surfaces pass the depth test in a picture, as OpenGL counts them."""
    render, count, query = mujoco.mjr_render, c_uint(), c_uint()

    def counted(*arguments):
        call = renderer._canvas.gl.function
        call(b"glGenQueries", None, c_int, c_void_p)(1, byref(query))
        call(b"glBeginQuery", None, c_uint, c_uint)(SAMPLES_PASSED, query)
        render(*arguments)
        call(b"glEndQuery", None, c_uint)(SAMPLES_PASSED)
        call(b"glGetQueryObjectuiv", None, c_uint, c_uint, c_void_p)(query, QUERY_RESULT, byref(count))

    with monkeypatch.context() as patch:
        patch.setattr(mujoco, "mjr_render", counted)
        renderer.render(data, camera)
    return count.value


def test_what_stands_in_a_room_is_drawn_before_its_walls(monkeypatch):
    text = two_rooms(wall=3.0).replace("height: 3.0}", "height: 3.0, color: '#ccd4cf'}")
    with Simulation(parse_world(text)) as sim, Renderer(sim.model, width=160, height=120) as renderer:
        pixels = np.isfinite(renderer.depth(sim.data, "scout/eye")).sum()
        # On edges between surfaces a pixel may be drawn twice.
        assert pixels <= fragments(renderer, sim.data, "scout/eye", monkeypatch) < 1.02 * pixels
        monkeypatch.setattr(in_view.InView, "sort", lambda self, scene, view: None)
        assert fragments(renderer, sim.data, "scout/eye", monkeypatch) > 1.2 * pixels
