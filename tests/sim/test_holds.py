"""Joints of mechanisms that torques, forces or nothing move, held by a hand: bounded, beside what else acts on them."""

import math
import re

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

import mjsim
from mjsim.errors import UsageError
from mjsim.mechanics import followed
from mjsim.record import same_run
from mjsim.session import keep_events
from mjsim.sim.mechanisms.hand_forces import MAX_FORCE, STIFFNESS
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
BELL = """\
mjsim: 1
mechanisms:
  - name: bell
    at: [2, 2]
    elevation: 3
    bodies: [{name: rod, rod: [1.0, 0.05], mass: 2, center: [0.5, 0, 0]}]
    joints: [{spherical: knot, of: ENDS, start_deg: [0, 90, 0]}]
run: {seconds: 4}
"""
BARS = """\
mjsim: 1
mechanisms:
  - name: bars
    at: [2, 2]
    elevation: 4
    bodies: [{name: crank, rod: [1.0, 0.05]}, {name: coupler, rod: [3.5, 0.05]}, {name: rocker, rod: [3.0, 0.05]}]
    joints:
      - {revolute: q2, of: [ground, crank], axis: [0, 1, 0], start_deg: 28.6}
      - {revolute: q3, of: [crank.end, coupler]}
      - {revolute: q4, of: [{ground: [4, 0, 0]}, rocker]}
      - {revolute: q5, of: [coupler.end, rocker.end]}
run: {seconds: 4}
"""
ROCKER = 3.0
"""What q5 and q4 turn [m]: the rocker."""


def stepped(sim, seconds):
    """Run for a time, and return how the joints of the only mechanism move then."""
    for _ in range(round(seconds / 0.04)):
        sim.step()
    (motion,) = sim.motions().values()
    return motion


def test_a_hand_sags_under_a_weight_as_its_spring_does_and_shows_where_it_wants_to_be():
    with mjsim.Simulation(mjsim.parse_world(BAR.replace("MASS", "2"))) as sim:
        sim.lead("bar", "swing", -30)
        motion = stepped(sim, 2)
        sag = motion.positions[0] - math.radians(-30)
        # Half a metre of lever for the weight, the whole rod for the hand.
        weight = 2 * GRAVITY * 0.5 * math.cos(motion.positions[0])
        assert STIFFNESS * sag == pytest.approx(weight, rel=1e-6)
        assert motion.goal[0] == pytest.approx(math.radians(-30))
        assert motion.torques[0] == 0.0  # of actuators, of which there are none


@pytest.mark.slow
def test_a_hand_is_no_stronger_than_it_says():
    with mjsim.Simulation(mjsim.parse_world(BAR.replace("MASS", "100"))) as sim:
        sim.lead("bar", "swing", -60)
        angles = [stepped(sim, 0.04).positions[0] for _ in range(50)]
    # The bar falls until its weight has done as much work as the hand: m g L / 2 sin(q) = F q.
    most = brentq(lambda q: 100 * GRAVITY * 0.5 * math.sin(q) - MAX_FORCE * q, 1.0, math.pi)
    assert max(angles) == pytest.approx(most, abs=0.02)  # a tick from the turning point, and what it goes until F


@pytest.mark.slow
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


@pytest.mark.slow
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


@pytest.mark.slow
@pytest.mark.parametrize(("ends", "way", "seconds"), [("[ground, rod]", 1, 3), ("[rod, ground]", -1, 5)])
def test_a_ball_is_led_to_a_rotation_and_sags_about_the_axis_of_its_weight(ends, way, seconds):
    world = mjsim.parse_world(BELL.replace("ENDS", ends))
    assert world.mechanisms[0].balls == {"knot": ("knot.rx", "knot.ry", "knot.rz")}
    with mjsim.Simulation(world) as sim:
        sim.lead("bell", "knot", [20, way * 30, 50])
        motion = stepped(sim, seconds)
        # The rod hangs on the ground's side of the joint, or turns the other way about it.
        goal, found = (Rotation.from_rotvec(way * values) for values in (motion.goal, motion.positions))
        np.testing.assert_allclose(np.degrees(motion.goal), [20, way * 30, 50])
        center = found.apply([0.5, 0, 0])
        pull = STIFFNESS * (goal * found.inv()).as_rotvec()
        np.testing.assert_allclose(pull, np.cross(center, [0, 0, 2 * GRAVITY]), atol=1e-4)
        sim.release("bell", joint="knot.ry")
        assert not sim.data.qfrc_applied.any()


@pytest.mark.slow
def test_one_value_of_a_ball_is_led_and_the_others_stay_where_the_hand_took_them():
    with mjsim.Simulation(mjsim.parse_world(BELL.replace("ENDS", "[ground, rod]"))) as sim:
        sim.lead("bell", "knot.rz", 40)
        np.testing.assert_allclose(np.degrees(stepped(sim, 1.6).goal), [0, 90, 40], atol=1e-9)
        sim.lead("bell", "knot.ry", -20)
        motion = stepped(sim, 3.6)
        np.testing.assert_allclose(np.degrees(motion.goal), [0, -20, 40], atol=1e-9)
        np.testing.assert_allclose(np.degrees(motion.positions), [0, -20, 40], atol=0.2)  # the sag
        with pytest.raises(UsageError, match=r"rotation_deg: \[rx, ry, rz\], or lead one of knot.rx, knot.ry, knot.rz"):
            sim.lead("bell", "knot", 4)
        with pytest.raises(UsageError, match=r"joint 'knot.rx' of mechanism 'bell' is led with to_deg"):
            sim.lead("bell", "knot.rx", [1, 2, 3])


@pytest.mark.parametrize(
    ("joint", "to_deg", "seconds"),
    [
        ("q5", 80, 2),
        pytest.param("q4", 110, 3, marks=pytest.mark.slow),
        pytest.param("q5", -60, 4, marks=pytest.mark.slow),
    ],
)
def test_a_joint_of_a_loop_is_held_against_its_weight_also_where_the_loop_does_not_reach_the_goal(
    joint, to_deg, seconds
):
    """By virtual work: what the hand does in a small motion of the loop is what the weight gains."""
    world = mjsim.parse_world(BARS)
    found = world.mechanisms[0].assembly
    assert (list(found.cuts), world.mechanisms[0].held) == (["q5"], {"q2", "q3", "q4", "q5"})
    with mjsim.Simulation(world) as sim:
        masses = [float(sim.model.body(f"bars/{name}").mass[0]) for name in ("crank", "coupler", "rocker")]
        sim.lead("bars", joint, to_deg)
        motion = stepped(sim, seconds)
    assert np.abs(motion.velocities).max() < 1e-4
    column = found.names.index(joint)
    assert motion.goal[column] == pytest.approx(math.radians(to_deg))

    def state(by):
        values = motion.positions.copy()
        values[0] += by
        values = followed(found.linkage, found.rows, values, held=[0]).values
        poses = found.linkage.place(values).poses
        centers = [(pose @ [length / 2, 0, 0, 1])[2] for pose, length in zip(poses[1:], (1, 3.5, 3), strict=False)]
        return GRAVITY * float(np.dot(masses, centers)), values[column]

    (up, ahead), (down, behind) = state(1e-4), state(-1e-4)
    most = MAX_FORCE * ROCKER
    pull = np.clip(STIFFNESS * ROCKER**2 * (motion.goal[column] - motion.positions[column]), -most, most)
    assert pull * (ahead - behind) == pytest.approx(up - down, rel=1e-3)


@pytest.mark.slow
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
@pytest.mark.parametrize(
    ("text", "leads"),
    [
        (BELL.replace("ENDS", "[ground, rod]"), [("knot", [20, 30, 50]), ("knot.rz", -30)]),
        (BARS, [("q5", 80), ("q3", -10)]),
    ],
    ids=["ball", "loop"],
)
def test_balls_and_loops_that_a_hand_led_repeat_to_the_byte(tmp_path, text, leads):
    hand, kept, text = tmp_path / "hand.mcap", tmp_path / "kept.mcap", text.replace("seconds: 4", "seconds: 1.6")
    name = mjsim.parse_world(text).mechanisms[0].name
    with mjsim.Session(mjsim.parse_world(text), record=hand) as session:
        session.pause()
        session.wait("paused", timeout=PATIENCE)
        for joint, to_deg in leads:
            key = "rotation_deg" if isinstance(to_deg, list) else "to_deg"
            session.touch({"lead": name, "joint": joint, key: to_deg})
            session.tick()
            session.wait("paused", timeout=PATIENCE)
        session.go()
        session.result()
        events = session.touched
    written = keep_events(text, events)
    with mjsim.Simulation(mjsim.parse_world(written)) as sim:
        mjsim.run(sim, record=kept)
    assert same_run(hand, kept)
    told = [event.rotation_deg or event.to_deg for event in mjsim.read_recording(hand).events]
    assert told == [tuple(to_deg) if isinstance(to_deg, list) else to_deg for _, to_deg in leads]


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
