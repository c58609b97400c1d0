"""Every kind of drive but the differential one, through contact with a level floor."""

import itertools
import math
from collections.abc import Mapping

import numpy as np
import pytest

from mjsim.geometry import Pose, wrap_angle
from mjsim.interface import Command, WheelCommand
from mjsim.sim import Simulation
from mjsim.sim.bases.ackermann import AckermannSteering
from mjsim.sim.bases.makers import MAKERS
from mjsim.sim.bases.mecanum import mecanum
from mjsim.sim.bases.omni3 import omni3
from mjsim.sim.bases.tricycle import TricycleKinematics
from mjsim.world import MecanumDrive, Omni3Drive, parse_world
from mjsim.world.items.drives.fixed import FixedDrive
from mjsim.world.items.drives.kinds import KINDS

ROBOTS = {
    "skid": "drive: {type: skid_steer, wheel_radius: 0.165, track: 0.55, wheelbase: 0.5, max_speed: 1},"
    " body: {box: [1, 0.67, 0.37], mass: 46}",
    "car": "drive: {type: ackermann, max_speed: 3}, body: {box: [0.5, 0.28, 0.2], at: [0.165, 0], mass: 3.5}",
    "forklift": "drive: {type: tricycle, wheel_radius: 0.115, load_wheel_radius: 0.0425, track: 0.4, wheelbase: 1.2},"
    " body: {box: [2, 0.8, 1.2], at: [-0.5, 0], mass: 400}",
    "tricycle": "drive: {type: tricycle, driven: front}, body: {box: [0.9, 0.5, 0.4], at: [0.3, 0], mass: 40}",
    "omni3": "drive: {type: omni3}, body: {radius: 0.2}",
    "mecanum": "drive: {type: mecanum}, body: {polygon: [[-0.3, 0], [0, -0.2], [0.3, 0], [0, 0.2]], mass: 20}",
}
QUIET = "odometry: {noise: {distance: 0, turn: 0}}"
ON_THE_SPOT = ("forklift", "tricycle", "omni3", "mecanum")
ALL_BUT_SKID = ("car", *ON_THE_SPOT)
HOLONOMIC = ("omni3", "mecanum")


def meadow(names: tuple[str, ...]) -> Simulation:
    """Return robots that stand 20 m from each other on an empty floor, heading 30 degrees."""
    lines = [
        f"  - {{name: {n}, at: [{20 * k}, 0], heading_deg: 30, {QUIET}, {ROBOTS[n]}}}\n" for k, n in enumerate(names)
    ]
    return Simulation(parse_world("mjsim: 1\nrobots:\n" + "".join(lines)))


def driven(names: tuple[str, ...], command: Command | WheelCommand, seconds: float) -> Mapping[str, list[Pose]]:
    """Return where robots were at each tick after they have followed a command for two seconds."""
    with meadow(names) as sim:
        for name in names:
            sim.apply(name, command)
        poses = []
        for _ in range(round((2.0 + seconds) / sim.dt)):
            sim.step()
            poses.append(sim.truths())
        first = round(2.0 / sim.dt) - 1
    return {name: [pose[name] for pose in poses[first:]] for name in names}


def turned(path: list[Pose]) -> float:
    return sum(wrap_angle(after.heading - before.heading) for before, after in itertools.pairwise(path))


def circle(path: list[Pose]) -> tuple[float, float]:
    """Return the radius of the circle that fits best, and how far the path leaves it [m]."""
    points = np.array([pose.as_array()[:2] for pose in path])
    # x^2 + y^2 = 2 a x + 2 b y + c is linear in (a, b, c).
    a, b, c = np.linalg.lstsq(np.column_stack([2 * points, np.ones(len(points))]), (points**2).sum(axis=1))[0]
    radius = math.sqrt(c + a**2 + b**2)
    return radius, float(np.abs(np.hypot(*(points - [a, b]).T) - radius).max())


@pytest.mark.slow
@pytest.mark.parametrize("speed", [0.5, -0.3])
def test_straight_on_the_way_is_speed_times_time(speed):
    for name, path in driven(tuple(ROBOTS), Command(speed), 2.0).items():
        moved = path[0].inverse() @ path[-1]
        assert moved.x == pytest.approx(speed * 2.0, rel=0.02), name
        assert abs(moved.y) < 0.005, name
        assert abs(moved.heading) < 0.005, name


@pytest.mark.slow
def test_on_the_spot_those_that_can_turn_by_rate_times_time():
    for name, path in driven(ON_THE_SPOT, Command(turn=-0.8), 2.0).items():
        assert turned(path) == pytest.approx(-1.6, rel=0.02), name
        assert math.hypot(*(path[0].inverse() @ path[-1]).as_array()[:2]) < 0.005, name


@pytest.mark.slow
def test_arcs_are_circles_of_speed_over_turn_rate():
    for name, path in driven(ALL_BUT_SKID, Command(0.5, turn=0.5), 4.0).items():
        radius, off = circle(path)
        assert radius == pytest.approx(1.0, rel=0.02), name
        assert off < 0.01, name
        assert turned(path) == pytest.approx(2.0, rel=0.02), name


@pytest.mark.slow
@pytest.mark.parametrize("command", [Command(left=0.4), Command(0.3, left=-0.3), Command(0.2, left=0.2, turn=0.4)])
def test_holonomic_robots_go_sideways_at_the_speed_they_are_told(command):
    for name, path in driven(HOLONOMIC, command, 2.0).items():
        way = sum(math.hypot(b.x - a.x, b.y - a.y) for a, b in itertools.pairwise(path))
        speed = math.hypot(command.forward, command.left)
        assert way == pytest.approx(2.0 * speed, rel=0.02), name
        assert turned(path) == pytest.approx(2.0 * command.turn, rel=0.02, abs=0.01), name
        # Halfway through the turn of a tick the robot moves where it is told to, seen from itself.
        step = Pose(0, 0, -(path[0].inverse() @ path[1]).heading / 2) @ (path[0].inverse() @ path[1])
        assert math.atan2(step.y, step.x) == pytest.approx(math.atan2(command.left, command.forward), abs=0.05), name


def test_a_skid_steered_robot_turns_less_than_its_wheels_say_and_within_a_tenth_of_what_its_own_track_says():
    (path,) = driven(("skid",), Command(turn=0.6), 3.0).values()
    # Four equal loads: friction has no moment for rims at w (a^2 + b^2) / b; that is the track it steers with.
    assert turned(path) == pytest.approx(1.8, rel=0.1)
    wheels = 0.6 * (0.275**2 + 0.25**2) / 0.275 / 0.165
    (path,) = driven(("skid",), WheelCommand((-wheels, wheels, -wheels, wheels)), 3.0).values()
    assert turned(path) == pytest.approx(1.8, rel=0.1)
    assert turned(path) < 0.6 * wheels * 0.165 * 3.0 / 0.275


def test_a_car_cannot_turn_on_the_spot_and_turns_no_sharper_than_its_steering_lets_it():
    (path,) = driven(("car",), Command(turn=1.0), 1.0).values()
    assert math.dist(path[0].as_array(), path[-1].as_array()) < 1e-3
    (path,) = driven(("car",), Command(0.4, turn=1.6), 3.0).values()
    assert circle(path)[0] == pytest.approx(0.33 / math.tan(math.radians(24)), rel=0.02)


def test_steering_turns_no_faster_than_it_can():
    with meadow(("car",)) as sim:
        sim.apply("car", Command(0.5, turn=0.6))
        angles = []
        for _ in range(20):
            sim.step()
            angles.append(sim.data.joint("car/steer_front_left").qpos[0])
    # 180 degrees a second; the inner wheel steers a little faster than the middle, and the servo lags and catches up.
    assert max(np.diff(angles)) < 1.3 * math.pi * 0.04
    assert angles[-1] == pytest.approx(AckermannSteering(0.25, 0.33).angles(math.atan(0.33 * 1.2))[0], rel=0.02)


@pytest.mark.slow
def test_odometry_tells_the_motion_as_it_was_but_for_what_slips():
    drift = {"skid": 0.1, "mecanum": 0.05, "omni3": 0.02}
    names = tuple(ROBOTS)
    with meadow(names) as sim:
        told = {name: sim.truth(name) for name in names}
        for tick in range(100):
            for name in names:
                sim.apply(name, Command(0.4, left=0.2, turn=0.5 if tick < 60 else -0.3))
            sim.step()
            for name in names:
                seen = sim.sense(name).odometry
                told[name] = told[name] @ Pose(seen.forward, seen.left, seen.turn)
        for name in names:
            error = told[name].inverse() @ sim.truth(name)
            assert math.hypot(error.x, error.y) < 1.7 * drift.get(name, 0.005), name
            assert abs(error.heading) < drift.get(name, 0.005), name


def test_wheel_commands_come_in_the_order_of_the_wheels():
    with meadow(("mecanum",)) as sim:
        assert sim.robots["mecanum"].wheels == (
            "wheel_front_left",
            "wheel_front_right",
            "wheel_rear_left",
            "wheel_rear_right",
        )
        # Front left and rear right backward, the others forward: to the left.
        sim.apply("mecanum", WheelCommand((-5.0, 5.0, 5.0, -5.0)))
        start = sim.truth("mecanum")
        for _ in range(50):
            sim.step()
        moved = start.inverse() @ sim.truth("mecanum")
    assert moved.y > 0.3
    assert abs(moved.x) < 0.01


def test_mecanum_kinematics_are_those_of_taheri():
    # Equation 20 of Taheri et al. with half wheelbase 0.235 m and half track 0.15 m, wheels of 0.05 m.
    lever = 0.235 + 0.15
    exact = MecanumDrive(type="mecanum", strafe=1.0, spin=1.0)
    speeds = mecanum(exact).wheels_from_twist(0.3, -0.2, 0.7)
    expected = [0.3 + 0.2 - lever * 0.7, 0.3 - 0.2 + lever * 0.7, 0.3 - 0.2 - lever * 0.7, 0.3 + 0.2 + lever * 0.7]
    np.testing.assert_allclose(np.array(speeds) * 0.05, expected, atol=1e-12)


def test_wheels_with_rollers_run_faster_by_what_they_slip_and_tell_the_motion_driven():
    exact = mecanum(MecanumDrive(type="mecanum", strafe=1.0, spin=1.0))
    slipping = mecanum(MecanumDrive(type="mecanum", strafe=0.98, spin=0.9))
    speeds = slipping.wheels_from_twist(0.3, -0.2, 0.7)
    np.testing.assert_allclose(speeds, exact.wheels_from_twist(0.3, -0.2 / 0.98, 0.7 / 0.9), atol=1e-12)
    np.testing.assert_allclose(slipping.twist_from_wheels(speeds), (0.3, -0.2, 0.7), atol=1e-12)


def test_three_omni_wheels_at_one_speed_turn_and_two_against_each_other_go_ahead():
    kinematics = omni3(Omni3Drive(type="omni3"))
    np.testing.assert_allclose(kinematics.twist_from_wheels((3.0, 3.0, 3.0)), (0, 0, 3.0 * 0.05 / 0.15), atol=1e-12)
    forward, left, turn = kinematics.twist_from_wheels((-3.0, 0.0, 3.0))
    assert forward == pytest.approx(3.0 * 0.05 / math.cos(math.pi / 6))
    np.testing.assert_allclose((left, turn), 0.0, atol=1e-12)


@pytest.mark.parametrize("kinematics", [omni3(Omni3Drive(type="omni3")), mecanum(MecanumDrive(type="mecanum"))])
def test_twist_and_wheels_with_rollers_are_inverse_to_each_other(kinematics):
    for twist in np.random.default_rng(0).uniform(-1, 1, (50, 3)):
        back = kinematics.twist_from_wheels(kinematics.wheels_from_twist(*twist))
        np.testing.assert_allclose(back, twist, atol=1e-12)


def test_the_mean_twist_of_a_wheel_that_is_steered_meanwhile_is_that_of_many_moments():
    kinematics = TricycleKinematics(wheel_radius=0.1, place=-0.8)
    for before, after in [(0.2, 0.5), (-1.0, 0.4), (0.3, 0.3), (0.3, 0.30001)]:
        moments = before + (after - before) * (np.arange(2000) + 0.5) / 2000
        mean = np.mean([kinematics.twist(3.0, angle) for angle in moments.tolist()], axis=0)
        # The midpoint rule errs by its step squared.
        np.testing.assert_allclose(kinematics.mean_twist(3.0, before, after), mean, atol=1e-7)
    # Of a cosine over a small change: the difference of sines over it.
    before, after = 0.3, 0.30019
    forward, _, _ = kinematics.mean_twist(3.0, before, after)
    assert forward == pytest.approx(0.3 * (math.sin(after) - math.sin(before)) / (after - before), rel=1e-11)


def test_the_wheel_of_a_tricycle_stands_across_the_way_to_the_centre_of_the_turn():
    for place, (forward, turn) in itertools.product((0.6, -1.2), np.random.default_rng(1).uniform(-1, 1, (20, 2))):
        kinematics = TricycleKinematics(wheel_radius=0.1, place=place)
        rim, steer = kinematics.wheel(forward, turn)
        assert abs(steer) <= math.pi / 2
        np.testing.assert_allclose(kinematics.twist(rim / 0.1, steer), (forward, 0.0, turn), atol=1e-12)
        # From the centre at (0, forward / turn) to the wheel at (place, 0), and along the wheel.
        assert place * math.cos(steer) - forward / turn * math.sin(steer) == pytest.approx(0.0, abs=1e-9)


def test_a_tricycle_begins_to_turn_no_faster_than_its_driven_wheel_gathers_speed():
    with meadow(("forklift",)) as sim:
        sim.apply("forklift", Command(turn=2.0))
        headings = []
        for _ in range(50):
            sim.step()
            headings.append(sim.truths()["forklift"].heading)
        told = sim.robots["forklift"].max_turn_acceleration
    assert told == pytest.approx(1.0 / 1.2)
    rates = np.diff(headings) / sim.dt
    assert 0.5 * told < (rates[-1] - rates[24]) / (25 * sim.dt) < 1.05 * told


def test_both_steered_wheels_of_a_car_point_across_one_centre():
    left, right = AckermannSteering(track=0.25, wheelbase=0.33).angles(0.3)
    centre = 0.33 / math.tan(0.3)
    assert 0.33 / math.tan(left) + 0.125 == pytest.approx(centre)
    assert 0.33 / math.tan(right) - 0.125 == pytest.approx(centre)


def test_every_drive_of_the_language_has_a_base_at_work():
    assert set(MAKERS) == {*KINDS.values(), FixedDrive}
