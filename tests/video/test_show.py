"""The sheet of paper that `mjsim show` draws: to scale, on A4, with names that do not cover each other."""

import struct
from itertools import combinations

import cv2
import numpy as np
import pytest

from mjsim.errors import UsageError
from mjsim.plan import Words, arc, color, leaf_path
from mjsim.video import INK, draw_world, take_picture
from mjsim.video.ink import BEACON
from mjsim.video.paper import DPI, blank, px
from mjsim.video.placed_names import write_words
from mjsim.video.plan_view import PlanView
from mjsim.video.sheet import A4, scale_for
from mjsim.world import leaves, parse_world

ROOM = """
mjsim: 1
name: room
walls:
  - points: [[0, 0], [8, 0], [8, 6], [0, 6]]
    closed: true
    thickness: 0.2
    openings:
      - {name: door, segment: 0, at: 3, width: 1, door: {hinge: left}}
      - {segment: 2, at: 2, width: 2, sill: 0.9, head: 2.0}
beacons: [{name: lion, at: [0.11, 3], image: posters/lion.jpg}]
robots: [{name: scout, at: [2, 2]}]
"""


def room(more=""):
    return parse_world(ROOM + more)


def pixels_of(page, color):
    """Columns and rows of what has a colour, shape (n, 2)."""
    rows, columns = np.nonzero((page == color).all(axis=-1))
    return np.stack([columns, rows], axis=-1)


def metres_per_pixel(world):
    """By the scale that is written on the sheet: 1 m of it is 1000 / N mm."""
    low, high = np.array([-0.1, -0.1]), np.array([8.1, 6.1])
    return scale_for(np.stack([low, high])) / 1000 * 25.4 / DPI


@pytest.mark.slow
def test_the_sheet_is_drawn_at_the_scale_that_it_names():
    page = draw_world(room(), names=False)
    walls = pixels_of(page, color("wall"))
    across = np.ptp(walls, axis=0) + 1
    np.testing.assert_allclose(across * metres_per_pixel(room()), (8.2, 6.2), atol=0.03)


@pytest.mark.parametrize("size", [(3, 3), (60, 30), (30, 60), (200, 1), (0.5, 0.5), (1000, 700)])
def test_a_sheet_fits_on_a4_and_a_world_fills_at_least_half_of_its_length(size):
    wide, deep = size
    world = parse_world(f"mjsim: 1\nwalls: [{{points: [[0, 0], [{wide}, 0], [{wide}, {deep}], [0, {deep}]]}}]\n")
    height, width = np.array(draw_world(world).shape[:2]) * 25.4 / DPI
    assert any(width <= paper[0] + 0.2 and height <= paper[1] + 0.2 for paper in (A4, A4[::-1]))
    assert max(width / A4[0], height / A4[0], width / A4[1], height / A4[1]) > 0.5


def test_urdf_repair_are_round():
    for side in np.geomspace(0.5, 900, 40):
        ratio = scale_for(np.array([[0, 0], [side, side / 2]]))
        assert f"{ratio:g}".rstrip("0").replace(".", "") in {"1", "125", "15", "2", "25", "3", "4", "5", "6", "75"}


@pytest.mark.slow
def test_a_png_says_how_large_it_is_on_paper(tmp_path):
    page = draw_world(room(), tmp_path / "new" / "room.png")
    data = (tmp_path / "new" / "room.png").read_bytes()
    at = data.index(b"pHYs") + 4
    assert struct.unpack(">IIB", data[at : at + 9]) == (7874, 7874, 1)  # 200 dpi in pixels to the metre
    np.testing.assert_array_equal(cv2.imread(str(tmp_path / "new" / "room.png"))[..., ::-1], page)


def test_a_file_that_is_not_a_picture_is_refused(tmp_path):
    with pytest.raises(UsageError, match=r"name it \.png or \.jpg"):
        draw_world(room(), tmp_path / "room.bmp")


def test_an_empty_world_has_a_sheet_too():
    assert draw_world(parse_world("mjsim: 1")).size


@pytest.mark.slow
def test_names_are_written_near_what_they_name():
    named, bare = draw_world(room()), draw_world(room(), names=False)
    changed = np.stack(np.nonzero((named != bare).any(axis=-1))[::-1], axis=-1)
    lion, walls = pixels_of(bare, BEACON), pixels_of(bare, color("wall")).min(axis=0)
    lion = lion[lion[:, 1] < walls[1] + 6.2 / metres_per_pixel(room())].mean(axis=0)  # without the legend's
    assert np.hypot(*(changed - lion).T).min() < px(3)


@pytest.mark.slow
def test_names_in_a_crowd_never_cover_each_other_and_what_finds_no_place_is_left_out():
    drawing = blank(PlanView.around(5, 5, 100, 1000, 1000))
    rng = np.random.default_rng(0)
    tags = [
        Words(text=f"thing-{k}", at=at, side=np.array([0.0, -1.0]), reach=(0.05, 0.05))
        for k, at in enumerate(rng.uniform(3.5, 6.5, (150, 2)))
    ]
    boxes = write_words(drawing, tags)
    assert 50 < len(boxes) < 150
    for a, b in combinations(boxes, 2):
        assert (np.minimum(a[1], b[1]) <= np.maximum(a[0], b[0])).any()


def test_a_name_avoids_ink():
    drawing = blank(PlanView.around(5, 5, 100, 1000, 1000))
    drawing.fill([[4.0, 3.0], [6.0, 3.0], [6.0, 4.9], [4.0, 4.9]], INK)
    (box,) = write_words(drawing, [Words(text="well", at=np.array([5.0, 5.0]), side=np.array([0.0, -1.0]))])
    assert drawing.view.world(box)[:, 1].min() > 4.9 - 0.01


@pytest.mark.parametrize("hinge", ["left", "right"])
@pytest.mark.parametrize("angle", [-60, 90])
def test_a_door_swings_to_the_left_side_of_its_wall_by_positive_angles_whichever_end_it_hangs_from(hinge, angle):
    walls = f"""
mjsim: 1
walls:
  - points: [[1, 1], [1, 6]]
    openings: [{{at: 2, width: 0.9, door: {{hinge: {hinge}, angle_deg: {angle}}}}}]
"""
    (leaf,) = leaves(parse_world(walls))
    way = leaf_path(leaf, angle)
    hinge_y, free_y = (3.0, 3.9) if hinge == "left" else (3.9, 3.0)
    np.testing.assert_allclose(way[0], (1.0, free_y), atol=1e-9)
    np.testing.assert_allclose(np.hypot(*(way - (1.0, hinge_y)).T), 0.9, atol=1e-9)
    # The wall goes north, so its left side is the west.
    assert np.sign(1.0 - way[-1, 0]) == np.sign(angle)


@pytest.mark.slow
def test_windows_markers_reflectors_and_ways_have_their_colours():
    bare = draw_world(room(), names=False)
    # 2 m of glass, at 1 : 60 or larger, a pixel thick.
    assert len(pixels_of(bare, color("glass"))) > px(2000 * 2.0 / 60)
    routes = len(pixels_of(bare, color("muted")))
    path = "obstacles: [{sphere: 0.2, at: [5, 1.5], path: {points: [[7, 1.5]]}}]\n"
    assert len(pixels_of(draw_world(room(path), names=False), color("muted"))) > routes + 1.0 / metres_per_pixel(room())


def test_an_arc_keeps_its_distance_and_its_ends():
    points = arc((2.0, 1.0), 1.5, 0.0, -np.pi / 2)
    np.testing.assert_allclose(np.hypot(*(points - (2.0, 1.0)).T), 1.5)
    np.testing.assert_allclose(points[[0, -1]], [[3.5, 1.0], [2.0, -0.5]], atol=1e-12)


@pytest.mark.slow
def test_the_overview_shows_the_robot_from_outside_and_the_chase_view_shows_it_larger():
    world = room()
    red = []
    for view in ("overview", "scout/chase"):
        picture = take_picture(world, view).astype(int)
        assert picture.shape == (720, 1280, 3)
        red.append(np.count_nonzero((picture[..., 0] > 120) & (picture[..., 1] < 60) & (picture[..., 2] < 80)))
    assert 100 < red[0] < red[1] / 2


@pytest.mark.slow
def test_a_camera_with_a_latency_has_a_first_picture_too():
    camera = "{camera: front, at: [0.1, 0, 0.4], width: 160, height: 120, rate_hz: 12.5, latency: 2}"
    prompt, late = (
        parse_world(ROOM.replace("at: [2, 2]}", f"at: [2, 2], sensors: [{sensor}]}}"))
        for sensor in (camera.replace(", latency: 2", ""), camera)
    )
    first, delayed = take_picture(prompt, "scout/front"), take_picture(late, "scout/front")
    assert np.abs(first.astype(int) - delayed).mean() < 1.0


@pytest.mark.slow
def test_names_are_chosen_and_left_out_where_things_stand_close():
    none, walls, every = (draw_world(room(), labels=labels) for labels in ("none", "walls", "all"))
    assert (none == draw_world(room(), names=False)).all()
    assert (none != every).any()
    assert (walls != every).any()
    crowd = [
        f"  - {{name: box-{k}, box: [0.1, 0.1, 1], at: [{k % 20 * 0.2:.1f}, {k // 20 * 0.2:.1f}]}}" for k in range(400)
    ]
    world = parse_world("mjsim: 1\nobstacles:\n" + "\n".join(crowd))
    assert (draw_world(world) == draw_world(world, labels="none")).all()
    assert (draw_world(world) != draw_world(world, labels="all")).any()
