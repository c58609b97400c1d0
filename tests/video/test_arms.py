"""Arms are seen on plans, as sheets and in films, where their links are."""

import math
from dataclasses import replace

import numpy as np
import pytest

from mjsim.plan.plan_items import link_outline, shadows
from mjsim.video import PAPER, Letters, draw_world
from mjsim.video.paper import Paper
from mjsim.video.plan_parts import world_bounds
from mjsim.video.plan_view import PlanView
from mjsim.video.run_plan import PlanState
from mjsim.world import View, parse_world
from tests.video.test_video_frame import NOW

ROOM = """
mjsim: 1
walls: [{points: [[0, 0], [4, 0], [4, 4], [0, 4]], closed: true}]
robots:
  - name: r
    base: fixed
    at: [2, 2]
    heading_deg: 90
    arms: [{ARM}]
"""
ARM = '{name: arm, color: "#0000ff", dh: {rows: [{a: 0.8}, {a: 0.6}]}, start_deg: [0, 90]}'


def test_links_are_seen_from_above_the_lowest_first():
    item = parse_world(ROOM.replace("{ARM}", ARM)).robots[0].arms[0]
    links, tool = shadows(item, np.radians([0.0, 90.0]))
    np.testing.assert_allclose(links[:, :4], [[0, 0, 0.8, 0], [0.8, 0, 0.8, 0.6]], atol=1e-12)
    np.testing.assert_allclose(tool, [0.8, 0.6], atol=1e-12)


def test_an_outline_goes_round_a_link():
    edge = link_outline(np.array([0.0, 0.0, 2.0, 0.0, 0.1]))
    np.testing.assert_allclose(np.abs(edge[:, 1]).max(), 0.1, atol=1e-3)
    assert edge[:, 0].min() == pytest.approx(-0.1, abs=1e-3)
    assert edge[:, 0].max() == pytest.approx(2.1, abs=1e-3)
    closed = np.vstack([edge, edge[:1]])
    area = 0.5 * float(np.sum(closed[:-1, 0] * closed[1:, 1] - closed[1:, 0] * closed[:-1, 1]))
    assert area == pytest.approx(2.0 * 0.2 + math.pi * 0.01, rel=0.01)


def is_blue(color) -> bool:
    """Whether a colour is rather that of the arm than paper, ink or the robot."""
    red, _, blue = (int(part) for part in color)
    return blue > red + 60


def test_a_film_shows_an_arm_where_its_joints_are_now():
    world = parse_world(ROOM.replace("{ARM}", ARM))
    view = PlanView.fit(world_bounds(world), 400, 400, margin=10)
    image = np.full((400, 400, 3), PAPER, np.uint8)
    here = np.array([2.0, 2.0, np.pi / 2])
    moment = replace(NOW, others={}, truth=here, arms={"r/arm": np.array([0.0, 0.0])})
    shapes = PlanState(world, "r", View(sightings=False, ellipses=False)).moving(moment)
    Paper(image, view, Letters(), 6.0).draw(shape for shape in shapes if shape.role in ("link", "tool"))
    column, row = np.rint(view.pixels(np.array([2.0, 3.1]))).astype(int)
    assert is_blue(image[row, column])
    column, row = np.rint(view.pixels(np.array([1.7, 2.8]))).astype(int)
    assert tuple(image[row, column]) == PAPER


@pytest.mark.slow
def test_the_sheet_shows_an_arm_as_it_begins():
    with_arm = draw_world(parse_world(ROOM.replace("{ARM}", ARM)), names=False)
    without = draw_world(parse_world(ROOM.replace("    arms: [{ARM}]\n", "")), names=False)
    changed = (with_arm != without).any(axis=2)
    rows, columns = np.nonzero(changed)
    assert sum(is_blue(color) for color in with_arm[changed]) > 1000
    # 0.6 m of the second link and two radii of 0.056 m against 0.8 m of the first and as much.
    assert np.ptp(columns) / np.ptp(rows) == pytest.approx(0.71 / 0.91, abs=0.12)
