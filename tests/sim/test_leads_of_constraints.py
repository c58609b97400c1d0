"""Joints that a distance moves are led by it; points are led along their curves, by a hand or by a motion."""

import math

import numpy as np
import pytest

import mjsim
from mjsim.errors import UsageError
from mjsim.record import same_run
from mjsim.session import keep_events
from mjsim.sim.mechanisms.hand_forces import STIFFNESS
from mjsim.world import led_joints

GRAVITY = 9.81
RAM = """
mjsim: 1
mechanisms:
  - name: ram
    elevation: 3
    bodies: [{name: boom, rod: [1.0, 0.04]}]
    joints: [{revolute: a, of: [ground, boom], near_deg: 20, axis: [0, 1, 0]}]
    actuators:
      - {distance: [{ground: [0, 0, -1]}, {boom: [0.5, 0, 0]}], signal: {constant: {value: 0.9}}, name: cylinder}
run: {seconds: 0.4}
"""
BEAD = """
mjsim: 1
mechanisms:
  - name: wire
    elevation: 3
    bodies: [{name: bead, sphere: 0.05, mass: 2}]
    joints: [{of: [ground, bead], axis: [0, 1, 0], in_plane: p}]
    constraints: [{name: ring, curve: bead, circle: 1.0, axis: [0, 1, 0], start: 0.1}]
run: {seconds: 0.4}
"""
CAM = """
mjsim: 1
mechanisms:
  - name: cam
    elevation: 3
    bodies: [{name: disk, cylinder: [0.1, 0.06], rpy_deg: [90, 0, 0]}, {name: follower, rod: [0.8, 0.02]}]
    joints:
      - {of: [ground, disk], axis: [0, 1, 0], revolute: turn}
      - {of: [ground, follower], rpy_deg: [0, -90, 0], axis: [0, 0, 1], near: 0.3, prismatic: lift}
    constraints: [{name: contact, on: disk, curve: follower, ellipse: [0.4, 0.2], axis: [0, 1, 0]}]
    actuators: [{signal: {constant: {value_deg: 30}}, angle: turn}]
run: {seconds: 4}
"""
HOOKE = """
mjsim: 1
mechanisms:
  - name: hooke
    elevation: 2
    bodies: [{name: input, rod: [0.5, 0.03]}, {name: output, rod: [0.5, 0.03]}]
    joints:
      - {of: [ground, input], axis: [1, 0, 0], revolute: a}
      - {of: [input.end, output], near_deg: [0, 30], universal: u}
      - {of: [{ground: [0.9330127018922193, 0.25, 0]}, output.end], rpy_deg: [0, 0, 30],
         axis: [0.8660254037844387, 0.5, 0], revolute: b}
    actuators: [{signal: {constant: {value_deg: 120}}, velocity: a}]
run: {seconds: 1}
"""
RSSR = """
mjsim: 1
mechanisms:
  - name: rssr
    elevation: 2
    bodies: [{name: crank, rod: [0.3, 0.03]}, {name: link, rod: [1.0, 0.03]}, {name: rocker, rod: [0.8, 0.03]}]
    joints:
      - {of: [ground, crank], axis: [0, 1, 0], revolute: a, start_deg: 30}
      - {of: [crank.end, link], spherical: b, near_deg: [0, 0, 60]}
      - {of: [{ground: [1, 0.3, 0]}, rocker], axis: [0, 0, 1], revolute: d, near_deg: 120}
      - {of: [link.end, rocker.end], universal: c}
    actuators: [{angle: a, signal: {constant: {value_deg: 30}}}]
run: {seconds: 1}
"""


def stepped(sim, seconds):
    """Run for a time, and return how the joints of the only mechanism move then, by name, and the largest speed."""
    fastest = 0.0
    for _ in range(round(seconds / 0.04)):
        sim.step()
        (motion,) = sim.motions().values()
        fastest = max(fastest, float(np.abs(motion.velocities).max()))
    return dict(zip(motion.names, motion.positions.tolist(), strict=True)), fastest


def ends_apart(angle):
    """Return the length of the cylinder for an angle of the boom [m], by the law of cosines."""
    return math.sqrt(1 + 0.25 - 2 * 0.5 * math.cos(math.pi / 2 - angle))


@pytest.mark.slow
@pytest.mark.parametrize("mode", ["forward", "kinematics"])
def test_a_joint_that_a_distance_moves_is_led_by_it_at_a_radian_a_second_and_returns_with_it(mode):
    text = RAM.replace("elevation: 3", f"elevation: 3\n    mode: {mode}")
    with mjsim.Simulation(mjsim.parse_world(text)) as sim:
        before, _ = stepped(sim, 0.04)
        sim.lead("ram", "a", math.degrees(before["a"]) - 30)
        led, fastest = stepped(sim, 1.2)
        sim.release("ram", joint="a")
        back, _ = stepped(sim, 1.2)
    assert ends_apart(before["a"]) == pytest.approx(0.9, abs=1e-6)
    assert math.degrees(led["a"] - before["a"]) == pytest.approx(-30, abs=1e-3)
    assert 0.5 < fastest < 1.2
    assert back["a"] == pytest.approx(before["a"], abs=1e-4)


def test_a_distance_does_not_lead_a_joint_past_the_place_where_it_would_reverse():
    world = mjsim.parse_world(RAM)
    session = mjsim.Session(world)
    session.start(paused=True)
    session.wait("paused", timeout=60)
    with pytest.raises(
        UsageError, match=r"mechanism 'ram' locks before 'a' at [\d.]+ degrees: 'cylinder' would have to"
    ):
        session.touch({"lead": "ram", "joint": "a", "to_deg": 150})
    assert session.touched == ()
    session.close()


@pytest.mark.slow
def test_a_bead_is_held_on_its_ring_and_sags_along_it_and_goes_the_shorter_way_round():
    with mjsim.Simulation(mjsim.parse_world(BEAD)) as sim:
        sim.lead("wire", "ring", 6.0)  # a quarter of a metre back, over the begin of the ring
        held, fastest = stepped(sim, 1.4)
        along = held["ring"]
        (motion,) = sim.motions().values()
        assert fastest < 1.1
        assert along == pytest.approx(6.0 - 2 * math.pi, abs=0.01)
        assert motion.goal[motion.names.index("ring")] == pytest.approx(6.0 - 2 * math.pi)
        # Its weight along the ring is borne by the spring of the hand; y of the plane points down.
        slope = (held["p.x"], held["p.y"])
        weight = 2 * GRAVITY * abs(slope[0])
        assert STIFFNESS * abs(along - (6.0 - 2 * math.pi)) == pytest.approx(weight, rel=1e-3)
        sim.release("wire", joint="ring")
        assert abs(stepped(sim, 0.2)[0]["ring"] - along) > 0.05


@pytest.mark.slow
def test_a_point_on_a_cam_is_led_by_the_motion_of_the_cam():
    with mjsim.Simulation(mjsim.parse_world(CAM)) as sim:
        before, _ = stepped(sim, 0.08)
        sim.lead("cam", "contact", before["contact"] + 0.2)
        led, _ = stepped(sim, 2.0)
    assert led["contact"] == pytest.approx(before["contact"] + 0.2, abs=1e-5)
    assert abs(led["turn"] - before["turn"]) > 0.1


@pytest.mark.slow
def test_a_value_of_a_ball_that_a_motion_turns_through_a_loop_is_led_by_that_motion():
    with mjsim.Simulation(mjsim.parse_world(RSSR)) as sim:
        before, _ = stepped(sim, 0.04)
        sim.lead("rssr", "b.ry", math.degrees(before["b.ry"]) + 8)
        led, _ = stepped(sim, 1.0)
        with pytest.raises(UsageError, match=r"joint 'b' of mechanism 'rssr' has 3 values; lead one of b\.rx"):
            sim.lead("rssr", "b", [0, 0, 0])
    assert math.degrees(led["b.ry"] - before["b.ry"]) == pytest.approx(8, abs=1e-3)
    assert abs(led["a"] - before["a"]) > 0.05


def test_a_joint_that_stands_still_at_the_start_alone_can_be_led():
    (hooke,) = mjsim.parse_world(HOOKE).mechanisms
    assert set(led_joints(hooke)) == {"a", "u.1", "u.2", "b"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "keys"),
    [
        (RAM, [{"lead": "ram", "joint": "a", "to_deg": value} for value in (10, 5, 0, -5)]),
        (BEAD, [{"lead": "wire", "joint": "ring", "to_deg": value} for value in (0.2, 0.3, 0.4, 0.5)]),
    ],
)
def test_what_was_dragged_repeats_to_the_byte(tmp_path, text, keys):
    hand, kept = tmp_path / "hand.mcap", tmp_path / "kept.mcap"
    with mjsim.Session(mjsim.parse_world(text), record=hand) as session:
        session.pause()
        for number, each in enumerate(keys):
            session.wait("paused", timeout=60)
            session.touch(each, follows=number > 0)
            session.tick()
        session.wait("paused", timeout=60)
        session.go()
        session.result()
        (event,) = session.touched
    assert len(event.then) == 3
    with mjsim.Simulation(mjsim.parse_world(keep_events(text, [event]))) as sim:
        mjsim.run(sim, record=kept)
    assert same_run(hand, kept)
