"""Tiles of the floor begin at the world's origin, those of a patch at its corner: in pictures and in exports."""

import math

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from mjsim.bench.rooms import forwarded, look_from, png
from mjsim.compile import compile_world, triangles_of
from mjsim.sim import Renderer
from mjsim.world import Source, parse_world

COLORS = np.array([[[200, 0, 0], [0, 200, 0]], [[0, 0, 200], [150, 150, 150]]], dtype=np.uint8)
"""Quarters of a tile, seen from above with y up."""
TILE = np.repeat(np.repeat(COLORS, 32, axis=0), 32, axis=1)
EYE, SIDE = 4.0, 72
"""Height of the camera [m] and side of its picture [px]."""
ROOM = """
mjsim: 1
walls: [{{points: [[{left}, {low}], [{right}, {low}], [{right}, {high}], [{left}, {high}]], closed: true}}]
floor: {{texture: tile.png, tile: {tile}{patches}}}
"""


def compiled(text: str) -> mujoco.MjModel:
    return compile_world(parse_world(text, source=Source(attached={"tile.png": png(TILE)}))).compile()


def random_room(number: int) -> dict[str, float]:
    rng = np.random.default_rng(number)
    left, low = rng.uniform(-9, 4, 2)
    wide, long = rng.uniform(2.5, 9, 2)
    return {"left": left, "low": low, "right": left + wide, "high": low + long, "tile": rng.uniform(0.4, 3.1)}


def quarters_from_above(model: mujoco.MjModel, middle: NDArray[np.float64]) -> tuple[NDArray[np.intp], ...]:
    """Return the quarter that each pixel shows, -1 for another colour, and its place on the floor [m]."""
    data = forwarded(model)
    look_from(model, data, "overview", [*middle, EYE], [0.0, 0.0, -1.0])
    with Renderer(model, width=SIDE, height=SIDE) as renderer:
        picture = renderer.render(data, "overview").astype(float)
    hues = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.577, 0.577, 0.577]])
    seen = np.argmax(picture @ hues.T, axis=2)
    places = (np.arange(SIDE) - (SIDE - 1) / 2) * 2 / SIDE * EYE * math.tan(math.radians(model.cam_fovy[0]) / 2)
    return seen, np.stack(np.meshgrid(middle[0] + places, middle[1] - places), axis=-1)


def expected_quarters(x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
    """Return the quarter at places counted in tiles right and up, and whether it is clear of its borders."""
    column, row = np.floor(2 * x).astype(int) % 2, np.floor(-2 * y).astype(int) % 2
    aside = np.abs(np.stack([x, y]) * 2 - np.rint(np.stack([x, y]) * 2)).min(axis=0)
    return row * 2 + column, aside > 0.2


@pytest.mark.parametrize("number", range(5))
def test_tiles_of_the_floor_begin_at_the_origin_of_the_world_in_rooms_of_any_size(number):
    room = random_room(number)
    model = compiled(ROOM.format(**room, patches=""))
    middle = np.array([room["left"] + room["right"], room["low"] + room["high"]]) / 2
    seen, places = quarters_from_above(model, middle)
    right, clear = expected_quarters(places[..., 0] / room["tile"], places[..., 1] / room["tile"])
    inside = np.all(np.abs(places - middle) < 1.0, axis=-1)
    assert (clear & inside).sum() > 200
    assert np.mean((seen == right)[clear & inside]) > 0.99


@pytest.mark.parametrize("heading_deg", [0, 90, 30])
def test_tiles_of_a_patch_begin_at_the_left_end_of_its_rear_edge(heading_deg):
    patch = f"at: [1.3, 0.7], size: [2.3, 1.9], heading_deg: {heading_deg}, name: rug, texture: tile.png, tile: 0.8"
    model = compiled(ROOM.format(left=-3, low=-3, right=5, high=4, tile=50, patches=f", patches: [{{{patch}}}]"))
    seen, places = quarters_from_above(model, np.array([1.3, 0.7]))
    turn = math.radians(heading_deg)
    away = places - [1.3, 0.7]
    along = math.cos(turn) * away[..., 0] + math.sin(turn) * away[..., 1]
    left = math.cos(turn) * away[..., 1] - math.sin(turn) * away[..., 0]
    right, clear = expected_quarters((along + 1.15) / 0.8, (left - 0.95) / 0.8)
    on = (np.abs(along) < 1.05) & (np.abs(left) < 0.85)
    assert np.mean((seen == right)[clear & on]) > 0.99
    surface = triangles_of(model, model.geom("floor/seen:rug").id)
    np.testing.assert_allclose(surface.places * [0.8, -0.8], surface.points[:, :2] + [1.15, -0.95], atol=1e-6)


@pytest.mark.parametrize("number", range(5, 25))
def test_exported_tiles_begin_where_those_of_pictures_do(number):
    room = random_room(number)
    model = compiled(ROOM.format(**room, patches=""))
    geom = model.geom("floor").id
    surface = triangles_of(model, geom)
    world = surface.points[:, :2] + model.geom_pos[geom, :2]
    tiles = world / room["tile"]
    # Texture coordinates run right and down; whole tiles do not matter.
    whole = surface.places * [1.0, -1.0] - tiles
    np.testing.assert_allclose(whole, np.rint(whole), atol=1e-6)
    assert np.all(np.abs(world - [room["left"], room["low"]]).min(axis=0) < 2.0 + room["tile"] + 0.06)
