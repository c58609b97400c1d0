"""Malformed mechanisms: each mistake is one line that says where, what is wrong, and what would be right."""

import pytest

import mjsim
from mjsim.errors import WorldError

FOURBAR = """mjsim: 1
mechanisms:
  - name: m
    elevation: 4
    bodies: [{name: crank, rod: [1.0, 0.05]}, {name: coupler, rod: [3.5, 0.05]}, {name: rocker, rod: [3.0, 0.05]}]
    joints:
      - {revolute: q2, of: [ground, crank], axis: [0, 1, 0]}
      - {revolute: q3, of: [crank.end, coupler]}
      - {revolute: q4, of: [{ground: [4, 0, 0]}, rocker]}
      - {revolute: q5, of: [coupler.end, rocker.end]}
    actuators: [{angle: q2, signal: {ramp: {from_deg: 28.6, slope_deg: 114.6}}}]
    sensors: [{joint: q4}]
"""

MISTAKES = [
    ("crank, rod", "crank, rud", "5:28: unknown key 'rud'; did you mean 'rod'?"),
    ("rod: [1.0, 0.05]", "rod: [1.0]", "5:33: rod is [1.0]; it must be [length, radius]"),
    (
        "rod: [1.0, 0.05]",
        "rod: [1e-9, 0.05]",
        "5:34: a length is 1e-09 m; it must be at least 1e-05 m",
    ),
    ("rod: [1.0, 0.05]", "rod: [.nan, 0.05]", "5:34: rod[0] is nan; it must be a finite number"),
    ("rod: [1.0, 0.05]", "rod: [1e300, 0.05]", "5:34: rod[0] is 1e+300 m; it must be at most 10000"),
    ("slope_deg: 114.6", "slope_deg: .inf", "11:72: slope_deg is inf; it must be a finite number"),
    (
        "    sensors",
        "    constraints: [{parallel: [crank, crank]}]\n    sensors",
        "12:30: joint 'parallel1' holds 'crank' to itself; name two bodies",
    ),
    (
        "    sensors",
        "    constraints: [{gear: [q2, q4], ratio: 1}]\n    sensors",
        "11:17: 'q2' cannot be driven independently: the mechanism has 0 freedoms, which other motions already drive; "
        "give a torque or a force, or leave it out",
    ),
    ("rod: [1.0, 0.05]", "rod: [-1.0, 0.05]", "5:34: rod[0] is -1.0 m; it must be above 0"),
    (
        "{name: crank, rod: [1.0, 0.05]}",
        "{name: crank}",
        "5:14: bodies[0] is {name}; a body needs its shape; write rod: [length, radius], box: [length, width, "
        "height], cylinder: [radius, height], sphere: radius, or model: FILE",
    ),
    ("name: coupler", "name: crank", "5:47: name 'crank' is taken by bodies[0]; give each its own"),
    ("name: rocker", "name: ground", "5:89: 'ground' is the fixed frame; give the body another name"),
    (
        "name: rocker",
        "name: rock.er",
        "5:89: name is 'rock.er'; it must be a name of letters, digits, '_' and '-'; a dot separates it from "
        "the part on it",
    ),
    ("rod: [1.0, 0.05]}", "rod: [1.0, 0.05], mass: 0}", "5:52: mass is 0 kg; it must be above 0"),
    (
        "rod: [1.0, 0.05]}",
        "rod: [1.0, 0.05], inertia: [1, 1, 3, 0, 0, 0]}",
        "5:55: the principal moments of inertia are 1, 1 and 3 kg m^2; "
        "the largest must not exceed the sum of the others",
    ),
    (
        "rod: [1.0, 0.05]}",
        "rod: [1.0, 0.05], inertia: [1, 1, -1, 0, 0, 0]}",
        "5:55: the inertia has a principal moment of -1 kg m^2; it must not be below 0",
    ),
    (
        "crank.end, coupler",
        "crank.tip, coupler",
        "8:29: body 'crank' has no point 'tip'; it has end, center, or give {crank: [x, y, z]}",
    ),
    ("crank.end, coupler", "krank.end, coupler", "8:29: no body 'krank' in this mechanism; did you mean 'crank'?"),
    ("crank.end, coupler]", "crank.end]", "8:28: of is ['crank.end']; it must have at least 2 items"),
    ("[ground, crank]", "[ground, ground]", "7:28: joint 'q2' holds 'ground' to itself; name two bodies"),
    ("crank.end, coupler]", "crank.end, crank]", "8:28: joint 'q3' holds 'crank' to itself; name two bodies"),
    (
        "axis: [0, 1, 0]",
        "axis: [0, 0, 0]",
        "7:51: it is [0, 0, 0], which has no direction; give one number that is not 0",
    ),
    ("revolute: q3", "revolut: q3", "8:10: unknown key 'revolut'; did you mean 'revolute'?"),
    ("revolute: q3", "revolute: q2", "8:9: name 'q2' is taken by joints[0]; give each its own"),
    ("revolute: q3", "revolute: crank", "8:9: name 'crank' is taken by bodies[0]; give each its own"),
    (
        "of: [coupler.end, rocker.end]",
        "of: [coupler.end, rocker.end], start: 1",
        "10:62: start is for a joint that slides; give start_deg",
    ),
    (
        "of: [coupler.end, rocker.end]",
        "of: [coupler.end, rocker.end], start_deg: [1, 2]",
        "10:66: start_deg has 2 numbers; this joint needs 1",
    ),
    (
        "axis: [0, 1, 0]",
        "axis: [0, 1, 0], start_deg: 30",
        "7:73: start_deg is 30 degrees, and the joint's actuator begins at 28.6 degrees; leave out start_deg, or "
        "make them agree",
    ),
    (
        "rod: [3.5, 0.05]",
        "rod: [8.5, 0.05]",
        "10:9: the loop at joint 'q5' does not close with these lengths and start values: it misses by 2.341 m; change "
        "them, or leave out the start of a joint in it",
    ),
    (
        "of: [crank.end, coupler]",
        "of: [crank.end, coupler], start_deg: 0",
        "10:9: the loop at joint 'q5' does not close with these lengths and start values: it misses by 0.8453 m; "
        "change them, or leave out the start of a joint in it",
    ),
    (
        "of: [{ground: [4, 0, 0]}, rocker]",
        "of: [{ground: [4, 0, 0]}, rocker], range_deg: [50, 20]",
        "9:70: range_deg is [50, 20]; the first must be below the second",
    ),
    (
        "of: [{ground: [4, 0, 0]}, rocker]",
        "of: [{ground: [4, 0, 0]}, rocker], range_deg: [0, 20]",
        "9:70: joint 'q4' starts at 102.072 degrees; its range_deg is [0, 20]",
    ),
    ("angle: q2, signal", "angle: q9, signal", "11:25: no joint 'q9' in this mechanism; there are q2, q3, q4, q5"),
    ("angle: q2, signal", "position: q2, signal", "11:28: joint 'q2' turns; write angle: q2"),
    (
        "ramp: {from_deg: 28.6, slope_deg: 114.6}",
        "step: {to_deg: 90}",
        "11:44: a step signal jumps, which no mass can follow; use a ramp, a sine or a table",
    ),
    (
        "ramp: {from_deg: 28.6, slope_deg: 114.6}",
        "ramp: {from: 28.6, slope: 114.6}",
        "11:64: this is an angle, in degrees; write slope_deg for slope",
    ),
    ("    sensors", "    actuators2: []\n    sensors", "12:5: unknown key 'actuators2'; did you mean 'actuators'?"),
    (
        "114.6}}}]",
        "114.6}}}, {angle: q4, signal: {sine: {amplitude_deg: 5, frequency_hz: 1}}}]",
        "10:9: the loop at joint 'q5' does not close with these lengths and start values: it misses by 0.6639 m "
        "and 86.24 degrees; change them, or leave out the start of a joint in it",
    ),
    (
        "114.6}}}]",
        "114.6}}}, {torque: q2, signal: {constant: {value: 1}}}]",
        "11:91: 'q2' has an actuator already, actuators[0]",
    ),
    (
        "{angle: q2, signal: {ramp: {from_deg: 28.6, slope_deg: 114.6}}}",
        "{torque: crank, signal: {constant: {value: 1}}}",
        "11:26: a torque on a body needs its direction; add axis: [x, y, z]",
    ),
    (
        "{angle: q2, signal: {ramp: {from_deg: 28.6, slope_deg: 114.6}}}",
        "{torque: q2}",
        "11:17: this torque has no signal; add signal: {constant: {value: 1}}, or find: true in mode trim",
    ),
    (
        "{angle: q2, signal: {ramp: {from_deg: 28.6, slope_deg: 114.6}}}",
        "{torque: q2, find: true}",
        "11:36: find is for mode: trim; give a signal",
    ),
    (
        "    sensors",
        "    constraints: [{gear: [q2, q9], ratio: 3}]\n    sensors",
        "12:31: no joint 'q9' in this mechanism; there are q2, q3, q4, q5",
    ),
    (
        "    sensors",
        "    constraints: [{gear: [q2, q4], ratio: 0}]\n    sensors",
        "12:43: ratio is 0, so that the first would not turn; use a weld",
    ),
    (
        "    sensors",
        "    constraints: [{screw: [q2, q4], pitch: 0.1}]\n    sensors",
        "12:32: joint 'q4' turns; name one that slides",
    ),
    (
        "    sensors",
        "    constraints: [{curve: crank.end}]\n    sensors",
        "12:27: a curve is one of points, circle and ellipse; this one has none",
    ),
    (
        "    sensors",
        "    constraints: [{curve: crank.end, on: crank, circle: 1}]\n    sensors",
        "12:27: the point and the curve are both on 'crank'; name two bodies",
    ),
    (
        "    sensors",
        "    constraints: [{curve: crank.end, on: rokcer, circle: 1}]\n    sensors",
        "12:42: no body 'rokcer' in this mechanism; did you mean 'rocker'?",
    ),
    (
        "    sensors",
        "    constraints: [{curve: coupler.end, at: [9, 0, 0], circle: 0.1}]\n    sensors",
        "12:27: the point does not reach its curve with these lengths and start values: it misses by 4.677 m; change "
        "them, or leave out the start of a joint",
    ),
    (
        "    sensors",
        "    constraints: [{curve: crank.end, points: [[0, 0, 0], [0, 0, 0]]}]\n    sensors",
        "12:58: this point equals its neighbour; leave it out",
    ),
    (
        "    sensors",
        "    constraints: [{name: q3, curve: rocker.end, circle: 1}]\n    sensors",
        "12:19: name 'q3' is taken by joints[1]; give each its own",
    ),
    (
        "{angle: q2, signal: {ramp: {from_deg: 28.6, slope_deg: 114.6}}}",
        "{position: c, signal: {ramp: {slope: 1}}}]\n    constraints: [{name: c, curve: crank.end, circle: 1}",
        "11:28: 'c' is the position of a point along a curve; name a joint, or push the point with force: BODY.POINT",
    ),
    ("sensors: [", "sensors: [{joint: q4}, ", "12:36: 'q4' has this sensor already, sensors[0]; leave one out"),
    (
        "sensors: [",
        "sensors: [{body: {crank: [0, 0, 0]}}, {body: {crank: [1, 0, 0]}}, ",
        "12:50: 'crank' has this sensor already, sensors[0]; give this one a name, or leave it out",
    ),
    ("rod: [1.0, 0.05]}", "rod: [1.0, 0.05], mass: 1.e-30}", "5:52: the mass is 1e-30 kg; make it at least 1e-09 kg"),
    (
        "rod: [3.0, 0.05]}",
        "rod: [3.0, 0.05], center: [0, 0, 0], inertia: [0, 0, 0, 0, 0, 0]}",
        "9:9: joint 'q4' moves no mass and no inertia, so its motion is undetermined; give body 'rocker' an inertia",
    ),
    (
        "    sensors",
        "    constraints: [{distance: [crank, crank.end]}]\n    sensors",
        "12:30: both points are on one body, and cannot move apart; name points of two bodies",
    ),
    ("joint: q4}]", "joint: q9}]", "12:23: no joint 'q9' in this mechanism; there are q2, q3, q4, q5"),
    ("joint: q4}]", "reaction: q9}]", "12:26: no joint 'q9' in this mechanism; there are q2, q3, q4, q5"),
    ("joint: q4}]", "actuator: q4}]", "12:26: no actuator on 'q4' in this mechanism; there are q2"),
    ("joint: q4}]", "body: cranc}]", "12:22: no body 'cranc' in this mechanism; did you mean 'crank'?"),
    ("joint: q4}]", "joints: q4}]", "12:16: unknown key 'joints'; did you mean 'joint'?"),
    (
        "    elevation: 4",
        "    elevation: 4\n    mode: invers",
        "5:11: mode is 'invers'; it must be 'forward', 'inverse', 'kinematics' or 'trim'; did you mean 'inverse'?",
    ),
    (
        "    actuators: [{angle: q2, signal: {ramp: {from_deg: 28.6, slope_deg: 114.6}}}]",
        "    mode: inverse",
        "11:11: mode inverse needs a motion for each degree of freedom: 0 of 1 have one; add an angle, position, "
        "velocity or distance, or use mode: forward",
    ),
    (
        "- {revolute: q5, of: [coupler.end, rocker.end]}",
        "- {universal: q5, of: [coupler.end, rocker.end], axes: [[1, 0, 0], [1, 0, 0]]}",
        "10:74: this axis is parallel to the one before; turn it",
    ),
    (
        "- {revolute: q5, of: [coupler.end, rocker.end]}",
        "- {custom: q5, of: [coupler.end, rocker.end], motions: [{ball: true}, {slide: [1, 0, 0]}]}",
        "10:63: a ball turns about all axes; make it the last motion, and leave out turns",
    ),
    (
        "name: m\n",
        "name: obstacle\n",
        "3:11: 'obstacle' is a reserved name in the scene; give another name",
    ),
]


@pytest.mark.parametrize(("right", "wrong", "line"), MISTAKES)
def test_each_mistake_in_a_mechanism_is_one_line(right, wrong, line):
    with pytest.raises(WorldError) as caught:
        mjsim.parse_world(FOURBAR.replace(right, wrong, 1), file="w.yaml")
    assert str(caught.value) == f"w.yaml:{line}"


def test_the_mechanism_without_mistakes_is_read():
    assert mjsim.parse_world(FOURBAR).mechanisms[0].assembly.cuts.keys() == {"q5"}


def test_a_mechanism_written_out_reads_back_equal():
    world = mjsim.parse_world(FOURBAR)
    assert mjsim.parse_world(mjsim.format_world(world)) == world
