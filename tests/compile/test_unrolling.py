"""Textures run on round the edges of walls, and are not cut by doorways."""

import mujoco
import numpy as np
import pytest

from mjsim.compile import compile_world
from mjsim.world import parse_world

ROOM = """
mjsim: 1
walls:
  - points: {points}
    closed: {closed}
    height: 2.5
    texture: materials/plaster.jpg
    tile: 1.6
    openings: [{openings}]
robots: [{{name: scout, at: [2, 1]}}]
"""


def corners_of(points: str, *, closed: bool = False, openings: str = ""):
    """Return position, normal and place on the texture [m] of each corner of the faces of a wall."""
    world = parse_world(ROOM.format(points=points, closed=str(closed).lower(), openings=openings))
    meshes = [mesh for mesh in compile_world(world).meshes if mesh.name.startswith("wall/")]
    parts = [
        np.reshape(getattr(mesh, name), (-1, size))
        for mesh in meshes
        for name, size in (("uservert", 3), ("usernormal", 3), ("usertexcoord", 2))
    ]
    points, normals, places = (np.vstack(parts[k::3]) for k in range(3))
    return points, normals, 1.6 * places


def _at(corners, x: float, y: float, normal: tuple[float, float]):
    """Return the places on the texture of corners at a position, on the face with a normal: their rightward parts."""
    points, normals, places = corners
    here = (np.abs(points[:, :2] - (x, y)).max(axis=1) < 1e-5) & (np.abs(normals[:, :2] - normal).max(axis=1) < 1e-5)
    assert here.any()
    return places[here, 0]


def test_a_texture_runs_on_round_the_corners_of_a_room_whose_sides_are_no_whole_tiles():
    corners = corners_of("[[0, 0], [5.3, 0], [5.3, 3.7], [0, 3.7]]", closed=True)
    inside = {
        (0.05, 0.05): ((0, 1), (1, 0)),
        (5.25, 0.05): ((0, 1), (-1, 0)),
        (5.25, 3.65): ((0, -1), (-1, 0)),
        (0.05, 3.65): ((0, -1), (1, 0)),
    }
    runs_on = [
        np.ptp(np.concatenate([_at(corners, *place, way) for way in ways])) < 1e-6 for place, ways in inside.items()
    ]
    # Round all four it could not run on: the room is 17.6 m less four thicknesses around.
    assert sum(runs_on) == 3


def test_a_texture_runs_on_round_a_bend_at_any_angle():
    corners = corners_of("[[0, 0], [3, 0], [5, 1], [6, 3]]")
    points, normals, places = corners
    upright = normals[:, 2] == 0.0
    for bend in np.unique(np.round(points[upright, :2], 5), axis=0):
        here = upright & (np.abs(points[:, :2] - bend).max(axis=1) < 1e-5)
        ways = np.unique(np.round(normals[here], 3), axis=0)
        if len(ways) == 2 and np.dot(*ways[:, :2]) > 0.1:
            assert np.ptp(places[here, 0]) < 1e-6


@pytest.mark.parametrize("opening", ["{at: 2, width: 0.9}", "{at: 2, width: 1.3, sill: 0.9, head: 2}"])
def test_a_texture_on_a_wall_with_an_opening_stays_aligned(opening):
    points, normals, places = corners_of("[[0, 0], [6, 0]]", openings=opening)
    for way in (1.0, -1.0):
        face = np.abs(normals[:, 1] - way) < 1e-6
        along = places[face, 0] - points[face, 0] * -way
        assert np.ptp(along) < 1e-6
        np.testing.assert_allclose(places[face, 1] + points[face, 2], 0.0, atol=1e-6)


def test_both_sides_of_a_wall_are_counted_from_the_origin():
    """Its ends, which are thin, do not join them; a texture of whole metres lies as it does on paper."""
    points, normals, places = corners_of("[[0, 0], [6, 0]]", openings="{at: 2, width: 0.9}")
    for way in (1.0, -1.0):
        face = np.abs(normals[:, 1] - way) < 1e-6
        np.testing.assert_allclose(places[face, 0], -way * points[face, 0], atol=1e-6)


def test_a_metre_of_wall_is_a_metre_of_texture_on_every_face():
    points, _, places = corners_of("[[0, 0], [3, 0], [5, 1], [6, 3]]")
    world = parse_world(ROOM.format(points="[[0, 0], [3, 0], [5, 1], [6, 3]]", closed="false", openings=""))
    (mesh,) = (mesh for mesh in compile_world(world).meshes if mesh.name.startswith("wall/"))
    triangles = np.reshape(mesh.userface, (-1, 3))
    for start, end in ((0, 1), (1, 2), (2, 0)):
        lengths = np.linalg.norm(points[triangles[:, start]] - points[triangles[:, end]], axis=1)
        seen = np.linalg.norm(places[triangles[:, start]] - places[triangles[:, end]], axis=1)
        np.testing.assert_allclose(seen, lengths, atol=2e-6)


def test_walls_with_one_texture_share_it_and_a_colour_multiplies_it():
    walls = "".join(
        f"  - {{points: [[0, {y}], [3, {y}]], texture: materials/plaster.jpg, color: '{color}'}}\n"
        for y, color in ((0, "#ff8040"), (2, "#e8e4da"))
    )
    model = compile_world(parse_world(f"mjsim: 1\nwalls:\n{walls}robots: [{{name: scout, at: [2, 1]}}]\n")).compile()
    assert model.ntex == 1
    seen = [geom for geom in range(model.ngeom) if model.geom(geom).name.startswith("wall/seen")]
    tints = {tuple(np.round(model.geom_rgba[geom] * 255).astype(int)[:3]) for geom in seen}
    assert tints == {(255, 128, 64), (255, 255, 255)}
    assert len({int(model.geom_matid[geom]) for geom in seen}) == 1
    assert mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_MATERIAL, "wall/texture1") >= 0
