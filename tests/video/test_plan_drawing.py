"""The plan of a world: to scale, with doorways open and names that do not cover each other."""

import numpy as np
import pytest

from mjsim.plan import color, paint_of, world_shapes
from mjsim.video import INK, Letters
from mjsim.video.ink import BEACON
from mjsim.video.paper import Paper
from mjsim.video.plan_parts import draw_scale_bar, floor_color, world_bounds
from mjsim.video.plan_view import PlanView, format_metres, round_step
from mjsim.world import parse_world

ROOM = parse_world(
    """
mjsim: 1
name: room
walls:
  - points: [[0, 0], [8, 0], [8, 6], [0, 6]]
    closed: true
    thickness: 0.2
    openings:
      - {segment: 0, at: 3, width: 1}
      - {segment: 2, at: 2, width: 2, sill: 0.9, head: 2.0}
obstacles: [{box: [1, 1, 1], at: [6, 4], color: "#0000ff", name: crate}]
beacons: [{name: lion, image: posters/lion.jpg, at: [0.11, 3], heading_deg: 0, width: 1}]
robots: [{name: scout, at: [2, 2]}]
"""
)


@pytest.fixture(scope="module")
def drawn():
    """The room and the view in which it is drawn."""
    view = PlanView.fit(world_bounds(ROOM), 850, 650, margin=15)
    image = np.empty((view.height, view.width, 3), np.uint8)
    image[:] = floor_color(ROOM)
    Paper(image, view, Letters(), 6.0).draw(world_shapes(ROOM))
    return image, view


def color_at(drawn, x, y):
    image, view = drawn
    column, row = np.rint(view.pixels((x, y))).astype(int)
    return tuple(image[row, column].tolist())


def test_pixels_go_back_to_the_world_points_they_came_from():
    view = PlanView.fit([[-3, 2], [5, 9]], 640, 480, margin=10)
    points = np.random.default_rng(0).uniform(-10, 10, (100, 2))
    np.testing.assert_allclose(view.world(view.pixels(points)), points, atol=1e-12)


def test_the_whole_world_fits_in_the_middle_with_its_margin():
    view = PlanView.fit([[0, 0], [8, 4]], 200, 200, margin=20)
    assert view.scale == 20.0
    # Edges of pixels lie half a pixel before their centres.
    np.testing.assert_allclose(view.pixels([[0, 4], [8, 0]]) + 0.5, [[20, 60], [180, 140]])


def test_a_part_of_a_view_shows_the_same_places():
    view = PlanView.fit([[0, 0], [8, 4]], 200, 200)
    np.testing.assert_allclose(view.part(30, 50, 40, 40).pixels((5, 2)), view.pixels((5, 2)) - (30, 50))


def test_walls_are_drawn_to_scale(drawn):
    image, view = drawn
    row = round(float(view.pixels((0, 5.5))[1]))
    dark = np.flatnonzero((image[row] == color("wall")).all(axis=-1))
    # From the outer face of one wall to that of the other: 8 m and twice half of 0.2 m.
    assert np.ptp(dark) + 1 == pytest.approx(8.2 * view.scale, abs=1.5)


def test_a_doorway_is_open_and_a_window_is_light(drawn):
    assert color_at(drawn, 2.5, 0.05) == color("wall")
    assert color_at(drawn, 3.3, 0.05) == floor_color(ROOM)
    assert color_at(drawn, 5.0, 6.0) == color("glass")
    assert color_at(drawn, 5.0, 6.06) == paint_of("low wall").fill


def test_obstacles_have_their_own_colour_calmed(drawn):
    assert color_at(drawn, 6.3, 4.3) == paint_of("obstacle", tint="#0000ff").fill


def test_a_beacon_is_a_stroke_as_wide_as_it_is_with_a_tick_to_where_it_faces(drawn):
    image, view = drawn
    rows, columns = np.nonzero((image == BEACON).all(axis=-1))
    assert np.ptp(rows) == pytest.approx(1.0 * view.scale, abs=6)  # its round ends are 5 px wide
    ahead = view.world((columns.max(), rows[columns.argmax()]))
    np.testing.assert_allclose(ahead, (0.11, 3.0), atol=12 / view.scale)  # the tick is 1.4 mm long, 8 px
    assert ahead[0] > 0.15


def test_text_has_the_width_that_it_is_measured_with_and_ends_where_it_should():
    image, letters = np.full((40, 300, 3), 255, np.uint8), Letters()
    letters.write(image, "Position 0.123 m", (280, 25), 14, INK, align=1.0)
    columns = np.flatnonzero((image < 200).any(axis=(0, 2)))
    assert columns.max() == pytest.approx(280, abs=2)
    assert np.ptp(columns) == pytest.approx(letters.width("Position 0.123 m", 14), abs=3)


@pytest.mark.parametrize(("least", "step"), [(0.9, 1.0), (1.0, 1.0), (1.1, 2.0), (2.1, 5.0), (0.03, 0.05), (51, 100)])
def test_steps_of_scales_are_round(least, step):
    assert round_step(least) == pytest.approx(step)


def test_numbers_have_the_decimals_of_their_step():
    assert [format_metres(-1.0, 0.05), format_metres(20.0, 5.0)] == ["\N{MINUS SIGN}1.00", "20"]


def test_the_scale_bar_is_as_long_as_it_says():
    image = np.full((40, 400, 3), 255, np.uint8)
    draw_scale_bar(image, 37.0, Letters(), (380, 30))
    row = image[23]  # along the upper edge of the bar
    assert np.ptp(np.flatnonzero((row == INK).all(axis=-1))) == 2 * 37


def test_a_beacon_on_an_obstacle_hangs_where_that_stands_and_one_on_a_robot_moves_with_it():
    world = parse_world(
        """
mjsim: 1
obstacles: [{box: [1, 1, 1], at: [3, 2], heading_deg: 90, name: crate}]
beacons:
  - {name: lion, at: [0.5, 0.2], heading_deg: 10, on: crate}
  - {name: tag, at: [-0.2, 0], on: scout}
robots: [{name: scout, at: [6, 4]}]
"""
    )
    shapes = {(shape.of, shape.role): shape for shape in world_shapes(world)}
    lion, tag = shapes["lion", "reflector"], shapes["tag", "reflector"]
    np.testing.assert_allclose((lion.place.x, lion.place.y), (3 - 0.2, 2 + 0.5), atol=1e-12)
    assert np.degrees(lion.place.heading) == pytest.approx(100)
    assert (lion.frame, tag.frame) == ("", "robot/scout")
