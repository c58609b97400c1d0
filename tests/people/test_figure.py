"""The body of a figure: masses by the tables, joints within ranges, and where its segments are."""

import itertools
import math

import numpy as np
import pytest

from mjsim.mechanics import is_valid, tensor
from mjsim.people import SEXES, SIDES, Figure, Measures
from mjsim.people.deleva import SHARES
from mjsim.people.surface import surfaces

ENDS = {
    "upper_arm": ("left_upper_arm", "left_forearm"),
    "forearm": ("left_forearm", "left_hand"),
    "thigh": ("left_thigh", "left_shank"),
    "shank": ("left_shank", "left_foot"),
}


def spot(name):
    return lambda spots, poses: spots[name]


def origin(name):
    return lambda spots, poses: poses[name][:3, 3]


SPOTS = {
    "thorax": (spot("suprasternale"), origin("thorax"), 2),
    "abdomen": (origin("thorax"), origin("abdomen"), 2),
    "pelvis": (origin("abdomen"), spot("h_point"), 2),
    "hand": (origin("left_hand"), spot("left_fingertip"), 2),
    "foot": (spot("left_heel"), spot("left_toe"), 0),
}
"""Endpoints of the other segments but the head, and the axis along which they are measured."""


@pytest.mark.parametrize("sex", SEXES)
def test_masses_and_centres_are_those_of_the_tables_and_add_up_to_the_weight(sex):
    figure = Figure.of(Measures.at_percentile(sex, 95, corpulence=90))
    weight = figure.measures["weight"]
    assert sum(each.solid.mass for each in figure.segments.values()) == pytest.approx(weight)
    poses = figure.poses()
    for name, share in SHARES[sex].items():
        if name != "head":
            segment = name if name in figure.segments else f"left_{name}"
            assert figure.segments[segment].solid.mass == pytest.approx(share.mass * weight, rel=2e-4), name
    spots = figure.spots(poses)
    for name, (upper, lower, axis) in SPOTS.items():
        ends = [each[axis] for each in (upper(spots, poses), lower(spots, poses))]
        segment = name if name in figure.segments else f"left_{name}"
        found = poses[segment][:3, 3] + figure.segments[segment].solid.center
        assert found[axis] == pytest.approx(ends[0] + SHARES[sex][name].center * (ends[1] - ends[0])), name
    for name, (upper, lower) in ENDS.items():
        center = poses[upper][:3, 3] + np.array(figure.segments[upper].solid.center)
        wanted = poses[upper][:3, 3] + SHARES[sex][name].center * (poses[lower][:3, 3] - poses[upper][:3, 3])
        np.testing.assert_allclose(center, wanted, atol=1e-9)


def test_neck_and_head_together_are_the_head_of_the_table():
    figure = Figure.of(Measures.at_percentile("male", 50))
    share, poses = SHARES["male"]["head"], figure.poses()
    parts = [(figure.segments[name].solid, poses[name][:3, 3]) for name in ("neck", "head")]
    mass = sum(solid.mass for solid, _ in parts)
    center = sum(solid.mass * (origin + solid.center) for solid, origin in parts) / mass
    stature, cervicale = figure.measures["stature"], figure.measures["cervicale_height"]
    assert mass == pytest.approx(share.mass * figure.measures["weight"])
    assert center[2] == pytest.approx(stature - share.center * (stature - cervicale))
    about = np.zeros((3, 3))
    for solid, origin in parts:
        r = origin + solid.center - center
        about += tensor(solid.inertia) + solid.mass * (r @ r * np.eye(3) - np.outer(r, r))
    radii = np.array([share.sagittal, share.transverse, share.longitudinal]) * (stature - cervicale)
    np.testing.assert_allclose(about, np.diag(mass * radii**2), atol=1e-12)


def test_all_segments_of_all_bodies_are_rigid_bodies():
    for sex, *rest in itertools.product(SEXES, (1, 99), (1, 99), (1, 99)):
        percentile, proportion, corpulence = rest
        measures = Measures.at_percentile(sex, percentile, proportion=proportion, corpulence=corpulence)
        assert all(is_valid(each.solid) for each in Figure.of(measures).segments.values())


def test_joints_turn_the_way_that_their_names_tell():
    figure = Figure.of(Measures.at_percentile("female", 50))
    rest = figure.spots(figure.poses())

    def moved(joint, mark):
        return (figure.spots(figure.poses(figure.values({joint: 0.3})))[mark] - rest[mark]).tolist()

    assert moved("lumbar_flexion", "vertex")[0] > 0.05
    assert moved("neck_bend", "vertex")[1] > 0.01
    assert moved("head_twist", "glabella")[1] > 0.01
    for side, out in (("left", 1.0), ("right", -1.0)):
        tip, toe = f"{side}_fingertip", f"{side}_toe"
        assert moved(f"{side}_shoulder_flexion", tip)[0] > 0.1
        assert out * moved(f"{side}_shoulder_abduction", tip)[1] > 0.1
        assert out * moved(f"{side}_shoulder_rotation", f"{side}_thumb_tip")[1] < -0.005
        assert moved(f"{side}_elbow_flexion", tip)[0] > 0.1
        assert out * moved(f"{side}_forearm_pronation", f"{side}_thumb_tip")[1] < -0.005
        assert out * moved(f"{side}_wrist_flexion", tip)[1] < -0.03
        assert moved(f"{side}_wrist_deviation", tip)[0] > 0.03
        assert moved(f"{side}_hip_flexion", toe)[0] > 0.1
        assert out * moved(f"{side}_hip_abduction", toe)[1] > 0.1
        assert out * moved(f"{side}_hip_rotation", toe)[1] < -0.03
        assert moved(f"{side}_knee_flexion", toe)[0] < -0.1
        assert moved(f"{side}_ankle_flexion", toe)[2] > 0.03


def test_poses_vectorise_over_leading_axes():
    figure = Figure.of(Measures.at_percentile("male", 5))
    low, high = figure.limits.T
    values = np.random.default_rng(0).uniform(low, high, (4, len(low)))
    many = figure.poses(values)
    for row in range(4):
        one = figure.poses(values[row])
        for name in figure.segments:
            found = np.broadcast_to(many[name], (4, 4, 4))[row]
            np.testing.assert_allclose(found, one[name], atol=1e-12)


def test_both_sides_mirror_each_other_and_every_range_holds_zero_and_has_a_source():
    figure = Figure.of(Measures.at_percentile("male", 50))
    angles = {joint.name: 0.5 * (joint.low + joint.high) for joint in figure.joints.values() if "_" in joint.name}
    spots = figure.spots(figure.poses(figure.values({k: v for k, v in angles.items() if k.split("_")[0] in SIDES})))
    for name in spots:
        if name.startswith("left_"):
            mirrored = spots[name.replace("left_", "right_")] * [1, -1, 1]
            np.testing.assert_allclose(spots[name], mirrored, atol=1e-12)
    for joint in figure.joints.values():
        assert joint.low <= 0.0 <= joint.high
        assert joint.source
        assert max(-joint.low, joint.high) <= math.pi


def test_a_joint_that_is_not_there_is_named():
    figure = Figure.of(Measures.at_percentile("male", 50))
    with pytest.raises(ValueError, match="no joint 'left_knee'; did you mean 'left_knee_flexion'"):
        figure.values({"left_knee": 1.0})


@pytest.mark.parametrize("sex", SEXES)
def test_the_skin_of_each_segment_is_around_its_centre_of_mass(sex):
    figure = Figure.of(Measures.at_percentile(sex, 50))
    for name, meshes in surfaces(figure).items():
        points = np.concatenate([mesh.vertices for mesh in meshes])
        center = np.array(figure.segments[name].solid.center)
        assert (points.min(axis=0) < center).all(), name
        assert (center < points.max(axis=0)).all(), name
