"""One frame of the film: everything where the numbers say, in the colour of the legend."""

from dataclasses import replace

import numpy as np
import pytest

from mjsim.errors import UsageError
from mjsim.interface import Sighting
from mjsim.video import Letters
from mjsim.video.film_frame import Frame, PlanFrame, draw_seen
from mjsim.video.ink import ESTIMATE, MUTED, ODOMETRY, SEEN, TRUTH
from mjsim.video.moment import Moment
from mjsim.video.picture_layout import HEIGHT, MARGIN, WIDTH, arrange
from mjsim.video.plan_parts import world_bounds
from mjsim.video.plan_view import PlanView
from mjsim.world import Looks, View, parse_world

TEXT = """
mjsim: 1
name: hall
walls: [{points: [[0, 0], [8, 0], [8, 5], [0, 5]], closed: true}]
robots:
  - {name: scout, at: [1, 1], sensors: [{camera: front}]}
  - {name: other, at: [7, 4]}
run: {seconds: 10}
"""
HALL = parse_world(TEXT)
VIEW = PlanView.fit(world_bounds(HALL), WIDTH, HEIGHT, margin=MARGIN)
PICTURE = np.full((480, 640, 3), 90, np.uint8)
CORNERS = np.array([[100.0, 80.0], [300.0, 90.0], [300.0, 290.0], [100.0, 280.0]])
SIGHTING = Sighting(0.0, "lion", 2.0, 0.5, np.eye(2), CORNERS)
NOW = Moment(
    time=0.0,
    truth=np.array([2.0, 2.0, 0.0]),
    estimate=np.array([4.0, 3.0, 1.5]),
    covariance=np.diag([0.04, 0.01, 0.001]),
    odometry=np.array([6.0, 1.5, 0.0]),
    names=("lion",),
    means=np.array([[6.0, 3.5]]),
    covariances=np.array([np.diag([0.0025, 0.04])]),
    sightings=(SIGHTING,),
    picture=PICTURE,
    others={"other": np.array([7.0, 4.0, 1.5])},
    touched=False,
)


def plan_of(moment, **look):
    return PlanFrame(HALL, "scout", display=View(**look)).draw(moment)


def places_of(image, color, near):
    """Return world points of a colour's pixels within 1 m of a point."""
    rows, columns = np.nonzero((image == color).all(axis=-1))
    points = VIEW.world(np.stack([columns, rows], axis=-1))
    return points[np.hypot(*(points - near).T) < 1.0]


@pytest.mark.parametrize(
    ("color", "place"), [(TRUTH, (2.0, 2.0)), (ESTIMATE, (4.0, 3.0)), (MUTED, (7.0, 4.0))], ids=["true", "est", "other"]
)
def test_each_robot_stands_where_it_is_in_its_colour(color, place):
    points = places_of(plan_of(NOW, ellipses=False, sightings=False), color, place)
    # Headings stick out of the middle; the middle of a disc's extents is its centre but for those.
    assert np.abs((points.min(axis=0) + points.max(axis=0)) / 2 - place).max() < 0.06
    assert np.ptp(points[:, 0]) == pytest.approx(2 * 0.22, abs=0.04)


@pytest.mark.parametrize(
    ("middle", "variances"), [((4.0, 3.0), (0.04, 0.01)), ((6.0, 3.5), (0.0025, 0.04))], ids=["pose", "landmark"]
)
def test_ellipses_hold_95_percent(middle, variances):
    with_it, without = plan_of(NOW, sightings=False), plan_of(NOW, sightings=False, ellipses=False)
    rows, columns = np.nonzero((with_it != without).any(axis=-1))
    offsets = VIEW.world(np.stack([columns, rows], axis=-1)) - middle
    offsets = offsets[np.hypot(*offsets.T) < 0.8]
    # Chi-square with two degrees of freedom: 95 % lie within 5.991; 2 px for the width of the line.
    reach = np.sqrt(5.991 * np.array(variances))
    np.testing.assert_allclose(np.abs(offsets).max(axis=0), reach, atol=2 / VIEW.scale)


def test_a_sighting_is_a_line_as_long_as_it_was_measured():
    image, bare = plan_of(NOW, ellipses=False), plan_of(NOW, ellipses=False, sightings=False)
    rows, columns = np.nonzero((image != bare).any(axis=-1))
    points = VIEW.world(np.stack([columns, rows], axis=-1)) - NOW.estimate[:2]
    far = points[np.hypot(*points.T).argmax()]
    assert np.hypot(*far) == pytest.approx(2.0, abs=2 / VIEW.scale)
    assert np.arctan2(far[1], far[0]) == pytest.approx(1.5 + 0.5, abs=0.02)


def test_trails_stay_where_the_robot_was():
    frame = PlanFrame(HALL, "scout", display=View(ellipses=False, sightings=False))
    for x in np.linspace(1.0, 3.0, 60):
        last = replace(NOW, truth=np.array([x, 1.0, 0.0]), odometry=np.array([x, 4.0, 0.0]))
        frame.add(last)
    image = frame.draw(last)
    for color, y, wide in ((ODOMETRY, 4.0, 1), (None, 1.0, 5)):
        column, row = np.rint(VIEW.pixels((2.0, y))).astype(int)
        changed = (image[row - 9 : row + 10, column] != plan_of(NOW)[row - 9 : row + 10, column]).any(axis=-1)
        assert wide <= changed.sum() <= wide + 4  # smooth edges
        assert color is None or (np.abs(image[row - 2 : row + 3, column].astype(int) - color).sum(-1) < 120).any()


def test_without_trails_there_are_none():
    frame = PlanFrame(HALL, "scout", display=View(trails=False))
    for x in np.linspace(1.0, 2.0, 30):
        frame.add(replace(NOW, truth=np.array([x, 2.0, 0.0])))
    np.testing.assert_array_equal(frame.draw(NOW), plan_of(NOW))


@pytest.mark.parametrize(("follow", "color"), [("truth", TRUTH), ("estimate", ESTIMATE)])
def test_the_close_up_follows_the_given_robot(follow, color):
    moment = replace(NOW, estimate=np.array([5.0, 3.0, 0.0]), truth=np.array([3.5, 2.5, 0.0]))
    frame = Frame(HALL, display=View(follow=follow, ellipses=False, sightings=False))
    box = arrange(world_bounds(HALL), camera=4 / 3).close_up
    part = frame.draw(moment)[box.y : box.y + box.height, box.x : box.x + box.width]
    rows, columns = np.nonzero((part == color).all(axis=-1))
    middle = np.array([columns.min() + columns.max(), rows.min() + rows.max()]) / 2
    # The heading of the estimate reaches out of its ring by half a radius.
    np.testing.assert_allclose(middle, (box.width / 2, box.height / 2), atol=8)


def test_recognised_beacons_are_outlined_at_their_corners():
    image = np.zeros((360, 480, 3), np.uint8)
    draw_seen(image, NOW, Letters())
    for corner in (CORNERS + 0.5) * 0.75 - 0.5:
        column, row = np.rint(corner).astype(int)
        assert (image[row - 1 : row + 2, column - 1 : column + 2] == SEEN).all(axis=-1).any()
    assert (image[200, 150] == 90).all()


def test_the_error_of_now_is_written_and_its_curve_drawn():
    frame = Frame(HALL)
    for k in range(100):
        offset = np.array([0.01 * k, 0.0, 0.0])
        last = replace(NOW, time=0.1 * k, estimate=NOW.truth + offset / 2, odometry=NOW.truth + offset)
        frame.add(last)
    box = arrange(world_bounds(HALL), camera=4 / 3).chart
    part = frame.draw(last)[box.y : box.y + box.height, box.x : box.x + box.width]
    tops = [np.nonzero((part[44:] == color).all(axis=-1))[0].min() for color in (ODOMETRY, ESTIMATE)]
    bottom = part.shape[0] - 44 - 24
    # The estimate errs half as much as odometry.
    assert (bottom - tops[1]) / (bottom - tops[0]) == pytest.approx(0.5, abs=0.08)


@pytest.mark.parametrize("size", [(8, 5), (40, 3), (4, 30)], ids=["usual", "wide", "tall"])
@pytest.mark.parametrize("camera", [None, 4 / 3, 16 / 9, 0.5])
def test_parts_of_every_layout_stand_apart_inside_the_picture(size, camera):
    layout = arrange(np.array([[0.0, 0.0], size]), camera=camera)
    covered = np.zeros((HEIGHT, WIDTH), int)
    for box in (layout.plan, layout.close_up, layout.chart, layout.onboard):
        if box is not None:
            assert box.width >= 160
            assert box.height >= 100
            assert box.x + box.width <= WIDTH - MARGIN
            assert box.y + box.height <= HEIGHT - MARGIN
            covered[box.y : box.y + box.height, box.x : box.x + box.width] += 1
    assert covered.max() == 1


@pytest.mark.parametrize("follow", ["truth", "estimate", "nothing"])
def test_a_robot_without_driver_and_camera_is_drawn_where_it_truly_is(follow):
    world = parse_world(TEXT.replace(", sensors: [{camera: front}]", ""))
    nothing = np.full(3, np.nan)
    alone = replace(NOW, estimate=nothing, odometry=nothing, covariance=np.full((3, 3), np.nan), picture=None)
    frame = Frame(world, display=View(follow=follow))
    for k in range(10):
        frame.add(replace(alone, time=0.04 * k))
    assert (frame.draw(alone) == TRUTH).all(axis=-1).sum() > 500


def test_a_robot_that_is_not_there_is_named():
    with pytest.raises(UsageError, match="no robot 'scut' to show in this world; did you mean 'scout'"):
        Frame(HALL, "scut")


MOVING = parse_world(
    """
mjsim: 1
walls:
  - points: [[0, 0], [8, 0], [8, 5], [0, 5]]
    closed: true
    openings: [{name: gate, segment: 0, at: 3, width: 1, door: {color: "#ff00ff"}}]
obstacles:
  - {box: [1, 1, 1], at: [2, 3], color: "#ff0000", name: cart, path: {points: [[6, 3]]}}
  - {box: [1, 1, 1], at: [4, 4], color: "#0000ff", name: rack}
lamps: [{name: spot, at: [1, 1]}]
robots: [{name: scout, at: [1, 2]}, {name: other, at: [7, 4]}]
"""
)


def test_movers_doors_and_lamps_stand_where_they_are_now_and_what_was_taken_away_does_not():
    view = PlanView.fit(world_bounds(MOVING), WIDTH, HEIGHT, margin=MARGIN)
    frame = PlanFrame(MOVING, "scout", display=View())

    def color(image, place):
        column, row = np.rint(view.pixels(np.array(place))).astype(int)
        return image[row, column].astype(int)

    first = frame.draw(replace(NOW, sightings=())).copy()
    looks = Looks(1.0, {"spot": 0.0}, frozenset({"rack"}))
    things = {"obstacle/cart": np.array([5.0, 1.5, 0.0]), "door/gate": np.array([3.0, 0.0, np.pi / 2])}
    later = frame.draw(replace(NOW, sightings=(), things=things, looks=looks)).copy()
    floor = color(first, (7.3, 1.3))
    for image, place, there in [
        (first, (2.2, 3.2), True),
        (later, (2.2, 3.2), False),
        (first, (5.2, 1.2), False),
        (later, (5.2, 1.2), True),
        (first, (4.2, 4.2), True),
        (later, (4.2, 4.2), False),
        (first, (3.5, 0.0), True),
        (first, (3.0, 0.5), False),
        (later, (3.0, 0.5), True),
        (first, (1.0, 1.0), True),
    ]:
        assert (np.abs(color(image, place) - floor).max() > 20) == there, place
    # The lamp that is off is pale.
    assert color(later, (1.0, 1.0)).min() > 240


def test_a_robot_that_is_lifted_leaves_no_trail():
    frame = PlanFrame(HALL, "scout", display=View(sightings=False, ellipses=False))
    for x, y in ((2.0, 2.0), (2.0, 2.5), (6.0, 1.0), (6.0, 1.5)):
        frame.add(replace(NOW, truth=np.array([x, y, 0.0]), odometry=np.full(3, np.nan), estimate=np.full(3, np.nan)))
    image = frame.draw(replace(NOW, truth=np.array([1.0, 4.0, 0.0]), means=np.zeros((0, 2)), names=()))
    plain = PlanFrame(HALL, "scout", display=View(sightings=False, ellipses=False)).draw(
        replace(NOW, truth=np.array([1.0, 4.0, 0.0]), means=np.zeros((0, 2)), names=())
    )
    changed = np.nonzero((image != plain).any(axis=-1))
    places = VIEW.world(np.stack(changed[::-1], axis=-1))
    # On both stretches, and nowhere on the way between.
    assert (
        (np.abs(places - (2.0, 2.25)) < (0.1, 0.4)).all(axis=1) | (np.abs(places - (6.0, 1.25)) < 0.4).all(axis=1)
    ).all()
    assert len(places) > 100
