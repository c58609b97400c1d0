"""How far hands reach: measures of the survey, targets, and envelopes."""

import math

import numpy as np
import pytest

from mjsim.ergonomics import reach_envelope, target_reach
from mjsim.people import Figure, Measures
from mjsim.posture import Goals, Seating, Sitter
from mjsim.world import parse_world, placed_targets

TARGETS = """
mjsim: 1
obstacles:
  - name: board
    box: [0.1, 2, 0.05]
    at: [0, 0]
    targets:
      - {grip: near, at: [0.4, 0.2, 0.7]}
      - {grip: beside, at: [0.4, -0.2, 0.7]}
      - {grip: leaning, at: [0.95, 0.0, 0.9]}
      - {grip: far, at: [3, 0, 1]}
      - {sight: clock, at: [3, 0, 1]}
"""


@pytest.fixture(scope="module")
def sitter():
    pose = np.eye(4)
    pose[:3, 3] = (0.0, 0.0, 0.5)
    figure = Figure.of(Measures.at_percentile("male", 50.0))
    return Sitter(figure, Seating(world_from_seat=pose, back=math.radians(5.0)))


@pytest.mark.slow
def test_targets_are_reached_reached_by_leaning_or_out_of_reach_by_their_distance(sitter):
    placed = placed_targets(parse_world(TARGETS))
    near, beside, leaning, far, clock = (target_reach(sitter, Goals(), each) for each in placed)
    assert (near.short, near.limb) == (0.0, "left")
    assert (beside.short, beside.limb) == (0.0, "right")
    assert leaning.short > 0.05
    assert leaning.leaning == 0.0
    assert 1.0 < far.leaning < far.short < 2.5
    assert clock is None


@pytest.mark.slow
def test_ahead_of_the_shoulder_the_envelope_is_as_long_as_the_arm_and_a_little_of_the_trunk(sitter):
    envelope = reach_envelope(sitter, Goals(), "right", touch="fist", azimuths=np.zeros(1), elevations=np.zeros(1))
    spots = sitter.figure.landmarks
    arm = -sitter.figure.segments["right_forearm"].at[2] - sitter.figure.segments["right_hand"].at[2]
    arm += float(np.linalg.norm(spots["right_grip"].at))
    # The chest stays on the backrest, and the trunk turns about it.
    assert arm - 0.01 < envelope.distances.item() < arm + 0.25
