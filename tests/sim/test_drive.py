import itertools
import math

import numpy as np
import pytest
from scipy.stats import chi2

from mjsim.errors import UsageError
from mjsim.geometry import Pose, wrap_angle
from mjsim.interface import Command, WheelCommand
from mjsim.sim import Simulation
from mjsim.sim.bases.differential import DifferentialKinematics
from mjsim.sim.bases.twist_profile import TwistProfile
from mjsim.world import DifferentialDrive as DriveModel
from mjsim.world import DriveNoise, parse_world

PIONEER = DifferentialKinematics(wheel_radius=0.0975, track=0.33)
SIZES = {
    "pioneer": "body: {mass: 9}",
    "light": "body: {mass: 1, radius: 0.07, height: 0.1}, drive: {wheel_radius: 0.033, track: 0.1, max_turn_deg: 180}",
    "heavy": "body: {mass: 80, radius: 0.4, height: 1.2}, drive: {wheel_radius: 0.12, track: 0.5}",
}


def meadow(robots: list[str], *, rate: float = 25, seed: int = 1) -> Simulation:
    """Return robots that stand 10 m from each other on an empty floor, heading 30 degrees."""
    lines = [
        f"  - {{name: r{k}, at: [{10 * (k % 8)}, {10 * (k // 8)}], heading_deg: 30, {keys}}}"
        for k, keys in enumerate(robots)
    ]
    text = "mjsim: 1\nrobots:\n" + "\n".join(lines) + f"\nrun: {{rate_hz: {rate}, seed: {seed}}}\n"
    return Simulation(parse_world(text))


def drive_for(sim: Simulation, seconds: float) -> list[dict[str, Pose]]:
    """Return where the robots were at each tick."""
    poses = [sim.truths()]
    for _ in range(round(seconds / sim.dt)):
        sim.step()
        poses.append(sim.truths())
    return poses


def turned(poses: list[dict[str, Pose]], name: str) -> float:
    headings = [pose[name].heading for pose in poses]
    return sum(wrap_angle(after - before) for before, after in itertools.pairwise(headings))


def driven(poses: list[dict[str, Pose]], name: str) -> float:
    return sum((a[name].inverse() @ b[name]).x for a, b in itertools.pairwise(poses))


def test_wheels_and_twist_are_inverse_to_each_other():
    kinematics = DifferentialKinematics(wheel_radius=0.1, track=0.4)
    for forward, turn in np.random.default_rng(0).uniform(-2.0, 2.0, (50, 2)):
        twist = kinematics.twist_from_wheels(kinematics.wheels_from_twist(forward, 0.0, turn))
        np.testing.assert_allclose(twist, (forward, 0.0, turn), atol=1e-12)


def test_a_robot_with_one_wheel_at_rest_turns_about_that_wheel():
    forward, _, turn = DifferentialKinematics(wheel_radius=0.1, track=0.4).twist_from_wheels((0.0, 5.0))
    assert turn == pytest.approx(0.1 * 5.0 / 0.4)
    assert forward / turn == pytest.approx(0.2)


@pytest.mark.parametrize("speed", [0.1, 0.35, 0.7, -0.4])
def test_distance_is_speed_times_time(speed):
    sim = meadow(list(SIZES.values()))
    for name in sim.robots:
        sim.apply(name, Command(speed))
    drive_for(sim, 1.0)
    poses = drive_for(sim, 3.0)
    for name in sim.robots:
        moved = poses[0][name].inverse() @ poses[-1][name]
        assert moved.x == pytest.approx(speed * 3.0, rel=0.02), name
        # Straight: nothing in a model that is alike on both sides may turn it.
        assert abs(moved.y) < 1e-3, name
        assert abs(moved.heading) < 1e-3, name


def test_from_rest_the_ramp_costs_half_a_speed_squared_over_the_acceleration():
    sim = meadow(["drive: {max_acceleration: 0.8}"])
    sim.apply("r0", Command(0.6))
    poses = drive_for(sim, 4.0)
    assert driven(poses, "r0") == pytest.approx(0.6 * 4.0 - 0.6**2 / (2 * 0.8), rel=0.005)


@pytest.mark.parametrize("turn", [0.3, -1.5])
def test_on_the_spot_a_robot_turns_by_rate_times_time_and_stays(turn):
    sim = meadow(list(SIZES.values()))
    for name in sim.robots:
        sim.apply(name, Command(turn=turn))
    drive_for(sim, 1.0)
    poses = drive_for(sim, 3.0)
    for name in sim.robots:
        assert turned(poses, name) == pytest.approx(turn * 3.0, rel=0.02), name
        assert math.hypot(*(poses[0][name].inverse() @ poses[-1][name]).as_array()[:2]) < 0.005, name


def test_on_an_arc_a_robot_keeps_the_circle_of_speed_over_turn_rate():
    sim = meadow(list(SIZES.values()))
    speed, turn = 0.4, 0.8
    for name in sim.robots:
        sim.apply(name, Command(speed, turn=turn))
    drive_for(sim, 1.0)
    poses = drive_for(sim, 2 * math.pi / turn)
    for name in sim.robots:
        path = np.array([pose[name].as_array()[:2] for pose in poses])
        # A circle through points: x^2 + y^2 = 2 a x + 2 b y + c, linear in (a, b, c).
        lines = np.column_stack([2 * path, np.ones(len(path))])
        a, b, c = np.linalg.lstsq(lines, (path**2).sum(axis=1), rcond=None)[0]
        assert math.sqrt(c + a**2 + b**2) == pytest.approx(speed / turn, rel=0.02), name
        np.testing.assert_allclose(np.hypot(*(path - [a, b]).T), speed / turn, rtol=0.02)
        assert turned(poses, name) == pytest.approx(2 * math.pi, rel=0.02), name


def test_wheel_commands_drive_as_the_twist_that_they_stand_for():
    sim = meadow([SIZES["pioneer"], SIZES["pioneer"]])
    sim.apply("r0", Command(0.3, turn=0.5))
    sim.apply("r1", WheelCommand(PIONEER.wheels_from_twist(0.3, 0.0, 0.5)))
    poses = drive_for(sim, 2.0)
    first, second = (poses[0][name].inverse() @ poses[-1][name] for name in ("r0", "r1"))
    np.testing.assert_allclose(first.as_array(), second.as_array(), atol=1e-6)


def test_a_command_beyond_the_limits_is_slowed_as_a_whole_so_that_its_path_stays():
    limits = DriveModel(max_speed=0.7, max_turn_deg=100, max_acceleration=100, max_turn_acceleration_deg=36000)
    drive = TwistProfile(limits, kinematics=PIONEER, dt=0.04, stream=np.random.default_rng(0))
    for forward, turn in ((7.0, 2.0), (0.7, 8.0), (-3.0, 3.0), (1e9, -1e8)):
        drive.command(Command(forward, turn=turn))
        for _ in range(3):
            wheels = drive.advance()
        speed, _, rate = PIONEER.twist_from_wheels(wheels)
        assert rate / speed == pytest.approx(turn / forward)
        assert max(abs(speed) / 0.7, abs(rate) / math.radians(100)) == pytest.approx(1.0)


def test_sideways_commands_are_ignored_by_a_drive_that_cannot():
    sim = meadow([SIZES["pioneer"]])
    sim.apply("r0", Command(left=0.5))
    poses = drive_for(sim, 1.0)
    np.testing.assert_allclose((poses[0]["r0"].inverse() @ poses[-1]["r0"]).as_array(), 0.0, atol=1e-4)


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (Command(math.nan), "robot 'r0'.*finite"),
        (Command(turn=math.inf), "robot 'r0'.*finite"),
        (Command("fast"), "not a command for robot 'r0'"),
        (0.3, "not a command for robot 'r0'"),
        (WheelCommand((1.0, 2.0, 3.0)), "3 wheel speeds for robot 'r0'; its wheels are wheel_left, wheel_right"),
        (WheelCommand((math.nan, 0.0)), "robot 'r0'.*finite"),
    ],
)
def test_a_command_that_cannot_be_is_refused_by_name(command, said):
    with pytest.raises(UsageError, match=said):
        meadow([SIZES["pioneer"]]).apply("r0", command)


def test_noise_on_the_twist_is_white_with_the_density_given_whatever_the_rate():
    for dt in (0.02, 0.04):
        model = DriveModel(noise=DriveNoise(speed=0.02, turn=0.05))
        drive = TwistProfile(model, kinematics=PIONEER, dt=dt, stream=np.random.default_rng(3))
        twists = np.array([PIONEER.twist_from_wheels(drive.advance()) for _ in range(5000)])[:, ::2]
        # The distance of a tick has variance sigma^2 dt.
        spread = np.sum((twists * dt) ** 2, axis=0) / (np.array([0.02, 0.05]) ** 2 * dt)
        assert (spread > chi2.ppf(0.001, 5000)).all()
        assert (spread < chi2.ppf(0.999, 5000)).all()
        # White: neighbours do not go together; 4 standard deviations of a correlation of 5000 pairs.
        assert abs(np.corrcoef(twists[1:, 0], twists[:-1, 0])[0, 1]) < 4 / math.sqrt(5000)


@pytest.mark.slow
@pytest.mark.parametrize("rate", [12.5, 50])
def test_robots_wander_by_the_noise_of_their_drives_at_any_rate(rate):
    count, seconds = 32, 4.0
    sim = meadow(["drive: {noise: {speed: 0.02, turn: 0.02}}"] * count, rate=rate, seed=round(rate))
    drive_for(sim, 0.5)
    poses = drive_for(sim, seconds)
    for moves in ([driven(poses, name) for name in sim.robots], [turned(poses, name) for name in sim.robots]):
        spread = np.sum(np.square(moves)) / (0.02**2 * seconds)
        assert chi2.ppf(0.001, count) < spread < chi2.ppf(0.999, count)


def test_another_robot_leaves_the_noise_of_the_first_as_it_was():
    noisy = "drive: {noise: {speed: 0.02, turn: 0.02}}, odometry: {noise: {distance: 0.01, turn: 0.02}}"
    alone, together = meadow([noisy]), meadow([noisy, noisy])
    for _ in range(50):
        alone.step()
        together.step()
        assert alone.data.ctrl.tobytes() == together.data.ctrl[:2].tobytes()
    # The solver takes both robots in one system and rounds otherwise; noise would be larger by far.
    np.testing.assert_allclose(alone.truth("r0").as_array(), together.truth("r0").as_array(), atol=1e-6)
