"""Arms at work: goals, controllers, what encoders tell, and what is refused."""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

import mjsim
from mjsim.algorithms.arm_control import Adaptive, ComputedTorque
from mjsim.errors import ModuleFault, UsageError
from mjsim.interface import Command, JointGoal
from mjsim.mechanics import jtraj
from mjsim.run import drivers_of
from mjsim.world import parse_world

MOVE = np.array([0.8, -0.6, 0.5, 0.4, 0.7, -0.5])
"""A move of 2 s from rest at 0 [rad]."""


def world(controller="", *, arm="preset: puma560", navigator="", more=""):
    drivers = ", ".join(part for part in (navigator, controller) if part)
    return parse_world(
        f"mjsim: 1\nrobots: [{{name: r, base: fixed, at: [1, 2], heading_deg: 90, arms: [{{{arm}}}]}}]\n"
        f"run: {{seconds: 2{more}, drivers: {{r: {{{drivers}}}}}}}\n"
    )


def controlled(kind, **keys):
    named = "".join(f", {key}: {value}" for key, value in keys.items())
    return f'controllers: {{arm: {{use: "mjsim.algorithms.arm_control:{kind}", rate_hz: 250{named}}}}}'


def path(**keys):
    named = "".join(f", {key}: {value}" for key, value in keys.items())
    return f'navigator: {{use: "mjsim.algorithms.joint_path:JointPath", to_deg: {np.degrees(MOVE).tolist()}{named}}}'


def errors(controller, seconds=2.0, **keys):
    """Return how far each joint is from its goal at each tick, shape (N, 6) [rad]."""
    here = world(controller, navigator=path(seconds=2, **keys))
    with mjsim.Simulation(here) as sim:
        found = []
        for tick in islice(mjsim.ticks(sim, drivers_of(here)), round(seconds / sim.dt) + 1):
            goal = tick.orders["r"].command.joints["arm"].positions
            found.append(np.array(goal) - sim.motions()["r/arm"].positions)
    return np.array(found)


@pytest.mark.slow
def test_pd_with_gravity_keeps_the_pumas_path_within_a_twentieth():
    assert np.abs(errors(controlled("PdGravity"))).max() < 0.05


@pytest.mark.slow
def test_computed_torque_keeps_the_pumas_path_within_half_a_thousandth():
    assert np.abs(errors(controlled("ComputedTorque"))).max() < 5e-4


@pytest.mark.slow
def test_adaptive_control_learns_masses_that_computed_torque_has_wrong():
    # What does not learn errs by the same there and back, every 4 s.
    wrong = errors(controlled("ComputedTorque", mass_scale=0.8), seconds=4.0, repeat="true")
    learns = errors(controlled("Adaptive", mass_scale=0.8), seconds=8.0, repeat="true")
    last = slice(-100, None)  # there and back
    # 11 times; 9 with masses of 1.2.
    assert np.abs(learns).max() * 7.0 < np.abs(wrong).max()
    assert np.abs(learns[last]).max() * 7.0 < np.abs(wrong[last]).max()
    assert np.sqrt((learns**2).mean()) * 7.0 < np.sqrt((wrong**2).mean())


class Shaky:
    """A controller whose encoders err by 0.01 rad/s and 1e-4 rad."""

    def __init__(self, inner):
        self._inner, self._rng = inner, np.random.default_rng(5)

    def start(self, robot, part, rng):
        self._inner.start(robot, part, rng)

    def torques(self, sensed, wanted):
        state = sensed.joints["arm"]
        off = self._rng.normal(size=(2, 6))
        seen = replace(state, positions=state.positions + 1e-4 * off[0], velocities=state.velocities + 0.01 * off[1])
        return self._inner.torques(replace(sensed, joints={"arm": seen}), wanted)


@pytest.mark.slow
def test_adaptive_control_bears_noise():
    here = world(navigator=path(seconds=2, repeat="true"))
    worst = {}
    for kind in (ComputedTorque, Adaptive):
        loop = mjsim.ControlLoop(controller=Shaky(kind(mass_scale=0.8)), rate_hz=250)
        driver = replace(drivers_of(here)["r"], controllers={"arm": loop})
        with mjsim.Simulation(here) as sim:
            found = [
                np.array(tick.orders["r"].command.joints["arm"].positions) - sim.motions()["r/arm"].positions
                for tick in islice(mjsim.ticks(sim, {"r": driver}), 110)
            ]
        worst[kind] = np.abs(found[40:]).max()
    assert worst[Adaptive] * 3.0 < worst[ComputedTorque]


@pytest.mark.slow
def test_without_a_controller_an_arm_holds_its_start_and_then_its_goal():
    here = world(arm="preset: puma560, start_deg: [10, 20, -30, 40, 50, 60]")
    with mjsim.Simulation(here) as sim:
        start = np.radians([10, 20, -30, 40, 50, 60])
        for _ in range(50):
            sim.step()
        np.testing.assert_allclose(sim.motions()["r/arm"].positions, start, atol=0.01)
        sim.apply("r", Command(joints={"arm": JointGoal(positions=tuple(start + 0.1))}))
        for _ in range(50):
            sim.step()
        # Dry friction holds it short of its goal: of joint 4 by 0.85 N m / (25^2 0.22 kg m^2).
        np.testing.assert_allclose(sim.motions()["r/arm"].positions, start + 0.1, atol=0.02)


def test_encoders_and_motion_tell_what_mujoco_has():
    here = world()
    with mjsim.Simulation(here) as sim:
        sim.apply("r", Command(joints={"arm": JointGoal(positions=tuple(MOVE))}))
        for _ in range(5):
            sim.step()
        state, motion = sim.sense("r").joints["arm"], sim.motions()["r/arm"]
        np.testing.assert_array_equal(state.positions, sim.data.qpos)
        np.testing.assert_array_equal(state.velocities, sim.data.qvel)
        np.testing.assert_array_equal(motion.positions, state.positions)
        assert state.stamp == pytest.approx(0.2)
        np.testing.assert_array_equal(motion.goal, MOVE)
        np.testing.assert_array_equal(motion.torques, sim.data.qfrc_actuator)
        np.testing.assert_array_equal(state.torques, sim.data.qfrc_actuator)
        np.testing.assert_array_equal(motion.accelerations, sim.data.qacc)
        world_from_robot = np.array([[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 0], [0, 0, 0, 1.0]])
        tool = world_from_robot @ sim.robots["r"].arms["arm"].model.fkine(state.positions)
        np.testing.assert_allclose(motion.tool, tool, atol=1e-12)
        assert np.abs(state.torques[1]) <= 186.4


LINKS = (
    "rows: [{a: 0.3, range_deg: [-80, 90], torque: 20, velocity_deg: 50},"
    " {a: 0.2, range_deg: [-100, 120], torque: 30, velocity_deg: 60}]"
)


def test_joints_of_an_arm_on_a_rolling_base_are_those_of_their_names():
    text = f"""
mjsim: 1
robots:
  - {{name: r, preset: husky, at: [1, 2], arms: [{{name: left, dh: {{{LINKS}}}, at: [0, 0, 0.5]}}]}}
"""
    with mjsim.Simulation(parse_world(text)) as sim:
        sim.apply("r", Command(0.3, joints={"left": JointGoal(positions=(0.4, -0.3))}))
        for _ in range(3):
            sim.step()
        motion, seen = sim.motions()["r/left"], sim.sense("r").joints["left"]
        joints = [sim.data.joint(f"r/left/joint{number}") for number in (1, 2)]
        for told, key in ((motion.positions, "qpos"), (motion.velocities, "qvel"), (motion.accelerations, "qacc")):
            np.testing.assert_array_equal(told, [getattr(joint, key)[0] for joint in joints])
        np.testing.assert_array_equal(seen.positions, motion.positions)
        np.testing.assert_array_equal(seen.velocities, motion.velocities)
        assert np.abs(motion.positions).min() > 1e-4
        info = sim.robots["r"].arms["left"]
    assert info.joints == ("joint1", "joint2")
    np.testing.assert_allclose(np.degrees([info.lower, info.upper]), [[-80, -100], [90, 120]])
    assert info.max_torque.tolist() == [20.0, 30.0]
    np.testing.assert_allclose(np.degrees(info.max_velocity), [50, 60])


def test_an_arm_that_an_event_moves_goes_at_its_rates_to_the_place_and_takes_no_other_goal():
    with mjsim.Simulation(world()) as sim:
        arm = sim._robots["r"].arm("arm")
        rates = np.minimum([link.max_velocity for link in arm.info.model.links], 1.0)
        to = np.array([0.1, -0.02, 0.5, 0.0, -0.5, 0.03])
        arm.lead(to)
        for tick in range(1, 5):
            arm.command(JointGoal(positions=tuple(MOVE)))
            arm.before_step()
            for step in range(10):
                wanted = arm.wanted(0.004).joints["arm"]
                farthest = rates * 0.04 * (tick - 1 + step / 10)
                np.testing.assert_allclose(np.abs(wanted.positions[2]), farthest[2])
            farthest = rates * 0.04 * tick
            np.testing.assert_allclose(arm.goal(), np.clip(to, -farthest, farthest))
        arm.lead(None)
        arm.command(JointGoal(positions=tuple(MOVE)))
        np.testing.assert_array_equal(arm.goal(), MOVE)


def test_a_goal_moves_on_for_one_tick_and_holds_then():
    here = world(controlled("ComputedTorque"))
    with mjsim.Simulation(here) as sim:
        goal = JointGoal(positions=(0.0,) * 6, velocities=(0.25, 0, 0, 0, 0, 0), accelerations=(0.0,) * 6)
        sim.apply("r", Command(joints={"arm": goal}))
        for _ in range(25):
            sim.step()
        np.testing.assert_allclose(sim.motions()["r/arm"].goal[0], 0.25 * sim.dt)


def test_the_same_seed_moves_an_arm_the_same_way_after_a_reset():
    here = world(controlled("ComputedTorque"))
    with mjsim.Simulation(here) as sim:
        found = []
        for _ in range(2):
            for _ in range(10):
                sim.apply("r", Command(joints={"arm": JointGoal(positions=tuple(MOVE))}))
                sim.step()
            found.append(sim.state()[0])
            sim.reset()
    np.testing.assert_array_equal(*found)


def test_an_arm_that_nobody_holds_falls_along_the_motion_of_its_equations():
    text = world().source.text
    here = parse_world(text.replace("seconds: 2", "seconds: 2, step_ms: 1"))
    with mjsim.Simulation(here) as sim:
        arm = sim.robots["r"].arms["arm"].model

        class Idle:
            def start(self, robot, part, rng):
                pass

            def torques(self, sensed, wanted):
                return [0.0] * 6

        sim.control("r", {"arm": Idle()})
        sim.data.qpos[:] = q = np.array([0.2, 0.3, -0.9, 0.1, 0.2, 0.3])
        sim.step()
        qdd = sim.motions()["r/arm"].accelerations
        q, qd = sim.state()
    # Joint 2 falls against its gravity, friction and all; the step behind it is 1 ms.
    force = arm.rne(q, qd, qdd)
    assert np.abs(force[1]) < 0.02 * np.abs(arm.gravload(q)[1])


@pytest.mark.slow
def test_a_path_of_jtraj_set_by_hand_step_by_step_is_followed():
    here = world(controlled("ComputedTorque"))
    q, qd, qdd = jtraj(np.zeros(6), MOVE, np.arange(51) * 0.04)
    with mjsim.Simulation(here) as sim:
        sim.control("r", drivers_of(here)["r"].controllers)
        for goal in zip(q.tolist(), qd.tolist(), qdd.tolist(), strict=True):
            positions, velocities, accelerations = map(tuple, goal)
            joints = JointGoal(positions=positions, velocities=velocities, accelerations=accelerations)
            sim.apply("r", Command(joints={"arm": joints}))
            assert np.abs(sim.motions()["r/arm"].positions - positions).max() < 5e-4
            sim.step()


GOALS = {
    "robot 'r' has no arm 'left'; there are arm": {"left": JointGoal(positions=(0.0,) * 6)},
    "the goal of arm 'arm' has positions (0.0,); give 6 finite numbers, one for each joint": {
        "arm": JointGoal(positions=(0.0,))
    },
    f"the goal of arm 'arm' has velocities {(float('inf'),) * 6}; give 6 finite numbers, one for each joint": {
        "arm": JointGoal(positions=(0.0,) * 6, velocities=(float("inf"),) * 6)
    },
}


@pytest.mark.parametrize(("sentence", "joints"), GOALS.items())
def test_a_goal_that_does_not_fit_is_refused_in_one_sentence(sentence, joints):
    with mjsim.Simulation(world()) as sim, pytest.raises(UsageError) as caught:
        sim.apply("r", Command(joints=joints))
    assert str(caught.value) == sentence


MODULES = {
    "returned a goal for arm 'left'; there are arm": {"left": JointGoal(positions=(0.0,) * 6)},
    "returned a goal of arm 'arm' that is a value of type list; it must be a JointGoal": {"arm": [0.0] * 6},
    "returned joints that are a value of type list; they must be a dict: arm -> JointGoal": [1],
}


@pytest.mark.parametrize(("part", "joints"), MODULES.items())
def test_a_navigator_with_a_wrong_goal_ends_the_run_in_one_line(part, joints):
    class Wrong:
        def start(self, robot, map, rng):
            pass

        def command(self, seen, belief):
            return Command(joints=joints)

    with mjsim.Simulation(world()) as sim, pytest.raises(ModuleFault) as caught:
        next(mjsim.ticks(sim, {"r": mjsim.Driver(navigator=Wrong())}))
    assert part in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_controller_of_an_arm_that_returns_too_few_torques_ends_the_run():
    class Few:
        def start(self, robot, part, rng):
            pass

        def torques(self, sensed, wanted):
            return [0.0]

    with mjsim.Simulation(world()) as sim:
        sim.control("r", {"arm": Few()})
        with pytest.raises(ModuleFault, match=r"returned 1 torques; the motors are arm/joint1"):
            sim.step()


@pytest.mark.parametrize("key", ["frequency", "mass_scale"])
def test_a_controller_with_a_gain_that_cannot_be_is_refused(key):
    with pytest.raises((UsageError, ModuleFault), match=f"{key} is -1; it must be above 0"):
        drivers_of(world(controlled("ComputedTorque", **{key: -1})))


@pytest.mark.slow
def test_an_arm_on_a_rolling_base_drives_along_and_reaches():
    here = parse_world(
        "mjsim: 1\nrobots: [{name: r, preset: husky, at: [0, 0], arms: [{preset: puma560, at: [0.2, 0, 0.4],"
        " start_deg: [0, 90, -90, 0, 0, 0]}]}]"
    )
    with mjsim.Simulation(here) as sim:
        goal = JointGoal(positions=tuple(np.radians([30, 90, -90, 0, 20, 0])))
        for _ in range(100):
            sim.apply("r", Command(forward=0.3, joints={"arm": goal}))
            sim.step()
        assert 0.8 < sim.truth("r").x < 1.2
        np.testing.assert_allclose(sim.motions()["r/arm"].positions, goal.positions, atol=0.05)
        tool = sim.pose("r") @ sim.robots["r"].arms["arm"].model.fkine(sim.sense("r").joints["arm"].positions)
        np.testing.assert_allclose(sim.motions()["r/arm"].tool, tool, atol=1e-9)


def test_a_fixed_base_stays_where_it_is_and_cannot_be_moved():
    with mjsim.Simulation(world()) as sim:
        sim.apply("r", Command(forward=1.0))
        sim.step()
        assert sim.truth("r") == mjsim.Pose(1.0, 2.0, pytest.approx(np.pi / 2))
        assert sim.sense("r").odometry.forward == 0.0
        with pytest.raises(UsageError, match=r"^no robot or movable obstacle 'r' in this world; there are none$"):
            sim.move("r", mjsim.Pose(0.0, 0.0, 0.0))
