"""Light: as bright as written, dark when there is none, and lamps that fall off with distance."""

import mujoco
import numpy as np
import pytest

from mjsim.bench.rooms import forwarded, look_from
from mjsim.compile import compile_world
from mjsim.compile.scene_lamps import divided
from mjsim.sim import Renderer
from mjsim.world import parse_world

ROOM = """
mjsim: 1
walls: [{{points: [[0, 0], [9, 0], [9, 6], [0, 6]], closed: true, color: "#c0c0c0"}}]
beacons: [{{name: lion, image: posters/lion.jpg, at: [8.94, 3], heading_deg: 180, width: 1.0}}]
robots: [{{name: r, at: [2, 3], sensors: [{{camera: eye, at: [0, 0, 0.8], width: 160, height: 120}}]}}]
{}
"""


def compiled(light: str) -> mujoco.MjModel:
    return compile_world(parse_world(ROOM.format(light))).compile()


def onboard(light: str):
    """Return what the camera sees, of full brightness, shape (120, 160, 3)."""
    model = compiled(light)
    with Renderer(model, width=160, height=120) as renderer:
        return renderer.render(forwarded(model), "r/eye") / 255


def floor_at(model: mujoco.MjModel, places: list[tuple[float, float]]):
    """Return how bright the floor is at places, seen from right above."""
    data, found = forwarded(model), []
    with Renderer(model, width=9, height=9) as renderer:
        for x, y in places:
            look_from(model, data, "overview", [x, y, 0.3], [0.0, 0.0, -1.0])
            found.append(renderer.render(data, "overview")[4, 4].mean() / 255)
    return np.array(found)


@pytest.mark.slow
def test_a_room_without_light_is_dark_in_the_camera():
    assert onboard("light: 0").mean() < 0.01
    assert onboard("light: 0.03").mean() < 0.05
    assert onboard("").mean() > 0.5


@pytest.mark.slow
@pytest.mark.parametrize("level", [0.6, 0.25])
def test_less_light_darkens_everything_in_proportion_pictures_too(level):
    full, less = onboard(""), onboard(f"light: {level}")
    # Colours are whole numbers of 255, and a picture glows with a mean of what falls on it.
    np.testing.assert_allclose(less, level * full, atol=0.02)
    poster = less[30:90, 60:100]
    assert np.ptp(poster) > 0.3 * level


@pytest.mark.slow
def test_a_lamp_lights_what_is_near_and_falls_off_with_the_square_of_the_distance():
    model = compiled("light: 0\nlamps: [{at: [2, 3], height: 2.0, color: '#ffffff', brightness: 0.5}]")
    x = np.array([2.7, 3.5, 5.0, 6.5, 8.0])
    found = floor_at(model, [(place, 3.0) for place in x])
    d = np.hypot(x - 2.0, 2.0)
    # Lambert's law and the lamp's own; a fifth comes from all sides.
    expected = 0.5 / (0.2 + 0.2 * d**2) * (0.8 * 2.0 / d + 0.2) * np.mean([0xB8, 0xAA, 0x94]) / 255
    np.testing.assert_allclose(found, expected, atol=0.012)


@pytest.mark.slow
def test_a_lamp_shows_pictures_in_a_dark_room():
    poster = onboard("light: 0\nlamps: [{at: [7.5, 3], height: 1.5}]")[40:80, 60:100]
    dark = onboard("light: 0\nlamps: [{at: [7.5, 3], height: 1.5, brightness: 0}]")[40:80, 60:100]
    assert poster.mean() > 0.2
    assert dark.mean() < 0.01


@pytest.mark.slow
def test_of_many_lamps_those_count_that_are_near():
    lamps = ", ".join(f"{{at: [{x}, {y}], range: 3}}" for x in range(1, 9, 2) for y in (1, 3, 5))
    model = compiled(f"lamps: [{lamps}]\nlight: 0")
    found = floor_at(model, [(1.0, 1.0), (7.0, 5.0), (5.0, 3.0)])
    np.testing.assert_allclose(found, found[0], rtol=0.25)
    assert found.min() > 0.4
    assert model.light_active.sum() == 12


def test_only_a_world_with_lamps_is_divided_finely():
    plain, lit = compiled(""), compiled("lamps: [{at: [1, 1]}]")
    assert plain.nmeshface < 100 < lit.nmeshface
    assert lit.nmeshface < 60_000


def test_a_divided_mesh_covers_the_same_and_has_no_long_edge():
    corners = np.array([[0.0, 0, 0, 0], [3, 0, 0, 3], [3, 1, 0, 4], [0, 1, 1, 1]])
    triangles = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32)
    points, parts = divided(corners, triangles, 0.4)

    def area(points, triangles):
        a, b, c = points[triangles, :3].transpose(1, 0, 2)
        return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2

    assert area(points, parts) == pytest.approx(area(corners, triangles))
    edges = np.sort(np.vstack([parts[:, [0, 1]], parts[:, [1, 2]], parts[:, [2, 0]]]), axis=1)
    assert np.linalg.norm(points[edges[:, 0], :3] - points[edges[:, 1], :3], axis=1).max() <= 0.4
    # Whatever else a corner carries is linear over the face: here x + y.
    np.testing.assert_allclose(points[:, 3], points[:, 0] + points[:, 1])
    # Without a crack: edges that belong to one triangle only lie on the outline.
    unique, counts = np.unique(edges, axis=0, return_counts=True)
    rim = points[unique[counts == 1], :2]
    on_rim = (np.ptp(rim, axis=1) < 1e-12).any(axis=1) & np.isin(rim.reshape(-1, 2).round(9), [0, 1, 3]).any()
    assert on_rim.all()
