"""Where postures go through things, and what is meant to touch."""

import mujoco
import pytest

from mjsim.compile import compile_world
from mjsim.ergonomics import Clearance, clearances, collisions
from mjsim.world import parse_world

WORLD = """mjsim: 1
obstacles:
  - {name: chair, box: [0.4, 0.5, 0.4], at: [0, 0], seat: {at: [0, 0, 0.49], back_deg: 10}}
  - {name: desk, box: [0.6, 1.2, 0.3], at: [0.6, 0], elevation: 0.4, targets: [{grip: key, at: [-0.2, 0.1, 0.35]}]}
people: [{name: anna, sex: female, seat: chair, hands: {left: desk.key}}]
"""


def test_what_presses_or_is_held_is_meant_and_only_the_deepest_of_the_rest_is_told():
    (anna,) = parse_world(WORLD).people
    through = Clearance("left_thigh", "desk/top", -0.05)
    found = [
        Clearance("pelvis", "chair", -0.04),
        Clearance("left_hand", "desk", -0.03),
        Clearance("left_thigh", "desk/drawer", -0.02),
        through,
        Clearance("right_thigh", "desk/top", -0.009),
        Clearance("right_hand", "desk", -0.02),
        Clearance("head", "lamp", 0.1),
    ]
    assert collisions(found, anna) == [through, found[5]]


@pytest.mark.slow
def test_thighs_go_through_a_desk_that_hangs_too_low():
    world = parse_world(WORLD)
    model = compile_world(world).compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    found = collisions(clearances(model, data, "anna", count=1), world.people[0])
    assert {"left_thigh", "right_thigh"} <= {each.segment for each in found}
    assert all(each.thing == "desk" and each.distance < -0.1 for each in found if each.segment.endswith("thigh"))
