"""People in worlds: each mistake is one line that says where, what is wrong, and what would be right."""

import math

import numpy as np
import pytest

from mjsim.errors import WorldError
from mjsim.world import check_world, format_world, parse_world

GOOD = """mjsim: 1
people:
  - {name: anna, sex: female, percentile: 5, at: [1, 2], heading_deg: 90, joints_deg: {left_elbow_flexion: 90}}
  - {name: bob, sex: male, measures: {stature: 1.9, weight: 90}, at: [2, 2], colors: {top: "#336699"}}
"""
HIS = "name: a, sex: male, at: [0, 0]"

MALFORMED = {
    "another sex": ("name: a, sex: other, at: [0, 0]", "25: sex is 'other'; it must be 'female' or 'male'"),
    "no sex": ("name: a, at: [0, 0]", "10: key 'sex' is missing"),
    "no place": ("name: a, sex: male", "10: a person stands at a place or sits on a seat; add at: [x, y]"),
    "no name": ("sex: male, at: [0, 0]", "10: key 'name' is missing"),
    "a percentile below the table": (f"{HIS}, percentile: 0.5", "55: percentile is 0.5; it must be at least 1"),
    "a percentile as text": (f"{HIS}, percentile: p5", "55: percentile is 'p5'; it must be a number"),
    "a percentile that is not a number": (
        f"{HIS}, percentile: .nan",
        "55: percentile is nan; it must be a finite number",
    ),
    "a proportion above the table": (f"{HIS}, proportion: 100", "55: proportion is 100; it must be at most 99"),
    "a corpulence below the table": (f"{HIS}, corpulence: -1", "55: corpulence is -1; it must be at least 1"),
    "percentile and measures": (
        f"{HIS}, percentile: 5, measures: {{stature: 1.8}}",
        "55: a person is given by percentile or by measures; leave out one of them",
    ),
    "a misspelt measure": (
        f"{HIS}, measures: {{statur: 1.8}}",
        "62: no measure 'statur'; did you mean 'stature'?",
    ),
    "a measure in centimetres": (
        f"{HIS}, measures: {{stature: 180}}",
        "63: stature is 180 m; of men it lies between 1.41 and 2.1 m",
    ),
    "a measure as text": (f"{HIS}, measures: {{stature: tall}}", "63: stature is 'tall'; it must be a number"),
    "measures in a list": (f"{HIS}, measures: [1.8]", "53: measures is [1.8]; it must be keys with values"),
    "measures of nobody": (
        f"{HIS}, measures: {{stature: 1.6, cervicale_height: 1.5}}",
        "63: stature is 1.6 m; beside the other measures it lies between 1.68 and 1.8 m",
    ),
    "a measure that a figure does not keep": (
        f"{HIS}, measures: {{span: 1.8}}",
        "60: the model of a person does not reproduce span: the shoulder blades move inwards",
    ),
    "corpulence beside a weight": (
        f"{HIS}, measures: {{weight: 80}}, corpulence: 70",
        "53: corpulence is 70, but weight is given; leave out one of them",
    ),
    "proportion beside a sitting height": (
        f"{HIS}, measures: {{sitting_height: 0.9}}, proportion: 70",
        "53: proportion is 70, but sitting_height is given; leave out one of them",
    ),
    "a joint that is not there": (
        f"{HIS}, joints_deg: {{left_knee: 5}}",
        "67: no joint 'left_knee'; did you mean 'left_knee_flexion'?",
    ),
    "a joint bent backwards": (
        f"{HIS}, joints_deg: {{left_knee_flexion: -5}}",
        "75: left_knee_flexion is -5 degrees; its range is 0 to 140",
    ),
    "an angle that is not a number": (
        f"{HIS}, joints_deg: {{left_knee_flexion: .inf}}",
        "75: left_knee_flexion is inf; it must be a finite number",
    ),
    "a name of the scene": ("name: wall, sex: male, at: [0, 0]", "17: 'wall' is a reserved name in the scene"),
    "a name with a slash": ("name: a/b, sex: male, at: [0, 0]", "17: name is 'a/b'; it must be a name of letters"),
    "a misspelt key": (f"{HIS}, percentil: 3", "43: unknown key 'percentil'; did you mean 'percentile'?"),
    "clothes that are not there": (f"{HIS}, colors: {{hat: red}}", "52: unknown key 'hat'"),
    "a colour by name": (f"{HIS}, colors: {{top: red}}", "57: top is 'red'; it must be a colour"),
    "a place in space": ("name: a, sex: male, at: [0, 0, 1]", "35: at is [0, 0, 1]; it must be [x, y]"),
}


@pytest.mark.parametrize(("text", "said"), MALFORMED.values(), ids=MALFORMED)
def test_a_malformed_person_is_one_line(text, said):
    with pytest.raises(WorldError) as caught:
        parse_world(f"mjsim: 1\npeople: [{{{text}}}]\n", file="w.yaml")
    lines = str(caught.value).splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("w.yaml:2:" + said.partition(":")[0] + ":"), lines[0]
    assert said.partition(":")[2] in lines[0]


def test_a_name_is_given_once():
    with pytest.raises(WorldError, match="name 'anna' is taken by people"):
        parse_world(GOOD.replace("bob", "anna"))


def test_people_read_back_equal():
    world = parse_world(GOOD)
    assert parse_world(format_world(world)) == world


def test_a_person_stands_on_the_floor_whatever_the_joints():
    for bent in ("left_elbow_flexion: 90", "left_hip_flexion: 60, left_knee_flexion: 90", "left_ankle_flexion: -30"):
        (anna, _) = parse_world(GOOD.replace("left_elbow_flexion: 90", bent)).people
        spots = anna.figure.spots(anna.poses())
        soles = [spot for name, spot in spots.items() if name.endswith(("_heel", "_ball", "_toe"))]
        assert min(spot[2] for spot in soles) == pytest.approx(0.0, abs=1e-12)
        np.testing.assert_allclose(spots["h_point"][:2], [1.0, 2.0], atol=1e-12)
        assert spots["glabella"][1] > spots["occiput"][1] + 0.15


FLOORS = """mjsim: 1
obstacles:
  - {name: ramp, ramp: [4, 2, 0.7], at: [2, 0]}
  - {name: platform, box: [4, 2, 0.35], at: [2, 4]}
  - {name: stairs, steps: [0.9, 2, 0.45], at: [6, 0]}
  - {name: table, box: [2, 2, 0.74], at: [9, 0]}
  - {name: crate, box: [1, 1, 0.3], at: [12, 0], movable: true}
people: [{name: anna, sex: female, percentile: 50, WHERE}]
"""


def soles(where):
    """Return the person, and how high heels, balls and toes are above the floor, left ones first [m]."""
    (anna,) = parse_world(FLOORS.replace("WHERE", where)).people
    spots = anna.figure.spots(anna.poses())
    places = [spots[f"{side}_{part}"] for side in ("left", "right") for part in ("heel", "ball", "toe")]
    return anna, np.array(places)


@pytest.mark.parametrize("heading", [0, 45, 90, 180, -90])
def test_whole_soles_are_on_a_ramp_whichever_way_one_looks(heading):
    anna, places = soles(f"at: [1.5, 0], heading_deg: {heading}")
    np.testing.assert_allclose(places[:, 2], 0.7 * places[:, 0] / 4, atol=1e-12)
    assert anna.poses()["thorax"][2, 2] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("where", "height"),
    [
        ("at: [2, 4]", 0.35),  # a platform
        ("at: [6, 0], heading_deg: 90", 0.30),  # the second of three steps
        ("at: [9, 0]", 0.0),  # a table is in the way
        ("at: [9, 0], elevation: 0.74", 0.74),
        ("at: [12, 0]", 0.0),  # what can be pushed is in the way too
        ("at: [2, 0], elevation: 0", 0.0),
    ],
)
def test_soles_are_as_high_as_what_is_below(where, height):
    np.testing.assert_allclose(soles(where)[1][:, 2], height, atol=1e-12)


def test_one_foot_on_a_step_bends_its_knee_and_joints_that_are_given_stay():
    at = "at: [6.15, 0], heading_deg: 90"  # the right foot is on the third step, the left one on the second
    _, places = soles(at)
    np.testing.assert_allclose(places[:, 2], [0.3] * 3 + [0.45] * 3, atol=1e-12)
    _, stiff = soles(f"{at}, joints_deg: {{right_knee_flexion: 0}}")
    assert stiff[0, 2] == pytest.approx(0.45)
    assert stiff[3, 2] == pytest.approx(0.45)


def test_who_stands_on_a_ramp_is_not_inside_it_and_who_stands_in_a_table_is():
    told = [check_world(parse_world(FLOORS.replace("WHERE", where))) for where in ("at: [1.5, 0]", "at: [9, 0]")]
    assert [len(problems) for problems in told] == [0, 1]
    assert "stands inside obstacle 'table'" in str(told[1][0])


def test_arms_hang_beside_the_hips_and_joints_that_are_given_are_kept():
    anna, bob = parse_world(GOOD).people
    names = list(anna.figure.joints)
    assert anna.posture()[names.index("left_elbow_flexion")] == pytest.approx(math.pi / 2)
    spots = bob.figure.spots(bob.poses())
    assert spots["left_fingertip"][1] > spots["left_hip_side"][1]


@pytest.mark.slow
def test_who_stands_in_a_wall_or_in_another_is_named():
    wall = "walls: [{points: [[0, 2], [3, 2]], height: 1}]\n"
    told = [str(problem) for problem in check_world(parse_world(GOOD + wall))]
    assert told == [
        "world.yaml:3:50: person 'anna' at [1, 2] stands inside walls[0]; move one of them",
        "world.yaml:4:70: person 'bob' at [2, 2] stands inside walls[0]; move one of them",
    ]
    near, _ = check_world(parse_world(GOOD.replace("[2, 2]", "[1.2, 2]")))
    assert "person 'anna' at [1, 2] stands inside person 'bob'; move one of them" in str(near)


def test_a_robot_that_starts_inside_a_person_is_named():
    (problem,) = check_world(parse_world(GOOD + "robots: [{name: r1, at: [1, 2.2]}]\n"))
    assert "robot 'r1' at [1, 2.2] starts inside person 'anna'" in str(problem)
