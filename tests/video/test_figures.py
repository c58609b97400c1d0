"""People on the sheet: from the right and from above, to scale, in the posture that they have."""

import numpy as np
import pytest

from mjsim.posture import poses_of, seated
from mjsim.video import draw_world
from mjsim.video.people_figures import person_view
from mjsim.world import look_beside, look_over, parse_world

STANDING = """mjsim: 1
people: [{name: anna, sex: female, at: [2, 1], heading_deg: 130, joints_deg: {right_shoulder_flexion: 90}}]
"""
SITTING = """mjsim: 1
obstacles:
  - {name: chair, box: [0.4, 0.5, 0.4], at: [1, 0], heading_deg: 90, seat: {at: [0, 0, 0.49], back_deg: 10}}
  - {name: desk, box: [0.5, 1.2, 0.7], at: [1, 0.75], heading_deg: 90, targets: [{grip: key, at: [-0.2, 0, 0.72]}]}
people: [{name: anna, sex: female, seat: chair, hands: {left: desk.key}}]
"""


def views_of(world):
    (person,) = world.people
    poses = poses_of(world, person)
    return person, poses, *(person_view(world, person, poses, look(poses)) for look in (look_beside, look_over))


def test_from_the_right_a_figure_is_as_tall_as_its_stature_and_reaches_ahead_as_far_as_its_arm():
    person, poses, beside, over = views_of(parse_world(STANDING))
    np.testing.assert_allclose(beside.bounds[:, 1], [0.0, person.figure.measures["stature"]], atol=1e-3)
    tip = person.figure.spots(poses)["right_fingertip"]
    for view in (beside, over):
        assert view.bounds[1, 0] == pytest.approx(np.hypot(*(tip[:2] - (2.0, 1.0))), abs=0.05)
    assert np.ptp(over.bounds[:, 1]) == pytest.approx(person.figure.measures["bideltoid_breadth"], abs=0.08)


def test_from_the_right_the_right_arm_is_in_front_and_from_above_the_head():
    _, _, beside, over = views_of(parse_world(STANDING.replace("right_shoulder_flexion: 90", "")))
    (person,) = parse_world(STANDING).people
    skin = person.colors.skin
    assert beside.body[-1][1] == skin  # the hand, which hangs farthest to the right
    assert over.body[-1][1] == skin
    middle = np.mean(over.body[-1][0], axis=0)
    assert np.hypot(*middle) < 0.12


@pytest.mark.slow
def test_the_sheet_has_people_below_the_plan():
    with_anna = draw_world(parse_world(STANDING))
    top = with_anna[:, : with_anna.shape[1] // 3]
    rows = np.flatnonzero((top < 200).all(axis=-1).any(axis=1))
    # 1 : 20 at 200 dots an inch; the head is drawn below the sheet of the plan alone.
    assert with_anna.shape[0] > 1.6 / 20 / 0.0254 * 200 + rows[0]


@pytest.mark.slow
def test_who_sits_is_drawn_with_hands_on_their_targets_and_solved_once():
    world = parse_world(SITTING)
    _, _, beside, _ = views_of(world)
    assert beside.targets == pytest.approx(np.array([[0.55, 0.72]]), abs=0.25)
    hands = [outline for outline, color in beside.body if color == world.people[0].colors.skin]
    near = min(np.min(np.linalg.norm(outline - beside.targets[0], axis=1)) for outline in hands)
    assert near < 0.05
    assert len(beside.things) == 2
    again = parse_world(SITTING)
    assert seated(again, again.people[0]) is seated(world, world.people[0])
    other = parse_world(SITTING.replace("0.72]", "0.75]"))
    assert seated(other, other.people[0]) is not seated(world, world.people[0])
