"""By which points hands move joints on the page, compared with where those points go when the joints move."""

import numpy as np
import pytest

import mjsim
from mjsim.geometry import Pose3
from mjsim.web.run.jointed import drawn_bodies, grips_json, joints_json

WORLD = """
robots:
  - {name: r, base: fixed, at: [1, 2], heading_deg: 60, arms: [{preset: puma560, at: [0.1, 0, 0.3]}]}
mechanisms:
  - name: bars
    at: [3, 2]
    heading_deg: 30
    elevation: 1
    bodies: [{name: crank, rod: [1.0, 0.05]}, {name: slab, box: [0.4, 0.2, 0.1]}]
    joints:
      - {revolute: q2, of: [ground, crank], axis: [0, 1, 0]}
      - {prismatic: s, of: [crank.end, slab], axis: [1, 0, 1]}
    actuators: [{angle: q2, signal: {constant: {value_deg: 20}}}, {position: s, signal: {constant: {value: 0.2}}}]
"""
STEP = 1e-5


@pytest.fixture(scope="module")
def world():
    return mjsim.parse_world(WORLD)


def grips(world, values):
    robot = world.robots[0]
    pose = Pose3(*robot.at, 0.0, 0.0, 0.0, *np.sin([np.pi / 6]), *np.cos([np.pi / 6]))
    return {(each["of"], each["joint"]): each for each in grips_json(world, values, {"r": pose})}


def test_a_grip_moves_about_or_along_the_axis_that_is_told(world, monkeypatch):
    monkeypatch.setattr("mjsim.web.run.jointed.plain", lambda values, digits=4: np.asarray(values).tolist())
    rng = np.random.default_rng(0)
    values = {"bars": world.mechanisms[0].assembly.start, "r/arm": rng.uniform(-0.5, 0.5, 6)}
    before = grips(world, values)
    facts = joints_json(world)
    assert {key for key, _ in before} == {"bars", "r/arm"}
    for (key, joint), grip in before.items():
        column = [each["name"] for each in facts[key]].index(joint)
        if key == "bars" and joint == "q2":
            continue  # the slab that it carries as well is not its own
        changed = values[key].copy()
        changed[column] += STEP
        after = grips(world, {**values, key: changed})[key, joint]
        moved = np.subtract(after["grip"], grip["grip"]) / STEP
        axis, lever = np.array(grip["axis"]), np.subtract(grip["grip"], grip["at"])
        wanted = axis if grip["slides"] else np.cross(axis, lever)
        np.testing.assert_allclose(moved, wanted, atol=1e-4)
        assert grip["slides"] or np.linalg.norm(wanted) > 0.05


def test_outlines_are_told_of_arms_and_of_mechanisms_that_have_moved(world):
    start = world.mechanisms[0].assembly.start
    values = {"bars": start, "r/arm": np.zeros(6)}
    place = {"r": mjsim.Pose(1.0, 2.0, np.pi / 3)}
    assert drawn_bodies(world, values, place).keys() == {"r/arm"}
    moved = drawn_bodies(world, {**values, "bars": start + 0.1}, place)
    assert {name: len(outlines) for name, outlines in moved.items()} == {"bars": 2, "r/arm": 6}
    assert drawn_bodies(world, {"r/arm": np.full(6, np.nan)}, place) == {}
    base = np.concatenate(moved["r/arm"]).mean(axis=0)
    assert np.linalg.norm(base - (1, 2)) < 1


def test_the_handle_of_a_symmetrical_body_stays_at_one_of_its_corners():
    text = """
mechanisms:
  - name: gate
    at: [2, 2]
    bodies: [{name: bar, box: [1.2, 0.3, 0.1]}]
    joints: [{revolute: swing, of: [ground, bar], axis: [0, 0, 1]}]
    actuators: [{angle: swing, signal: {constant: {value_deg: 60}}}]
"""
    gate = mjsim.parse_world(text)
    places = []
    for angle in np.linspace(0.0, 6.0, 400):
        (grip,) = grips_json(gate, {"gate": np.array([angle])}, {})
        x, y, _ = np.subtract(grip["grip"], grip["at"])
        c, s = np.cos(angle), np.sin(angle)
        places.append((c * x + s * y, c * y - s * x))
    # Positions on the wire have four decimals.
    np.testing.assert_allclose(np.ptp(places, axis=0), 0.0, atol=3e-4)
