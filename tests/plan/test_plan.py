"""One display list of a plan, and one look: all back ends show the same items in the same colours."""

import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import shapely

import mjsim
from mjsim.geometry import Pose
from mjsim.plan import INKS, ROLES, SvgPlan, bounds_of, color, paint_of, placed_at, swing, world_shapes, world_words
from mjsim.video import Letters
from mjsim.video.paper import Paper
from mjsim.video.plan_view import PlanView
from mjsim.world import footprint, leaves, parse_world, solid

THEME = Path(mjsim.__file__).parent / "web" / "page" / "src" / "ui" / "theme.css"
ROOM = parse_world(
    """
mjsim: 1
name: room
walls:
  - points: [[0, 0], [8, 0], [8, 6], [0, 6]]
    closed: true
    openings: [{name: gate, segment: 0, at: 3, width: 1, door: {}}]
obstacles: [{name: cart, box: [1, 0.5, 1.2], at: [5, 4], heading_deg: 90, movable: true, mass: 5}]
beacons:
  - {name: tag, marker: {dictionary: 4x4_50, id: 7}, at: [0.2, 0], on: cart, width: 0.3}
  - {name: owl, at: [0.1, 3]}
lamps: [{name: spot, at: [1, 1], brightness: 0}]
robots: [{name: scout, at: [2, 2], heading_deg: 90}]
"""
)


def items(role):
    return [item for item in world_shapes(ROOM) if item.role == role]


def test_the_design_settles_the_colours_and_all_roles_use_them():
    settled = {"truth": "#0072b2", "estimate": "#d55e00", "odometry": "#8a8a8a", "beacon": "#e69f00", "seen": "#009e73"}
    assert {name: INKS[name].light for name in settled} == settled
    assert len({ink.light for ink in INKS.values()}) == len(INKS)
    assert {"true robot": "truth", "beacon": "beacon", "odometry path": "odometry", "sighting": "seen"}.items() <= {
        role: (style.fill or style.line).ink for role, style in ROLES.items()
    }.items()


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_the_studio_has_the_colours_of_plans_and_films(theme):
    first, dark = THEME.read_text().split(':root[data-theme="dark"]')
    tokens = dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6});", first if theme == "light" else dark.split("}")[0]))
    for name in (
        "truth",
        "estimate",
        "odometry",
        "beacon",
        "seen",
        "scanned",
        "bump",
        "final",
        "glass",
        "lamp",
        "wall",
    ):
        assert tokens[name] == getattr(INKS[name], theme), name


def test_in_the_dark_each_meaning_is_lighter_and_of_the_same_hue():
    from colorsys import rgb_to_hls

    for name in ("truth", "estimate", "beacon", "seen", "bump", "final", "scanned"):
        (hue, light, _), (dark_hue, lighter, _) = (
            rgb_to_hls(*(each / 255 for each in color(name, theme))) for theme in ("light", "dark")
        )
        assert lighter > light, name
        assert min(abs(hue - dark_hue), 1 - abs(hue - dark_hue)) < 0.04, name


def test_walls_of_the_list_are_the_section_of_the_world():
    drawn = shapely.union_all([shapely.Polygon(part) for item in items("wall") for part in item.placed(0.01)])
    room = solid(ROOM.model_copy(update={"obstacles": ()}), height=1.0)
    assert drawn.symmetric_difference(room).area < 1e-6


def test_what_is_carried_moves_with_its_frame_and_all_else_stays():
    frames = {"obstacle/cart": Pose(1.0, 5.0, 0.0), "door/gate": Pose(3.0, 0.0, 1.0)}
    before, after = world_shapes(ROOM), placed_at(world_shapes(ROOM), frames)
    moved = {new.of for old, new in zip(before, after, strict=True) if old.place != new.place}
    assert moved == {"cart", "tag", "gate"}
    (tag,) = [item for item in after if item.role == "beacon"]
    assert (tag.place.x, tag.place.y, tag.place.heading) == (1.2, 5.0, 0.0)


def test_symbols_keep_their_size_and_small_things_have_a_least_one():
    (ring,) = [item for item in world_shapes(ROOM) if item.of == "owl"]
    (robot,) = items("robot")
    for metres in (0.001, 0.1, 1.0):
        (corners,) = ring.placed(metres)
        np.testing.assert_allclose(np.hypot(*(corners - (0.1, 3.0)).T), 0.7 * metres)
        (body,) = robot.placed(metres)
        assert np.hypot(*(body - (2.0, 2.0)).T).max() == pytest.approx(max(0.22, metres), rel=0.01)


def test_a_lamp_that_is_off_is_as_pale_as_the_paper():
    (off,) = [item for item in items("lamp") if item.kind == "area"]
    assert off.paint("dark").fill == color("paper", "dark")
    assert paint_of("lamp").fill == color("lamp")


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_svg_has_each_item_in_its_colour_at_its_place(theme):
    plan = SvgPlan(bounds_of(world_shapes(ROOM)), ratio=50, theme=theme)
    plan.draw(items("movable"))
    plan.name(world_words(ROOM))
    root = ElementTree.fromstring(plan.data())
    (box,) = root.iter("{http://www.w3.org/2000/svg}polygon")
    corners = np.array([pair.split(",") for pair in box.get("points").split()], float) / 100 * [1, -1]
    assert {tuple(corner) for corner in corners.round(6)} == {(4.75, 3.5), (5.25, 3.5), (5.25, 4.5), (4.75, 4.5)}
    tint = ROOM.obstacles[0].color
    assert box.get("fill") == "#" + bytes(paint_of("movable", tint=tint, theme=theme).fill).hex()
    assert {"scout", "cart", "owl", "tag", "gate", "spot"} <= {text.text for text in root.iter()}


def test_groups_that_are_drawn_in_several_steps_have_names_of_their_own():
    room = parse_world("mjsim: 1\nfloor: {patches: [{size: [1, 1], at: [1, 1], color: '#ff0000'}]}\n")
    plan = SvgPlan(bounds_of(world_shapes(ROOM)), ratio=50)
    plan.draw([*world_shapes(room), *items("wall"), *items("movable")])
    assert [group.get("id") for group in ElementTree.fromstring(plan.data()) if "id" in group.attrib] == [
        "things", "walls", "things-2",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("door", "swing_deg"), [("{}", 90.0), ("{limit_deg: 60}", 60.0), ("{angle_deg: -100}", -100.0)]
)
def test_a_door_is_drawn_with_a_swing_that_it_can_have(door, swing_deg):
    opening = f"{{name: gate, segment: 0, at: 3, width: 1, door: {door}}}"
    room = parse_world(f"mjsim: 1\nwalls: [{{points: [[0, 0], [8, 0]], openings: [{opening}]}}]\n")
    assert swing(room, leaves(room)[0]) == swing_deg


def test_pictures_and_svg_show_the_same_wall():
    view = PlanView.fit([[-1, -1], [9, 7]], 500, 400)
    image = np.full((400, 500, 3), 255, np.uint8)
    Paper(image, view, Letters(), 6.0).draw(items("wall"))
    dark = view.world(np.argwhere((image == color("wall")).all(axis=-1))[:, ::-1])
    low, high = bounds_of(items("wall"))
    np.testing.assert_allclose([dark.min(axis=0), dark.max(axis=0)], [low, high], atol=1.5 / view.scale)


YARD = parse_world(
    """
mjsim: 1
walls:
  - points: [[0, 0], [4, 0], [4, 3]]
    openings: [{segment: 1, at: 1, width: 0.8, sill: 0.9}, {segment: 0, at: 1, width: 1}]
obstacles:
  - {name: crate, box: [1, 0.5, 0.8], at: [1, 1], heading_deg: 30}
  - {name: shelf, box: [1, 0.5, 0.3], at: [2, 2], elevation: 1.5}
  - {name: cart, cylinder: [0.3, 1.5], at: [3, 1], movable: true, mass: 5}
  - {name: ramp, ramp: [2, 1, 0.2], at: [6, 1], heading_deg: 90}
  - {name: stairs, steps: [1.2, 0.8, 0.6], count: 3, at: [8, 1], heading_deg: 180}
  - {name: walker, cylinder: [0.2, 1.6], at: [6, 4], path: {points: [[8, 4], [8, 6]], speed: 0.5}}
"""
)


def test_things_are_drawn_as_they_stand_by_how_they_move_and_how_high_they_are():
    drawn = {(item.of, item.role): item for item in world_shapes(YARD) if item.kind == "area" and not item.symbol}
    roles = {"crate": "obstacle", "shelf": "hanging", "cart": "movable", "ramp": "obstacle", "stairs": "obstacle"}
    for thing in YARD.obstacles:
        if thing.name in roles:
            (part,) = drawn[thing.name, roles[thing.name]].placed(0.01)
            assert shapely.Polygon(part).symmetric_difference(shapely.Polygon(footprint(thing))).area < 1e-9, thing.name
    # What is lower than the section is paler.
    assert {name: drawn[name, role].level for name, role in roles.items()} == {
        "crate": 0.6,
        "shelf": 1.0,
        "cart": 1.0,
        "ramp": 0.6,
        "stairs": 0.6,
    }


def test_ramps_and_steps_show_their_treads_and_the_way_up():
    shapes = [item for item in world_shapes(YARD) if item.of in ("ramp", "stairs")]
    (treads,) = [item.placed(0.01) for item in shapes if item.role == "tread"]
    # Three steps of 0.4 m, from the lower end at 8.6 m.
    assert sorted(float(part[:, 0].mean()) for part in treads) == pytest.approx([7.8, 8.2])
    np.testing.assert_allclose([np.ptp(part[:, 1]) for part in treads], 0.8)
    for name, (start, end) in {"ramp": ((6, 0.16), (6, 1.84)), "stairs": ((8.504, 1), (7.496, 1))}.items():
        way, head = [item for item in shapes if item.of == name and item.role == "way up"]
        np.testing.assert_allclose(way.placed(0.01)[0], [start, end], atol=1e-9)
        assert (head.place.x, head.place.y) == pytest.approx(end)


def test_a_window_is_a_line_in_its_opening_and_a_doorway_none():
    ((pane,),) = [item.placed(0.01) for item in world_shapes(YARD) if item.role == "window"]
    np.testing.assert_allclose(pane, [[4, 1], [4, 1.8]])


def test_a_route_has_an_arrow_in_the_middle_of_each_way():
    line, *arrows = [item for item in world_shapes(YARD) if item.role == "route"]
    assert line.placed(0.01)[0].tolist() == [[6, 4], [8, 4], [8, 6]]
    assert [(each.place.x, each.place.y) for each in arrows] == [(7, 4), (8, 5)]
    np.testing.assert_allclose([each.place.heading for each in arrows], [0.0, np.pi / 2])
