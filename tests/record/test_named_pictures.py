"""A recording keeps the pictures that its world names."""

from mjsim.record.recording_writer import named_pictures
from mjsim.world import parse_world

WORLD = """
mjsim: 1
walls: [{points: [[0, 0], [3, 0]], texture: materials/plaster.jpg}]
ceiling: {texture: materials/ceiling_panels.jpg}
floor: {texture: floors/oak.jpg, patches: [{at: [1, 1], size: [1, 1], texture: floors/tiles.jpg}]}
obstacles:
  - {box: [1, 1, 1], at: [2, 2], texture: materials/wood.jpg}
  - {sphere: 0.2, at: [4, 2]}
  - {model: furniture/chair.xml, at: [6, 2]}
  - {cylinder: [0.1, 1], at: [5, 5]}
beacons: [{name: lion, image: posters/lion.jpg, at: [1, 0.1]}]
"""


def test_the_pictures_of_all_surfaces_and_beacons_are_named_once():
    assert set(named_pictures(parse_world(WORLD))) == {
        "materials/plaster.jpg",
        "materials/ceiling_panels.jpg",
        "floors/oak.jpg",
        "floors/tiles.jpg",
        "materials/wood.jpg",
        "posters/lion.jpg",
    }
