"""Joints of mechanisms that torques, forces or nothing move, held by a hand: bounded, beside what else acts on them."""

import math
import re

import numpy as np
import pytest
from scipy.optimize import brentq

import mjsim
from mjsim.errors import UsageError
from mjsim.record import same_run
from mjsim.session import keep_events
from mjsim.sim.holds import STIFFNESS, STRONGEST
from mjsim.world import check_world, led_joints

PATIENCE = 60.0
"""Nothing takes this long [s], on however loaded a machine."""
GRAVITY = 9.81
BAR = """\
mjsim: 1
mechanisms:
  - name: bar
    at: [2, 2]
    elevation: 3
    bodies: [{name: rod, rod: [1.0, 0.05], mass: MASS, center: [0.5, 0, 0]}]
    joints: [{revolute: swing, of: [ground, rod], axis: [0, 1, 0]}]
run: {seconds: 4}
"""
POLE = """\
mjsim: 1
mechanisms:
  - name: pole
    at: [2, 2]
    elevation: 3
    bodies: [{name: cart, box: [0.3, 0.3, 0.1], mass: 2}, {name: rod, rod: [1.0, 0.03], mass: 0.5}]
    joints:
      - {prismatic: x, of: [ground, cart], axis: [1, 0, 0], range: [-2, 2]}
      - {revolute: q, of: [cart, rod], axis: [0, 1, 0], start_deg: 90, damping: 0.5}
    actuators:
      - controller: {use: "mjsim.algorithms.linear_control:MechanismLoop", gain: {x: [50, 20]}}
        force: x
run: {seconds: 12}
"""


def stepped(sim, seconds):
    """Run for a time, and return how the joints of the only mechanism move then."""
    for _ in range(round(seconds / 0.04)):
        sim.step()
    (motion,) = sim.motions().values()
    return motion


def test_a_hand_sags_under_a_weight_as_its_spring_does_and_shows_where_it_wants_to_be():
    with mjsim.Simulation(mjsim.parse_world(BAR.replace("MASS", "2"))) as sim:
        sim.lead("bar", "swing", -30)
        motion = stepped(sim, 4)
        sag = motion.positions[0] - math.radians(-30)
        # Half a metre of lever for the weight, the whole rod for the hand.
        weight = 2 * GRAVITY * 0.5 * math.cos(motion.positions[0])
        assert STIFFNESS * sag == pytest.approx(weight, rel=1e-6)
        assert motion.goal[0] == pytest.approx(math.radians(-30))
        assert motion.torques[0] == 0.0  # of actuators, of which there are none


def test_a_hand_is_no_stronger_than_it_says():
    with mjsim.Simulation(mjsim.parse_world(BAR.replace("MASS", "100"))) as sim:
        sim.lead("bar", "swing", -60)
        angles = [stepped(sim, 0.04).positions[0] for _ in range(50)]
    # The bar falls until its weight has done as much work as the hand: m g L / 2 sin(q) = F q.
    most = brentq(lambda q: 100 * GRAVITY * 0.5 * math.sin(q) - STRONGEST * q, 1.0, math.pi)
    assert max(angles) == pytest.approx(most, abs=0.02)  # a tick from the turning point, and what it goes until F


def test_a_joint_comes_no_faster_than_a_radian_a_second_is_stopped_first_and_falls_once_it_is_let_go():
    with mjsim.Simulation(mjsim.parse_world(BAR.replace("MASS", "2"))) as sim:
        with mjsim.Simulation(mjsim.parse_world(BAR.replace("MASS", "2"))) as free:
            before, falling = stepped(sim, 0.4), stepped(free, 0.4)
        np.testing.assert_array_equal(before.positions, falling.positions)
        sim.lead("bar", "swing", -60)
        stepped(sim, 0.2)
        speeds = [stepped(sim, 0.04).velocities[0] for _ in range(110)]
        assert 0.9 < np.abs(speeds).max() < 1.05  # at a sag that changes with the angle
        assert abs(speeds[-1]) < 1e-3
        sim.release("bar", joint="swing")
        assert not sim.data.qfrc_applied.any()
        first = stepped(sim, 0.04)
        assert first.accelerations[0] == pytest.approx(1.5 * GRAVITY * math.cos(first.positions[0]), rel=0.02)


def test_a_hand_does_the_same_whether_or_not_somebody_looks():
    with mjsim.Simulation(mjsim.parse_world(POLE)) as seen, mjsim.Simulation(mjsim.parse_world(POLE)) as alone:
        for sim in (seen, alone):
            sim.lead("pole", "q", 60)
        for _ in range(20):
            seen.step()
            alone.step()
            seen.motions()
        np.testing.assert_array_equal(seen.data.qpos, alone.data.qpos)


@pytest.mark.slow
def test_a_controller_goes_on_against_the_hand_and_has_its_joint_back_when_it_lets_go():
    with mjsim.Simulation(mjsim.parse_world(POLE)) as sim:
        sim.lead("pole", "x", 0.5)
        held = stepped(sim, 4)
        pull = -50 * held.positions[0]
        assert held.torques[0] == pytest.approx(pull, abs=0.01)  # the law is called half a tick before, and still moves
        assert held.positions[0] - 0.5 == pytest.approx(pull / STIFFNESS, abs=1e-5)  # what is left of the pole's swing
        sim.release("pole", joint="x")
        assert stepped(sim, 6).positions[0] == pytest.approx(0.0, abs=0.01)


def test_two_joints_in_one_chain_are_held_stiffly_without_a_tremor():
    text = POLE.replace("mass: 2}", "mass: 0.05}").replace("mass: 0.5}", "mass: 0.02}")
    text = re.sub(r"    actuators:.*(?=run:)", "", text, flags=re.DOTALL)
    with mjsim.Simulation(mjsim.parse_world(text)) as sim:
        sim.lead("pole", "x", 1)
        sim.lead("pole", "q", -20)
        stepped(sim, 4)
        found = [stepped(sim, 0.04) for _ in range(10)]
    assert max(np.abs(each.velocities).max() for each in found) < 1e-3
    np.testing.assert_allclose(found[-1].positions, [1, math.radians(-20)], atol=0.01)


def test_a_joint_that_is_not_there_or_beyond_its_range_is_refused_and_check_says_so():
    world = mjsim.parse_world(POLE)
    assert list(led_joints(world.mechanisms[0])) == ["x", "q"]
    with mjsim.Simulation(world) as sim:
        with pytest.raises(UsageError, match="mechanism 'pole' has no joint 'y' that can be led; there are q, x"):
            sim.lead("pole", "y", 0)
        with pytest.raises(UsageError, match="joint 'x' of mechanism 'pole' cannot go to 3; its range is -2 to 2"):
            sim.lead("pole", "x", 3)
    events = "events: [{time: 1, lead: pole, joint: x, to_deg: 3}]"
    (problem,) = check_world(mjsim.parse_world(POLE.replace("{seconds: 12}", f"{{seconds: 12, {events}}}")))
    assert "cannot go to 3" in str(problem)


@pytest.mark.slow
def test_what_a_hand_held_repeats_to_the_byte_once_it_is_kept(tmp_path):
    hand, kept = tmp_path / "hand.mcap", tmp_path / "kept.mcap"
    text = POLE.replace("seconds: 12", "seconds: 3")
    with mjsim.Session(mjsim.parse_world(text), record=hand) as session:
        session.pause()
        session.wait("paused", timeout=PATIENCE)
        session.touch({"lead": "pole", "joint": "x", "to_deg": 0.5})
        session.tick()
        session.wait("paused", timeout=PATIENCE)
        session.touch({"lead": "pole", "joint": "q", "to_deg": 40})
        session.touch({"release": "pole", "joint": "x"})
        session.go()
        session.result()
        events = session.touched
    assert [event.joint for event in events] == ["x", "q", "x"]
    world = mjsim.parse_world(keep_events(text, events))
    with mjsim.Simulation(world) as sim:
        mjsim.run(sim, record=kept)
    assert same_run(hand, kept)
    assert mjsim.read_recording(hand).joints["pole"].positions[-1][1] == pytest.approx(math.radians(40), abs=0.01)
