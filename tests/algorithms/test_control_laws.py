"""Laws of control, each computed another way: balancing, joints, mechanisms, speeds; and ways around things."""

import itertools
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mjsim.algorithms.arm_control import ComputedTorque, PdGravity
from mjsim.algorithms.balance import Lean, Lqr, plant, regulator, turning_plant
from mjsim.algorithms.estimation.recent_motion import RecentMotion
from mjsim.algorithms.go_to_goal.go_to_goal import GoToGoal
from mjsim.algorithms.linear_control import JointLoop, MechanismLoop, SpeedLoop
from mjsim.algorithms.paths.sampling_planners import Roadmap
from mjsim.algorithms.signal import Signal
from mjsim.geometry import Pose, wrap_angle
from mjsim.interface import (
    ArmInfo,
    BalancingInfo,
    Command,
    Estimate,
    ImuReading,
    JointGoal,
    JointState,
    Observation,
    Odometry,
    SensorInfo,
    Sighting,
    WorldMap,
)
from tests.algorithms.test_formulas import RNG, Q, R
from tests.algorithms.test_joint_path import PUMA
from tests.robots import pioneer

MASSES = BalancingInfo(
    wheel_mass=0.5, wheel_inertia=0.003, wheel_across=0.002, body_mass=8.0, center=0.2, pitch_inertia=0.15,
    yaw_inertia=0.1, max_torque=3.0,
)  # fmt: skip
RADIUS, TRACK = 0.1, 0.4


def test_the_plant_of_a_balancing_base_is_that_of_its_energies():
    # Lagrange: T = 1/2 (m + 2 mw + 2 Iw / r^2) v^2 + m h v w + 1/2 (I + m h^2) w^2, V = m g h cos(pitch).
    A, B = plant(MASSES, wheel_radius=RADIUS)
    m, h = 8.0, 0.2
    M = np.array([[m + 1.0 + 0.006 / 0.01, m * h], [m * h, 0.15 + m * h**2]])
    for pitch, torque in ((0.01, 0.0), (0.0, 2.0), (-0.02, 1.0)):
        rates = A @ [0.3, pitch, 0.1, 0.2] + B[:, 0] * torque
        np.testing.assert_allclose(rates[:2], [0.1, 0.2])
        np.testing.assert_allclose(M @ rates[2:], [torque / RADIUS, m * 9.81 * h * pitch - torque], atol=1e-12)
    A, B = turning_plant(MASSES, wheel_radius=RADIUS, track=TRACK)
    inertia = 0.1 + 2 * (0.002 + (0.5 + 0.3) * 0.04)
    np.testing.assert_allclose(A @ [1.0, 2.0] + B[:, 0] * 3.0, [2.0, 3.0 * 0.4 / 0.2 / inertia])


def test_a_regulator_makes_the_least_cost():
    A, B = np.array([[0.0, 1.0], [2.0, 0.0]]), np.array([[0.0], [1.0]])
    Q_, R_, dt = np.diag([3.0, 1.0]), np.array([[0.5]]), 0.05
    K = np.array(regulator(A, B, Q_, R_, dt=dt))
    whole = solve_ivp(lambda _, x: np.ravel(A @ x.reshape(2, 2)), (0, dt), np.eye(2).ravel(), rtol=1e-10)
    step = whole.y[:, -1].reshape(2, 2)
    pushed = solve_ivp(lambda _, x: A @ x + B[:, 0], (0, dt), np.zeros(2), rtol=1e-10).y[:, -1]

    def cost(gain):
        x, total = np.array([1.0, -0.5]), 0.0
        for _ in range(600):
            u = -gain @ x
            total += x @ Q_ @ x + 0.5 * u**2
            x = step @ x + pushed * u
        return total

    best = cost(K)
    for change in ([0.01, 0.0], [-0.01, 0.0], [0.0, 0.01], [0.0, -0.01]):
        assert cost(K * (1 + np.array(change))) > best


def balancer(**imu):
    mounted = np.eye(4)
    mounted[2, 3] = 0.3
    sensor = SensorInfo(kind="imu", robot_from_sensor=mounted, rate_hz=250.0)
    return pioneer(wheel_radius=RADIUS, track=TRACK, balancing=MASSES, sensors={"imu": sensor}, **imu)


def wheels(left, right, left_rate, right_rate):
    return JointState(0.0, np.array([left, right]), np.array([left_rate, right_rate]), np.zeros(2))


def reading(stamp, pitch_rate, force):
    return ImuReading(stamp, np.array(force), np.array([0.0, pitch_rate, 0.0]))


def fast(imu, state, dt=0.004):
    return SimpleNamespace(dt=dt, wheels=state, imu=imu, joints={})


def test_a_balancing_robot_pushes_against_its_lean_and_twists_towards_its_heading():
    law = Lqr()
    law.start(balancer(), "drive", RNG)
    assert law.torques(fast((), wheels(0, 0, 0, 0)), Command()) == (0.0, 0.0)  # it does not know its pitch
    upright = reading(0.0, 0.0, [0.0, 0.0, 9.81])
    law.torques(fast((upright,), wheels(0, 0, 0, 0)), Command())
    k = law.feedback
    A, B = plant(MASSES, wheel_radius=RADIUS)
    assert np.linalg.eigvals(A - B @ np.array([k])).real.max() < 0.0
    left, right = law.torques(fast((), wheels(0.2, 0.2, 1.0, 1.0)), Command())
    expected = -(k[0] * 0.02 + k[2] * 0.1)
    assert left == pytest.approx(right)
    assert left + right == pytest.approx(expected, rel=1e-9) or abs(left + right) == pytest.approx(6.0)
    left, right = law.torques(fast((), wheels(-0.01, 0.01, 0.0, 0.0)), Command())
    assert right < 0.0 < left  # turned to the left, it turns back
    law.torques(fast((), wheels(0, 0, 0, 0)), Command(0.0, 0.0, 0.0))
    ahead = law.torques(fast((), wheels(0, 0, 0, 0)), Command(0.1, 0.0, 0.0))
    assert sum(ahead) == pytest.approx(k[2] * 0.1, abs=1e-6)
    assert abs(sum(law.torques(fast((), wheels(9, 9, 90, 90)), Command()))) == pytest.approx(6.0)
    fallen = reading(0.004, 0.0, [-9.0, 0.0, 1.0])
    lying = Lqr()
    lying.start(balancer(), "drive", RNG)
    assert lying.torques(fast((fallen,), wheels(0, 0, 0, 0)), Command()) == (0.0, 0.0)
    for weights, turn in (([1.0] * 3, [1.0] * 2), ([1.0] * 4, [1.0] * 3)):
        with pytest.raises(ValueError, match="weights needs four numbers"):
            Lqr(weights, turn_weights=turn)
    with pytest.raises(ValueError, match="does not balance"):
        Lqr().start(pioneer(), "drive", RNG)


@pytest.mark.parametrize("bias", [0.0, 0.02])
def test_the_pitch_of_a_body_is_found_from_gyroscope_and_gravity(bias):
    lean, dt, speed = Lean(balancer()), 0.004, 0.0
    assert not lean.known
    for k in range(10_000 if bias else 6000):
        time = k * dt
        pitch, rate, gain = 0.1 * math.sin(time), 0.1 * math.cos(time), -0.1 * math.sin(time)
        axle = 0.5 * math.cos(2 * time)
        force = axle * math.cos(pitch) + (0.3 - RADIUS) * gain - 9.81 * math.sin(pitch)
        # The wheels turn relative to the body.
        spin = 0.25 * math.sin(2 * time) - RADIUS * rate
        lean.add(reading(time, rate + bias, [force, 0.0, 9.81 * math.cos(pitch)]), spin)
        speed = max(speed, abs(lean.rate))
    assert lean.pitch == pytest.approx(pitch, abs=0.003)
    assert lean.rate == pytest.approx(rate, abs=0.004)
    before = lean.pitch
    other = reading(time + dt, 5.0, [0.0, 0.0, 9.81])
    lean.add(SimpleNamespace(name="other", acceleration=other.acceleration, turn=other.turn, stamp=other.stamp), 0.0)
    assert lean.pitch == before


def arm_info():
    lower, upper = PUMA.limits
    limits = np.full(6, np.inf)
    names = tuple(f"joint{k}" for k in range(1, 7))
    return ArmInfo(joints=names, lower=lower, upper=upper, max_velocity=limits, max_torque=limits, model=PUMA)


@pytest.mark.parametrize(
    ("keys", "torque"), [({"gain": [50.0, 7.0]}, 50.0 * 0.1 - 7.0 * 0.2), ({"num": [30.0], "den": [1.0]}, 3.0)]
)
def test_a_joint_has_its_own_law_over_its_weight(keys, torque):
    law = JointLoop("joint3", **keys)
    law.start(pioneer(arms={"arm": arm_info()}), "arm", RNG)
    q, qd = np.radians([0.0, 30.0, -40.0, 0.0, 10.0, 0.0]), np.zeros(6)
    state = JointState(0.0, q - np.array([0, 0, 0.1, 0, 0, 0]), np.array([0, 0, 0.2, 0, 0, 0]), np.zeros(6))
    goal = JointGoal(positions=tuple(q), velocities=tuple(qd))
    told = SimpleNamespace(dt=0.004, joints={"arm": state})
    found = law.torques(told, Command(joints={"arm": goal}))
    assert found[2] == pytest.approx(PUMA.gravload(q)[2] + torque)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: JointLoop("j"), "give num and den, or gain"),
        (lambda: JointLoop("j", num=[1]), "give num and den, or gain"),
        (lambda: JointLoop("j", num=[1], den=[1], gain=[1, 2]), "give num and den, or gain"),
        (lambda: JointLoop("j", gain=[1]), "give two numbers"),
        (lambda: MechanismLoop(), "give num and den, or gain"),
        (lambda: MechanismLoop(den=[1]), "give num and den, or gain"),
        (lambda: MechanismLoop(num=[1], den=[1], gain={"a": [1, 2]}), "give num and den, or gain"),
        (lambda: MechanismLoop(gain={"a": [1]}), "gain of 'a' is"),
        (lambda: MechanismLoop(gain={"a": [1, math.nan]}), "gain of 'a' is"),
        (lambda: SpeedLoop(num=[1], den=[1], reference={"step": {"to": 1}}, of="left"), "of is 'left'"),
        (
            lambda: JointLoop("knee", gain=[1, 2]).start(pioneer(arms={"arm": arm_info()}), "arm", RNG),
            "no joint 'knee'",
        ),
    ],
)
def test_laws_that_are_not_whole_are_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_a_mechanism_is_fed_back_about_its_points():
    law = MechanismLoop(gain={"a": [2.0, 3.0], "b": [5.0, 7.0]}, about_deg={"b": 90.0})
    law.start(pioneer(), "a", RNG)
    states = {
        "a": JointState(0.0, np.array([0.4]), np.array([0.1]), np.zeros(1)),
        "b": JointState(0.0, np.array([1.0]), np.array([-0.2]), np.zeros(1)),
    }
    goal = Command(joints={"a": JointGoal(positions=(0.5,), velocities=(0.3,))})
    (effort,) = law.torques(SimpleNamespace(joints=states, dt=0.01), goal)
    assert effort == pytest.approx(-(2 * (0.4 - 0.5) + 3 * (0.1 - 0.3) + 5 * (1.0 - math.pi / 2) + 7 * -0.2))
    held = MechanismLoop(gain={"a": [2.0, 3.0]}, about={"a": 0.1})
    held.start(pioneer(), "a", RNG)
    assert held.torques(SimpleNamespace(joints=states, dt=0.01), goal) == [pytest.approx(-(2 * 0.3 + 3 * 0.1))]
    lost = MechanismLoop(gain={"c": [1.0, 1.0]})
    lost.start(pioneer(), "a", RNG)
    with pytest.raises(ValueError, match="no joint 'c' in this mechanism; there are a, b"):
        lost.torques(SimpleNamespace(joints=states, dt=0.01), goal)
    series = MechanismLoop(num=[4.0], den=[2.0])
    series.start(pioneer(), "a", RNG)
    assert series.torques(SimpleNamespace(joints=states, dt=0.01), goal) == [pytest.approx(2.0 * 0.1)]


@pytest.mark.parametrize(
    ("of", "reference", "expected"),
    [
        ("forward", {"step": {"to": 0.5}}, (3 * (0.5 - 0.2), 0.0)),
        ("turn", {"step": {"to_deg": 90}}, (0.0, 3 * (math.pi / 2 - 0.4))),
    ],
)
def test_a_speed_loop_acts_on_the_error_of_the_last_tick(of, reference, expected):
    law = SpeedLoop(num=[3.0], den=[1.0], reference=reference, of=of)
    law.start(pioneer(), None, RNG)
    law.command(Observation(7.0, 0.1, Odometry(0.0, 0.0, 0.0, Q)), Estimate(Pose(0, 0, 0), Q))
    command = law.command(Observation(9.0, 0.1, Odometry(0.02, 0.0, 0.04, Q)), Estimate(Pose(0, 0, 0), Q))
    assert (command.forward, command.turn) == pytest.approx(expected)


def test_a_roadmap_goes_around_what_is_in_the_way():
    def is_clear(a, b):
        places = a + np.linspace(0, 1, 30)[:, None] * (b - a)
        return not (np.abs(places - [2.0, 2.0]) < 0.8).all(axis=1).any()

    roads = Roadmap(is_clear, lower=np.zeros(2), upper=np.full(2, 4.0), rng=np.random.default_rng(0), places=150)
    path = roads.path(np.array([0.5, 2.0]), np.array([3.5, 2.0]))
    np.testing.assert_array_equal(path[[0, -1]], [[0.5, 2.0], [3.5, 2.0]])
    assert all(is_clear(a, b) for a, b in itertools.pairwise(path))
    length = np.hypot(*np.diff(path, axis=0).T).sum()
    assert 2 * math.hypot(0.7, 0.8) + 1.6 - 0.01 < length < 4.3
    straight = roads.path(np.array([0.5, 0.5]), np.array([3.5, 0.5]))
    assert len(straight) == 2
    assert roads.path(np.array([0.5, 2.0]), np.array([2.0, 2.0])) is None
    nowhere = Roadmap(lambda a, b: False, lower=np.zeros(2), upper=np.ones(2), rng=RNG, places=1)
    assert nowhere.path(np.zeros(2), np.ones(2)) is None


def test_what_stands_in_the_way_and_not_in_the_map_is_driven_around():
    walls = np.array([[[0, 0], [6, 0]], [[6, 0], [6, 4]], [[6, 4], [0, 4]], [[0, 4], [0, 0]]], dtype=float)
    goal, pose = GoToGoal([5.0, 2.0]), Pose(1.0, 2.0, 0.0)
    goal.start(pioneer(prior=pose), WorldMap(walls, {}), RNG)
    seen = Observation(0.0, 0.04, Odometry(0.0, 0.0, 0.0, Q))
    goal.command(seen, Estimate(pose, Q))  # The plan takes the time of the first tick.
    command = goal.command(replace(seen, time=0.2), Estimate(pose, Q))
    (path,) = goal.show()
    assert command.forward > 0.0
    assert np.abs(path.points[:, 1] - 2.0).max() < 0.15
    ring = np.full(len(seen.proximity), np.inf)
    ring[[0, 1, -1]] = 0.8
    blocked = Observation(3.0, 0.04, Odometry(0.0, 0.0, 0.0, Q), proximity=ring)
    goal.command(blocked, Estimate(pose, Q))
    goal.command(replace(blocked, time=3.2), Estimate(pose, Q))
    (around,) = goal.show()
    assert np.abs(around.points[:, 1] - 2.0).max() > 0.3
    assert goal.command(seen, Estimate(Pose(5.05, 2.0, 0.0), Q)) == Command()
    assert goal.show() == ()


@pytest.mark.parametrize("law", [PdGravity, ComputedTorque])
def test_an_arm_is_pulled_to_its_goal_and_braked_to_its_speed(law):
    control, info = law(frequency=20.0), arm_info()
    control.start(pioneer(arms={"arm": info}), "arm", RNG)
    q, qd = np.radians([10.0, 30.0, -40.0, 5.0, 10.0, 20.0]), np.array([0.3, -0.2, 0.1, 0.0, 0.2, -0.1])
    goal = Command(joints={"arm": JointGoal(positions=tuple(q), velocities=tuple(qd))})

    def torques(at, rate):
        state = JointState(0.0, np.array(at), np.array(rate), np.zeros(6))
        return np.array(control.torques(SimpleNamespace(dt=0.004, joints={"arm": state}), goal))

    there = torques(q, qd)
    slow, behind = torques(q, qd - 0.1) - there, torques(q - 0.01, qd) - there
    if law is PdGravity:
        np.testing.assert_allclose(there, PUMA.gravload(q), atol=1e-9)
        assert (slow > 0.0).all()
        # Critically damped: Kd = 2 Kp / w.
        pulled = behind - (PUMA.gravload(q - 0.01) - PUMA.gravload(q))
        np.testing.assert_allclose(slow / 0.1, 2.0 / 20.0 * pulled / 0.01, rtol=1e-6)
    else:
        still = torques(q, qd) - PUMA.rne_nofriction(q, qd, np.zeros(6))
        ahead = torques(q, qd - 0.1) - still - PUMA.rne_nofriction(q, qd - 0.1, np.zeros(6))
        M = np.array([PUMA.rne_nofriction(q, np.zeros(6), each) - PUMA.gravload(q) for each in np.eye(6)]).T
        np.testing.assert_allclose(ahead, M @ np.full(6, 2.0 * 20.0 * 0.1), rtol=1e-6, atol=1e-9)


def test_signals_begin_with_the_module_not_with_the_clock():
    module = Signal(forward={"ramp": {"slope": 0.5}}, turn={"step": {"to_deg": 90, "at": 1.0}})
    module.start(pioneer(), None, np.random.default_rng(0))
    told = [
        module.command(Observation(time, 0.04, Odometry(0.0, 0.0, 0.0, Q)), Estimate(Pose(0, 0, 0), Q))
        for time in (5.0, 5.5, 7.0)
    ]
    assert [each.forward for each in told] == pytest.approx([0.0, 0.25, 1.0])
    assert [each.turn for each in told] == pytest.approx([0.0, 0.0, math.pi / 2])


def test_a_sensor_that_is_mounted_turned_tells_the_same_pitch():
    upright, turned = Lean(balancer()), balancer()
    mounted = turned.sensors["imu"].robot_from_sensor.copy()
    mounted[:3, :3] = [[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]
    other = Lean(replace(turned, sensors={"imu": replace(turned.sensors["imu"], robot_from_sensor=mounted)}))
    for k in range(200):
        force, turn = np.array([0.3 * k / 200, 0.1, 9.8]), np.array([0.05, 0.2, -0.1])
        upright.add(ImuReading(0.004 * k, force, turn), 0.001 * k)
        other.add(ImuReading(0.004 * k, mounted[:3, :3].T @ force, mounted[:3, :3].T @ turn), 0.001 * k)
    assert other.pitch == pytest.approx(upright.pitch)
    assert other.rate == pytest.approx(upright.rate)
    assert other.about(ImuReading(0.0, np.zeros(3), mounted[:3, :3].T @ turn)) == pytest.approx(0.2)


def test_motion_across_the_seam_of_headings_is_between_both_ends():
    recent = RecentMotion()
    step = Odometry(0.1, 0.0, 0.5, Q)
    for k in range(20):
        recent.move(step, 0.1 * (k + 1))
    for time in (0.75, 1.05, 1.33, 1.87):
        ahead, P = recent.since(time)
        left = 2.0 - time
        assert wrap_angle(float(ahead[2]) - 5.0 * left) == pytest.approx(0.0, abs=1e-9)
        assert np.trace(P) > 0.0
    now = Sighting(2.0, "a", 3.0, 0.2, R)
    assert recent.to_now(now) is now
    carried = recent.to_now(replace(now, stamp=1.9))
    place = 3.0 * np.array([math.cos(0.2), math.sin(0.2)])
    c, s = math.cos(0.5), math.sin(0.5)
    # A step turns on an arc or at its end; to within its length both see the same.
    moved = np.array([[c, s], [-s, c]]) @ (place - [0.1, 0.0])
    assert carried.range == pytest.approx(np.hypot(*moved), abs=0.03)
    assert carried.bearing == pytest.approx(math.atan2(moved[1], moved[0]), abs=0.03)
