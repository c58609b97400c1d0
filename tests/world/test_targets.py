"""Seats and targets of things: written, read back, placed in the world, and refused in one line."""

import numpy as np
import pytest

from mjsim.errors import WorldError
from mjsim.world import DisplayTarget, format_world, parse_world, placed_targets, world_from_seat

DESK = """
mjsim: 1
obstacles:
  - name: desk
    box: [0.8, 1.6, 0.72]
    at: [3, 1]
    heading_deg: 90
    targets:
      - {grip: keys, at: [-0.3, 0, 0.74], touch: finger}
      - {pedal: rest, at: [0, 0.1, 0.1]}
      - {display: screen, at: [0.2, 0, 1.0], size: [0.5, 0.3], pitch_deg: 10}
      - {sight: clock, at: [2, 0, 2]}
  - {name: chair, box: [0.5, 0.5, 0.45], at: [3, 0], seat: {at: [0, 0, 0.54], back_deg: 10, travel: [0.1, 0.12]}}
"""


def test_a_world_with_seats_and_targets_reads_back_equal():
    world = parse_world(DESK)
    assert parse_world(format_world(world)) == world


def test_targets_and_seats_stand_where_their_things_do():
    world = parse_world(DESK)
    places = {each.name: each.world_from_target for each in placed_targets(world)}
    assert list(places) == ["desk.keys", "desk.rest", "desk.screen", "desk.clock"]
    np.testing.assert_allclose(places["desk.keys"][:3, 3], [3.0, 0.7, 0.74], atol=1e-12)
    np.testing.assert_allclose(world_from_seat(world.obstacles[1])[:3, 3], [3.0, 0.0, 0.54], atol=1e-12)


def test_a_display_faces_back_along_its_thing_and_up_by_its_pitch():
    screen = next(each for each in placed_targets(parse_world(DESK)) if isinstance(each.target, DisplayTarget))
    facing = screen.world_from_target[:3, 0]
    np.testing.assert_allclose(facing, [0.0, -np.cos(np.radians(10)), np.sin(np.radians(10))], atol=1e-12)
    np.testing.assert_allclose(
        screen.world_from_target[:3, :3] @ screen.world_from_target[:3, :3].T, np.eye(3), atol=1e-12
    )
    assert np.linalg.det(screen.world_from_target[:3, :3]) == pytest.approx(1.0)


def test_a_thing_without_a_seat_is_no_place_to_sit():
    with pytest.raises(ValueError, match="'desk' is not a seat"):
        world_from_seat(parse_world(DESK).obstacles[0])


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("targets: [{at: [0, 0, 1]}]", "a target needs a kind"),
        ("targets: [{grip: a.b, at: [0, 0, 1]}]", "a.b"),
        ("targets: [{grip: a, at: [0, 0]}]", "it must be [x, y, z]"),
        ("targets: [{grip: a, at: [0, 0, 1], touch: nose}]", "nose"),
        ("targets: [{display: a, at: [0, 0, 1]}]", "size"),
        ("targets: [{display: a, at: [0, 0, 1], size: [0, 1]}]", "above 0"),
        ("targets: [{grip: a, at: [0, 0, 1]}, {pedal: a, at: [0, 0, 0]}]", "name 'a' is taken by another target"),
        ("seat: {back_deg: 10}", "at"),
        ("seat: {at: [0, 0, 1], back_deg: 90}", "back_deg is 90"),
        ("seat: {at: [0, 0, 1], travel: [2, 0]}", "the travel of a seat is at most 1 m"),
        ("seat: {at: [0, 0, 1], travel: [-1, 0]}", "-1"),
    ],
)
def test_what_is_wrong_with_a_seat_or_a_target_is_one_line(text, wrong):
    with pytest.raises(WorldError) as caught:
        parse_world(f"mjsim: 1\nobstacles: [{{box: [1, 1, 1], at: [0, 0], {text}}}]\n", file="w.yaml")
    (line,) = str(caught.value).splitlines()
    assert line.startswith("w.yaml:2:")
    assert wrong in line
