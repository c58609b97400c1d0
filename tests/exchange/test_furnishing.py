"""Furniture of a drawing: boxes and cylinders around outlines of known sizes, and their names."""

import math

import numpy as np
import pytest

from mjsim.exchange.drawings.furnishing import HEIGHT, Outline, _name_of, distinct_outlines, thing_of
from mjsim.geometry import Pose


def rectangle(length: float, width: float, pose: Pose) -> np.ndarray:
    return pose.transform(np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * (length / 2, width / 2))


def round_table(radius: float, count: int) -> np.ndarray:
    angles = np.arange(count) * math.tau / count
    return np.array([2.0, 1.0]) + radius * np.stack([np.cos(angles), np.sin(angles)], axis=-1)


@pytest.mark.parametrize(
    ("length", "width", "heading_deg", "expected"),
    [
        (1.6, 0.8, 0, (0, 1.6, 0.8)),
        (0.8, 1.6, 0, (90, 1.6, 0.8)),
        (1.6, 0.8, 35, (35, 1.6, 0.8)),
        (1.6, 0.8, -60, (-60, 1.6, 0.8)),
    ],
)
def test_a_rectangle_is_a_box_whose_longer_side_is_its_length(length, width, heading_deg, expected):
    points = rectangle(length, width, Pose(3.0, -2.0, math.radians(heading_deg)))
    found = thing_of(Outline(points, "desk"), height=0.7, number=4)
    assert (found.name, found.at, found.box) == ("desk-4", (3.0, -2.0), pytest.approx((*expected[1:], 0.7)))
    assert math.remainder(found.heading_deg - expected[0], 180.0) == pytest.approx(0.0, abs=0.02)


def test_a_nearly_square_thing_is_set_straight_where_the_straight_box_is_hardly_larger():
    # 3 degrees aside, a square of 1 m has a straight box of 1.10 m^2; 10 degrees aside, of 1.34.
    straight, turned = (
        thing_of(Outline(rectangle(1.0, 1.0, Pose(0, 0, math.radians(deg))), "a"), height=1.0, number=1)
        for deg in (3, 10)
    )
    side = math.cos(math.radians(3)) + math.sin(math.radians(3))
    assert straight.box[:2] == pytest.approx((side, side), abs=1e-3)
    assert math.remainder(straight.heading_deg, 90.0) == 0.0
    assert turned.box[:2] == pytest.approx((1.0, 1.0), abs=1e-3)
    assert math.remainder(turned.heading_deg - 10.0, 90.0) == pytest.approx(0.0, abs=0.02)


def test_many_corners_at_one_distance_are_a_cylinder_and_few_are_not():
    found = thing_of(Outline(round_table(0.6, 24), "table"), height=HEIGHT, number=1)
    assert (found.at, found.cylinder) == ((2.0, 1.0), pytest.approx((0.6, HEIGHT)))
    assert not hasattr(thing_of(Outline(round_table(0.6, 8), "t"), height=1.0, number=1), "cylinder")
    oval = round_table(0.6, 24) * (1.0, 0.9)
    assert not hasattr(thing_of(Outline(oval, "t"), height=1.0, number=1), "cylinder")


@pytest.mark.parametrize(
    ("points", "is_thing"),
    [
        (rectangle(6.0, 1.0, Pose(0, 0, 0)), True),
        (rectangle(6.1, 1.0, Pose(0, 0, 0)), False),
        (rectangle(0.1, 0.1, Pose(0, 0, 0)), True),
        (rectangle(0.09, 0.09, Pose(0, 0, 0)), False),
        (rectangle(1.0, 0.02, Pose(0, 0, 0)), True),
        (rectangle(1.0, 0.018, Pose(0, 0, 0)), False),
        (rectangle(1.0, 0.0, Pose(0, 0, 0)), False),
        (round_table(0.031, 24), True),
        (round_table(0.03, 24), False),
        (round_table(3.1, 24), False),
    ],
)
def test_what_is_too_large_or_too_small_is_no_furniture(points, is_thing):
    assert (thing_of(Outline(points, "a"), height=1.0, number=1) is not None) == is_thing


def test_of_an_outline_in_another_the_larger_stays_and_of_equal_ones_the_first():
    table, plate = rectangle(2.0, 1.0, Pose(0, 0, 0)), rectangle(0.3, 0.3, Pose(0.2, 0, 0))
    beside, same = rectangle(0.5, 1.0, Pose(1.1, 0, 0)), rectangle(2.0, 1.0, Pose(0, 0, 0))
    outlines = [Outline(points, name) for points, name in ((plate, "p"), (table, "t"), (beside, "b"), (same, "s"))]
    # Of what stands beside, a third lies inside: 0.15 m of 0.5 m.
    assert [each.name for each in distinct_outlines(outlines)] == ["t", "b"]


@pytest.mark.parametrize(
    ("block", "name"),
    [
        ("Desk 160x80", "desk-160x80"),
        ("Stuhl (rund)!", "stuhl-rund"),
        ("A$C1234abc", ""),
        ("*U-12-chair", ""),
        ("12-ab-34", ""),
        ("x" * 31 + "yz", "x" * 31 + "y"),
    ],
)
def test_a_block_gives_its_name_as_far_as_one_of_a_world_has_it(block, name):
    assert _name_of(block) == name
