"""The studio draws what all plans show: shapes of its items are those of the display list, placed by themselves."""

import math

import numpy as np
import pytest

from mjsim.plan import world_shapes
from mjsim.web.worlds.items import scene_of
from mjsim.world import parse_world
from tests.plan.test_plan import ROOM

THINGS = parse_world(
    """
mjsim: 1
walls: [{points: [[0, 0], [9, 3]], openings: [{at: 2, width: 1, sill: 0.9}, {at: 5, width: 1, door: {angle_deg: 30}}]}]
obstacles:
  - {name: ramp, ramp: [2, 1, 0.3], at: [3, 5], heading_deg: 30, color: "#336699"}
  - {name: bus, box: [1, 0.5, 0.5], at: [1, 4], heading_deg: 45, path: {points: [[4, 4]], speed: 0.5}}
floor: {patches: [{name: mat, at: [6, 6], size: [1, 2], heading_deg: 20}]}
beacons: [{name: post, at: [4, 4], width: 0.1, image: null}]
robots: [{name: arm, base: fixed, at: [6, 5], heading_deg: 70, arms: [{preset: puma560}]}]
"""
)


def moved(points, x, y, heading_deg):
    c, s = math.cos(math.radians(heading_deg)), math.sin(math.radians(heading_deg))
    return np.asarray(points) @ [[c, s], [-s, c]] + (x, y)


def same(some, others):
    """Whether points are the same; the page is told them to a tenth of a millimetre."""
    return np.shape(some) == np.shape(others) and np.allclose(some, others, atol=2e-4)


def drawn(item, metres):
    """Yield each part of an item with its role, world frame, as the page places it."""
    polygons = iter(item["polygons"])
    own = (*(item["at"] or (0, 0)), item["heading_deg"] or 0)
    for shape in item["shapes"]:
        for part in [next(polygons) for _ in range(shape["count"])] if "count" in shape else shape["parts"]:
            if "anchor" in shape:
                part = moved(np.multiply(part, metres), *shape["anchor"])
            yield shape["role"], part if "count" in shape else moved(part, *own)
    assert not list(polygons)


@pytest.mark.parametrize("world", [ROOM, THINGS])
def test_shapes_of_items_are_those_of_the_display_list(world):
    metres = 0.02
    found = [each for item in scene_of(world)["items"] for each in drawn(item, metres)]
    for shape in world_shapes(world):
        for part in [] if shape.least and shape.role != "robot" else shape.placed(metres):
            at = next(k for k, (role, points) in enumerate(found) if role == shape.role and same(points, part))
            del found[at]
    # What is wider on paper than in the world is drawn by an outline; gaps are shown in the studio alone.
    assert {role for role, _ in found} <= {"gap", "beacon", "marker", "reflector"}


def test_what_moves_has_the_frame_it_moves_with():
    (gate,) = (item for item in scene_of(ROOM)["items"] if item["kind"] == "opening")
    assert [(each["role"], each.get("fixed"), each.get("carrier")) for each in gate["shapes"]] == [
        ("gap", True, None),
        ("swing", True, None),
        ("leaf", None, [3.0, 0.0, 0.0]),
    ]
    (cart,) = (item for item in scene_of(ROOM)["items"] if item["name"] == "cart")
    assert not any("fixed" in each or "carrier" in each for each in cart["shapes"])
