"""Baked light against what physics says: closed forms, geometry, and conservation."""

import numpy as np
import pytest

from mjsim.compile import compile_world, compiled
from mjsim.light import GENERAL, LAMP, BakedLight, bake
from mjsim.light.charts import MAX_CHART_SIDE
from mjsim.light.light_geometry import atlas_of
from mjsim.world import parse_world

BLACK = """mjsim: 1
light: 0
walls: [{points: [[-2, -2], [2, -2], [2, 2], [-2, 2]], closed: true, color: "#000000"}]
floor: {color: "#000000"}
"""


def baked(text, **options):
    world = parse_world(text)
    model = compiled(compile_world(world))
    return model, bake(world, model, processes=1, **options)


def light_at(model, light: BakedLight, geom: str, point, *, group: str = LAMP):
    """Return the light of a group on a surface, interpolated as OpenGL does, red, green, blue."""
    surface = next(each for each in light.surfaces if model.geom(each.geom).name == geom)
    texels = next(each for each in light.groups if each.name.startswith(group)).texels.astype(float)
    for corners in surface.triangles:
        a, b, c = surface.points[corners]
        shares, rest, *_ = np.linalg.lstsq(np.array([b - a, c - a]).T, np.asarray(point, float) - a, rcond=None)
        if shares.min() > -1e-6 and shares.sum() < 1 + 1e-6 and (rest.size == 0 or rest[0] < 1e-6):
            u, v = np.array([1 - shares.sum(), *shares]) @ surface.lightcoords[corners]
            return bilinear(texels, u * texels.shape[1] - 0.5, v * texels.shape[0] - 0.5)
    raise AssertionError(f"{point} is not on {geom}")


def bilinear(texels, column, row):
    x, y = int(np.floor(column)), int(np.floor(row))
    a, b = column - x, row - y
    upper = (1 - a) * texels[y, x] + a * texels[y, x + 1]
    return (1 - b) * upper + b * ((1 - a) * texels[y + 1, x] + a * texels[y + 1, x + 1])


pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def dark_room():
    text = f"{BLACK}lamps: [{{at: [-1, 0], height: 2, color: '#ffffff'}}]\n"
    return baked(f"{text}obstacles: [{{name: box, box: [0.5, 2, 0.5], at: [0.25, 0], color: '#000000'}}]\n")


def test_light_under_a_lamp_falls_off_as_that_of_a_small_level_source(dark_room):
    model, light = dark_room
    under = light_at(model, light, "floor", [-1, 0, 0])[0]
    assert under == pytest.approx(1.0, rel=0.01)
    for r in (0.5, 1.0, 1.5):
        expected = (4 / (4 + r * r)) ** 2
        assert light_at(model, light, "floor", [-1, r, 0])[0] / under == pytest.approx(expected, rel=0.02)


def test_the_penumbra_of_a_box_is_as_wide_as_geometry_says(dark_room):
    model, light = dark_room
    # The far upper edge of the box hides the lamp, 0.2 m wide and 2 m high, from x1 to x2 on.
    edge, height, lamp = 0.5, 0.5, (-1.1, -0.9)
    ends = sorted(edge + (edge - x) * height / (2.0 - height) for x in lamp)
    xs = np.arange(0.6, 1.4, 0.01)
    seen = np.array([light_at(model, light, "floor", [x, 0, 0])[0] for x in xs])
    free = np.array([(4 / (4 + (x + 1) ** 2)) ** 2 for x in xs])
    share = seen / free
    # A texel of 0.05 m blurs each end.
    assert xs[share > 0.05][0] == pytest.approx(ends[0], abs=0.05)
    assert xs[share < 0.95][-1] == pytest.approx(ends[1], abs=0.05)


def test_a_lamp_does_not_shine_through_a_wall_or_its_corners():
    text = BLACK.replace("walls: [", "walls: [{points: [[1, -2], [1, 1], [2, 1]], height: 2.5, color: '#000000'}, ")
    model, light = baked(f"{text}lamps: [{{at: [-1, 0], height: 2}}]\nceiling: {{color: '#000000'}}\n")
    for point in ([1.08, 0, 0], [1.08, 0.92, 0], [1.9, 0.92, 0], [1.08, -1.9, 0], [1.5, 0, 0]):
        assert light_at(model, light, "floor", point).max() == 0.0
    assert light_at(model, light, "floor", [0.92, 0, 0])[0] > 0.2


def test_reflected_light_does_not_spread_below_a_closed_door_that_is_thinner_than_a_texel():
    text = """mjsim: 1
light: 0
walls:
  - {points: [[-1, -0.5], [1, -0.5], [1, 0.5], [-1, 0.5]], closed: true}
  - {points: [[0, -0.5], [0, 0.5]], openings: [{at: 0.2, width: 0.6, door: {}}]}
ceiling: {}
lamps: [{at: [-0.5, 0]}]
"""
    model, light = baked(text, texel=0.07)
    dark, lit = (light_at(model, light, "floor", [x, 0, 0])[0] for x in (0.1, -0.1))
    assert lit > 0.5
    assert dark < 0.02 * lit


def test_the_floor_is_redder_near_a_red_wall():
    text = BLACK.replace("floor: {color: '#000000'}", "floor: {color: '#ffffff'}").replace("#000000", "#e02010", 1)
    model, light = baked(f"{text}lamps: [{{at: [1, 0], height: 2.4, color: '#ffffff'}}]\n", texel=0.1)
    near, far = (light_at(model, light, "floor", [x, 0, 0]) for x in (-1.65, 1.0))
    assert near[0] / near[1] > 1.02 * far[0] / far[1] > 1.0


def test_no_seam_shows_where_pieces_of_a_wall_meet():
    text = """mjsim: 1
walls:
  - {points: [[0, 0], [14, 0]], openings: [{at: 6.5, width: 1, sill: 0, head: 1}]}
"""
    model, light = baked(text, texel=0.1)
    walls = [each for each in light.surfaces if model.geom(each.geom).name.startswith("wall/")]
    found = {}
    for surface in walls:
        for point, normal, place in zip(surface.points, surface.normals, surface.lightcoords, strict=True):
            key = (*np.round(point, 4).tolist(), *np.round(normal, 2).tolist())
            found.setdefault(key, set()).add(tuple(np.round(place, 5).tolist()))
    shared = [places for key, places in found.items() if len(places) > 1 and abs(key[4]) == 1.0]
    assert shared == []


def test_the_dark_gap_behind_furniture_does_not_spread_over_the_wall_above():
    # The box stands 2 cm from the wall, whose face is at y = 0.05.
    text = """mjsim: 1
walls: [{points: [[-2, 0], [2, 0]], height: 2}]
obstacles: [{name: box, box: [1.5, 0.5, 0.5], at: [0, 0.32]}]
"""
    model, light = baked(text, texel=0.1)
    above, aside = (light_at(model, light, "wall/seen:1", [x, 0.05, 0.62], group=GENERAL)[0] for x in (0.0, 1.6))
    assert above > 0.8 * aside


def test_people_who_stand_shade_and_have_no_light_map():
    world = parse_world("mjsim: 1\npeople: [{name: anna, at: [1, 1], sex: female}]\n")
    model = compiled(compile_world(world))
    atlas = atlas_of(world, model, texel=1.0)
    people = [solid for solid in atlas.solids if model.geom(solid.geom).name.startswith("anna/")]
    assert len(people) > 10
    assert all(solid.shades and solid.moves for solid in people)


def test_no_light_map_is_longer_than_opengl_allows():
    world = parse_world("mjsim: 1\nwalls: [{points: [[0, 0], [9000, 0]]}]\n")
    atlas = atlas_of(world, compiled(compile_world(world)), texel=1.0)
    assert max(atlas.charts.shape) < 8192
    assert atlas.charts.count.max() == MAX_CHART_SIDE
