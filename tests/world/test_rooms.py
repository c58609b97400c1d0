"""Rooms are what walls enclose once doors and windows are closed, up to the faces of the walls."""

import pytest

from mjsim.world import parse_world, room_polygons

TWO = """
mjsim: 1
walls:
  - {points: [[0, 0], [8, 0], [8, 5], [0, 5]], closed: true, thickness: 0.2, openings: [{at: 1, width: 1}]}
  - {points: [[3, 0], [3, 5]], openings: [{at: 2, width: 1}]}
"""


def test_a_house_of_two_rooms_has_their_areas_between_the_faces():
    west, east = room_polygons(parse_world(TWO).walls)
    assert west.area == pytest.approx((3 - 0.1 - 0.05) * 4.8)
    assert east.area == pytest.approx((5 - 0.1 - 0.05) * 4.8)


def test_walls_that_enclose_nothing_make_no_room():
    assert room_polygons(parse_world("mjsim: 1\nwalls: [{points: [[0, 0], [4, 0], [4, 3]]}]\n").walls) == []
    assert room_polygons(()) == []


def test_a_house_within_a_yard_is_no_part_of_it():
    yard = """
mjsim: 1
walls:
  - {points: [[0, 0], [10, 0], [10, 10], [0, 10]], closed: true, thickness: 0.1}
  - {points: [[4, 4], [6, 4], [6, 6], [4, 6]], closed: true, thickness: 0.1}
"""
    outer, inner = room_polygons(parse_world(yard).walls)
    assert outer.area == pytest.approx(9.9**2 - 2.1**2)
    assert inner.area == pytest.approx(1.9**2)
