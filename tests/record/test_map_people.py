"""People in the map of a recording."""

import pytest

import mjsim
from mjsim.record.drawn.map import map_update


@pytest.mark.slow
def test_the_map_shows_people_where_there_are_some():
    room = mjsim.parse_world("mjsim: 1\n")
    world = mjsim.parse_world("mjsim: 1\npeople: [{name: anna, sex: female, at: [1, 2]}]\n")
    assert b"person/anna" in map_update(world, {}).encode()
    assert b"person/" not in map_update(room, {}).encode()
