"""People who sit: what they name is there, and everything else is refused in one line."""

import numpy as np
import pytest

from mjsim.errors import WorldError
from mjsim.world import format_world, parse_world

DESK = """
mjsim: 1
obstacles:
  - name: desk
    box: [0.8, 1.6, 0.72]
    at: [0.8, 0]
    targets: [{grip: key, at: [-0.3, 0.1, 0.74]}, {pedal: rest, at: [-0.3, 0, 0.1]}, {sight: clock, at: [2, 0, 1]}]
  - {name: chair, box: [0.5, 0.5, 0.45], at: [1, 2], heading_deg: 90, seat: {at: [0, 0, 0.54]}}
people:
"""


def world_of(*people):
    return parse_world(DESK + "".join(f"  - {{{keys}}}\n" for keys in people), file="w.yaml")


def test_a_seated_person_reads_back_equal_and_is_at_the_seat():
    world = world_of(
        "name: a, sex: male, seat: chair, hands: {left: desk.key}, feet: {right: desk.rest}, gaze: desk.key"
    )
    assert parse_world(format_world(world)) == world
    place = world.people[0].place()
    np.testing.assert_allclose([place.x, place.y, place.heading], [1.0, 2.0, np.pi / 2], atol=1e-9)


@pytest.mark.parametrize(
    ("keys", "wrong"),
    [
        ("", "a person stands at a place or sits on a seat; add at: [x, y] or seat: THING"),
        ("seat: chir", "no thing 'chir' in this world; did you mean 'chair'?"),
        ("seat: desk", "'desk' is not a seat; give it seat: {at: [x, y, z]}"),
        ("seat: chair, at: [1, 1]", "leave out 'at'"),
        ("seat: chair, heading_deg: 20", "leave out 'heading_deg'"),
        ("seat: chair, joints_deg: {left_knee_flexion: 20}", "leave out 'joints_deg'"),
        ("at: [3, 3], hands: {left: desk.key}", "'hands' is for seated people"),
        ("at: [3, 3], feet: {left: desk.rest}", "'feet' is for seated people"),
        ("at: [3, 3], gaze: desk.clock", "'gaze' is for seated people"),
        ("seat: chair, hands: {left: desk.kex}", "no target 'kex' on 'desk'; did you mean 'key'?"),
        ("seat: chair, hands: {left: desc.key}", "no thing 'desc' in this world; did you mean 'desk'?"),
        ("seat: chair, hands: {left: desk.rest}", "'desk.rest' is a pedal; it must be a grip"),
        ("seat: chair, feet: {left: desk.clock}", "'desk.clock' is a sight; it must be a pedal"),
        ("seat: chair, hands: {middle: desk.key}", "unknown key 'middle'"),
        ("seat: chair, hands: {left: key}", "it must be THING.TARGET"),
        ("seat: chair, hands: desk.key", "hands"),
        ("seat: chair, gaze: [1, 2, 3]", "gaze"),
        ("seat: 3", "seat"),
    ],
)
def test_what_is_wrong_with_one_who_sits_is_one_line(keys, wrong):
    with pytest.raises(WorldError) as caught:
        world_of(f"name: a, sex: male, {keys}".removesuffix(", "))
    (line,) = str(caught.value).splitlines()
    assert line.startswith("w.yaml:10:")
    assert wrong in line


def test_a_seat_holds_one_person():
    with pytest.raises(WorldError, match="'a' sits on 'chair' already; name another seat"):
        world_of("name: a, sex: male, seat: chair", "name: b, sex: female, seat: chair")
