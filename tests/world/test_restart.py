"""Another start of a mechanism: where a hand pulls a joint, loops that follow, and the keys that are written."""

import math

import numpy as np
import pytest

import mjsim
from mjsim.world import free_columns, pulled_values, restarted, shows_motion

ABOVE = np.eye(4)[:3]
SIDE = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0]])
FOURBAR = """
mjsim: 1
mechanisms:
  - name: fourbar
    at: [1, 1]
    heading_deg: 90
    elevation: 4
    bodies: [{name: crank, rod: [1.0, 0.1]}, {name: coupler, rod: [3.5, 0.1]}, {name: rocker, rod: [3.0, 0.1]}]
    joints:
      - {revolute: q2, of: [ground, crank], axis: [0, 0, 1], start_deg: 30}
      - {revolute: q3, of: [crank.end, coupler]}
      - {revolute: q4, of: [{ground: [4, 0, 0]}, rocker]}
      - {revolute: q5, of: [coupler.end, rocker.end]}
"""
LED = FOURBAR + "    actuators: [{angle: q2, signal: {constant: {value_deg: 30}}}]\n"


def alone(joint, body="{name: rod, rod: [1.0, 0.1]}", **more):
    keys = "".join(f"    {key}: {value}\n" for key, value in more.items())
    text = f"mjsim: 1\nmechanisms:\n  - name: m\n    bodies: [{body}]\n    joints: [{joint}]\n{keys}"
    return mjsim.parse_world(text).mechanisms[0]


def fourbar(text=FOURBAR):
    return mjsim.parse_world(text).mechanisms[0]


def test_a_crank_goes_where_it_is_pulled_and_the_loop_follows():
    mechanism = fourbar()
    q2 = mechanism.joints[0]
    c, s = math.cos(math.radians(120)), math.sin(math.radians(120))  # of the crank in the world
    wanted = pulled_values(mechanism, q2, look=ABOVE, start=np.array([1 + c, 1 + s]), end=np.array([1.0, 3.0]))
    assert math.degrees(wanted[0]) == pytest.approx(0.0, abs=1e-6)  # beyond its reach: it points there
    begun = restarted(mechanism, {0: math.radians(90)})
    assert begun.keys == {(0, "start_deg"): 90.0}
    ends = begun.mechanism.poses()
    end = ends["coupler"] @ (3.5, 0, 0, 1)
    np.testing.assert_allclose(end, ends["rocker"] @ (3.0, 0, 0, 1), atol=1e-9)


def test_a_joint_that_follows_moves_the_one_that_the_text_gives():
    mechanism = fourbar()
    rocker = mechanism.assembly.column("q4")
    target = mechanism.assembly.start[rocker] + 0.1
    begun = restarted(mechanism, {rocker: target})
    assert list(begun.keys) == [(0, "start_deg")]
    # The crank is written to a hundredth of a degree.
    assert begun.mechanism.assembly.start[rocker] == pytest.approx(target, abs=2e-4)


def test_a_loop_that_cannot_close_says_by_how_much_it_misses():
    mechanism = fourbar()
    with pytest.raises(ValueError, match=r"^the loop at 'q5' does not close there: it misses by 0\.\d+ m"):
        restarted(mechanism, {mechanism.assembly.column("q4"): 0.0})


@pytest.mark.slow
def test_a_loop_keeps_its_shape_when_the_crank_goes_round():
    mechanism = fourbar()
    before = mechanism.assembly.start
    for degrees in range(60, 400, 40):
        mechanism = restarted(mechanism, {0: math.radians(degrees)}).mechanism
        step = mechanism.assembly.start - before
        assert np.abs(step).max() < math.radians(75), degrees
        before = mechanism.assembly.start


def test_what_an_actuator_leads_stays():
    mechanism = fourbar(LED)
    assert free_columns(mechanism) == set()
    with pytest.raises(ValueError, match="'q4' has a start prescribed by the actuators"):
        restarted(mechanism, {mechanism.assembly.column("q4"): 1.0})


@pytest.mark.parametrize("heading", [0, 70])
def test_a_slide_follows_the_hand_along_its_axis_alone(heading):
    slide = alone("{prismatic: j, of: [ground, rod], axis: [1, 1, 0], range: [-1, 1]}", heading_deg=heading)
    along = math.radians(45 + heading)
    way = np.array([math.cos(along), math.sin(along)])
    across = np.array([-way[1], way[0]])
    for far, where in ((0.4, 0.4), (3.0, 1.0)):  # within its range
        found = pulled_values(slide, slide.joints[0], look=ABOVE, start=0.1 * way, end=(0.1 + far) * way + 0.7 * across)
        assert found == {0: pytest.approx(where, abs=1e-9)}
    assert restarted(slide, {0: 0.4}).keys == {(0, "start"): 0.4}


def test_a_hinge_about_a_level_axis_is_pulled_from_the_side_and_does_not_show_from_above():
    hinge = alone("{revolute: j, of: [ground, rod], axis: [0, 1, 0]}", elevation=2)
    joint = hinge.joints[0]
    assert not shows_motion(hinge, joint, ABOVE)
    assert shows_motion(hinge, joint, SIDE)
    found = pulled_values(hinge, joint, look=SIDE, start=np.array([1.0, 2.0]), end=np.array([1.0, 1.0]))
    assert math.degrees(found[0]) == pytest.approx(45.0, abs=1e-6)  # right-handed about y: down


def test_a_screw_turns_as_it_is_pulled_along():
    screw = alone("{screw: j, of: [ground, rod], axis: [1, 0, 0], pitch: 0.1}")
    found = pulled_values(screw, screw.joints[0], look=ABOVE, start=np.array([0.5, 0.0]), end=np.array([0.55, 0.0]))
    assert found == {0: pytest.approx(math.pi), 1: pytest.approx(0.05)}
    assert restarted(screw, found).mechanism.assembly.start == pytest.approx([math.pi, 0.05], abs=1e-4)


def test_of_a_joint_with_several_values_all_are_written_at_once():
    plate = alone("{planar: j, of: [ground, rod], axis: [0, 0, 1], start: [0, 0.5]}")
    assert restarted(plate, {0: 0.25}).keys == {(0, "start"): [0.25, 0.5]}
    assert restarted(plate, {2: math.pi / 2}).keys == {(0, "start_deg"): 90.0}


def test_a_weld_has_nothing_that_moves():
    weld = alone("{weld: j, of: [ground, rod]}")
    assert free_columns(weld) == set()
    assert not shows_motion(weld, weld.joints[0], ABOVE)
