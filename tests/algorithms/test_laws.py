"""What navigators, controllers and small estimators give for one observation, by closed forms; no simulation."""

import math
from dataclasses import replace

import numpy as np
import pytest

from mjsim.algorithms.arm_control import Adaptive, ComputedTorque, PdGravity, within_limits
from mjsim.algorithms.cooperative_slam import belief_of, map_from, map_of, report_of
from mjsim.algorithms.crab import Crab
from mjsim.algorithms.estimation.ekf_models import bicycle_motion
from mjsim.algorithms.explore import Explore
from mjsim.algorithms.linear_control import JointLoop, StateFeedback, TransferLaw
from mjsim.algorithms.occupancy import OccupancyGrid, shown_grid
from mjsim.algorithms.path_tracking import PathTracking
from mjsim.algorithms.paths.controllers import Pid
from mjsim.algorithms.triangulation import Triangulation
from mjsim.algorithms.wall_follow import WallFollow
from mjsim.algorithms.wander import Wander
from mjsim.geometry import Pose
from mjsim.interface import (
    ArmInfo,
    BeaconInfo,
    Command,
    Estimate,
    FastReading,
    JointGoal,
    JointState,
    Observation,
    Odometry,
    RobotInfo,
    Sighting,
)
from mjsim.mechanics import Arm
from tests.mechanics.arms import UP6_ROWS

ROBOT = RobotInfo(
    name="r",
    drive="omni3",
    max_speed=0.7,
    max_turn=1.5,
    max_acceleration=0.5,
    max_turn_acceleration=3.0,
    max_left=0.7,
    wheels=("a", "b"),
    wheel_radius=0.1,
    track=0.4,
    radius=0.2,
    dt=0.04,
    prior=Pose(0.0, 0.0, 0.0),
    prior_covariance=np.diag([0.01, 0.01, 0.001]),
)
NONE = Odometry(0.0, 0.0, 0.0, np.zeros((3, 3)))
RNG = np.random.default_rng(0)


def at(x=0.0, y=0.0, heading=0.0):
    return Estimate(Pose(x, y, heading), np.zeros((3, 3)))


def seen(ring=None, *, time=0.0, moved=NONE, **more):
    return Observation(time, 0.04, moved, proximity=np.full(16, 5.0) if ring is None else ring, **more)


def started(navigator, robot=ROBOT, map=None):
    navigator.start(robot, map, np.random.default_rng(1))
    return navigator


def test_a_crab_goes_straight_at_its_point_whatever_its_heading_and_holds_that():
    crab = started(Crab([[3.0, 4.0]], speed=0.4), replace(ROBOT, prior=Pose(0.0, 0.0, 0.3)))
    for heading in (0.3, 1.0, -2.0):
        told = crab.command(seen(), at(0.0, 0.0, heading))
        world = complex(told.forward, told.left) * np.exp(1j * heading)
        assert world == pytest.approx(0.4 * (0.6 + 0.8j))
        assert told.turn == pytest.approx(1.5 * (0.3 - heading))
    # Half of the acceleration stops it before the point: v^2 = 2 (a / 2) s.
    assert crab.command(seen(), at(3.0, 3.9, 0.3)).forward == pytest.approx(
        min(math.sqrt(0.5 * 0.1), 2.0 * 0.1 + 0.02) * math.sin(0.3)
    )
    assert crab.command(seen(), at(3.0, 3.96, 0.3)) == Command()


def test_a_crab_needs_points_and_a_robot_that_can_go_sideways():
    for points in ([], [1.0, 2.0], [[1.0, 2.0, 3.0]]):
        with pytest.raises(ValueError, match=r"give at least one \[x, y\]"):
            Crab(points)
    with pytest.raises(ValueError, match="cannot move sideways; use Waypoints"):
        started(Crab([[1.0, 2.0]]), replace(ROBOT, max_left=0.0))


def test_wandering_goes_ahead_and_turns_away_from_the_nearer_side_by_what_it_drew():
    wander = started(Wander(speed=0.4, distance=0.5))
    assert wander.command(seen(), at()) == Command(forward=0.4)
    assert started(Wander(speed=2.0)).command(seen(), at()) == Command(forward=0.7)
    for near, side in ((3, -1.0), (12, 1.0)):
        wander = started(Wander())
        ring = np.full(16, 5.0)
        ring[0], ring[near] = 0.45, 0.6
        first = wander.command(seen(ring), at())
        assert first.forward == 0.0
        assert first.turn == pytest.approx(side * 0.9), "0.6 of its largest turn rate"
        drawn, turned = abs(wander._left_to_turn), 0.0
        assert math.pi / 4 <= drawn <= 5 * math.pi / 6
        while (told := wander.command(seen(moved=replace(NONE, turn=side * 0.03)), at())).forward == 0.0:
            turned += 0.03
            assert told.turn * side > 0.0
        assert turned + 0.03 == pytest.approx(drawn - 0.05, abs=0.03)
    assert started(Wander()).command(seen(bump=(0.1,)), at()).forward == 0.0
    for keys in ({"speed": 0.0}, {"distance": -1.0}):
        with pytest.raises(ValueError, match="both must be above 0"):
            Wander(**keys)


def wall_beside(distance, direction):
    """Return the ring's readings of a straight wall on the left, a distance from the origin, rising by a direction."""
    angles = np.arange(16) * math.pi / 8
    sines = np.sin(angles - direction)
    ways = np.where(sines > 0.05, distance / np.where(sines > 0.05, sines, 1.0), np.inf)
    return ways - ROBOT.radius


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_follower_steers_towards_its_distance_from_a_wall_and_along_it(side):
    def turn(distance, direction):
        follower = started(WallFollow(side=side, distance=0.4, speed=0.35))
        ring = wall_beside(distance, direction)
        told = follower.command(seen(ring if side == "left" else np.roll(ring[::-1], 1)), at())
        assert told.forward == pytest.approx(0.35)
        return told.turn if side == "left" else -told.turn

    gains = started(WallFollow())._gains
    assert turn(0.6, 0.0) == pytest.approx(0.0, abs=1e-9)
    assert turn(0.65, 0.0) == pytest.approx(0.05 * gains[0])
    assert turn(0.55, 0.0) == pytest.approx(-0.05 * gains[0])
    assert turn(0.6, 0.1) == pytest.approx(0.1 * gains[1])


def test_a_follower_turns_away_from_a_wall_ahead_and_around_an_outer_corner():
    follower = started(WallFollow(side="left", distance=0.4, speed=0.35))
    assert follower.command(seen(), at()) == Command(forward=0.8 * 0.35), "no wall yet"
    ring = np.full(16, 5.0)
    ring[15] = 0.3
    told = follower.command(seen(ring), at())
    assert told.turn == pytest.approx(-0.7 * 1.5)
    assert told.forward == pytest.approx(0.0)
    ring[15] = 0.48
    assert follower.command(seen(ring), at()).forward == pytest.approx((0.38 / 0.5 - 0.5) * 0.35)
    around = follower.command(seen(), at())
    assert around.turn == pytest.approx(around.forward / (0.4 + ROBOT.radius)), "on a circle at its distance"


def test_a_follower_has_a_side_a_distance_and_a_speed():
    with pytest.raises(ValueError, match="side is 'up'; it must be 'left' or 'right'"):
        WallFollow(side="up")
    for keys in ({"speed": 0.0}, {"distance": 0.0}):
        with pytest.raises(ValueError, match="both must be above 0"):
            WallFollow(**keys)


@pytest.mark.parametrize("controller", ["lqr", "linearisation"])
def test_tracking_turns_first_then_steers_back_to_its_curve_and_stops_at_its_end(controller):
    track = started(PathTracking([[2.0, 0.0], [4.0, 0.0]], controller=controller, speed=0.5))
    away = track.command(seen(), at(0.0, 0.0, 1.0))
    assert away.forward == 0.0
    assert away.turn == pytest.approx(-0.5 * 1.5)
    along = track.command(seen(), at(0.02, 0.0, 0.0))
    assert along.forward > 0.0
    assert along.turn == pytest.approx(0.0, abs=1e-6)
    assert track.command(seen(), at(0.5, 0.1, 0.0)).turn < -0.01, "left of the curve it turns right"
    assert track.command(seen(), at(1.0, -0.1, 0.0)).turn > 0.01
    assert track.command(seen(), at(2.0, 0.0, 0.0)).forward == pytest.approx(0.5, abs=0.02)
    for x in (2.9, 3.8):
        track.command(seen(), at(x, 0.0, 0.0))
    assert track.command(seen(), at(3.99, 0.0, 0.0)) == Command()
    with pytest.raises(ValueError, match="it must be 'lqr' or 'linearisation'"):
        PathTracking([[1.0, 0.0]], controller="pid")


def test_three_bearings_fix_a_pose_and_less_certain_ones_are_ignored():
    truth = Pose(0.3, -0.2, 0.4)
    places = {"a": (3.0, 0.0), "b": (0.0, 3.0), "c": (-2.0, -2.0), "d": (2.0, -3.0)}

    def look(names, deviation):
        for name in names:
            ahead, left = truth.inverse().transform(np.array(places[name])).tolist()
            P = np.diag([0.01, deviation**2])
            yield Sighting(0.0, name, math.hypot(ahead, left), math.atan2(left, ahead), P)

    catalogue = {
        name: BeaconInfo(name=name, picture=None, width=0.1, height=0.1, pose=Pose(*place, 0.0), center=1.0)
        for name, place in places.items()
    }
    finder = Triangulation()
    finder.start(ROBOT, catalogue, RNG)
    two = finder.update(seen(sightings=tuple(look("ab", 0.01))))
    assert two.pose == ROBOT.prior
    np.testing.assert_allclose(two.covariance, ROBOT.prior_covariance)
    found = finder.update(seen(sightings=tuple(look("abcd", 0.01))))
    np.testing.assert_allclose(found.pose.as_array(), truth.as_array(), atol=1e-6)
    assert np.linalg.det(found.covariance) < np.linalg.det(ROBOT.prior_covariance)
    moved = Odometry(0.5, 0.0, 0.2, np.diag([1e-6, 1e-6, 1e-6]))
    poor = finder.update(seen(moved=moved, sightings=tuple(look("abcd", 1.0))))
    np.testing.assert_allclose(poor.pose.as_array(), (truth @ Pose(0.5, 0.0, 0.2)).as_array(), atol=1e-6)
    with pytest.raises(ValueError, match="map"):
        Triangulation().start(ROBOT, {"a": replace(catalogue["a"], pose=None)}, RNG)


def test_the_motion_of_a_bicycle_and_its_derivatives_are_those_of_its_front_wheel():
    move, step = bicycle_motion(2.5, 0.1), 1e-6
    pose, control = np.array([1.0, 2.0, 0.4]), np.array([3.0, -0.2])
    after, F, G = move(pose, control)
    # The front wheel rolls along its own direction; the rear axle has no speed sideways.
    np.testing.assert_allclose(
        after - pose, 0.3 * np.array([math.cos(0.2), math.sin(0.2), math.sin(-0.2) / 2.5]), atol=1e-12
    )
    for slope, at_, of in ((F, pose, lambda p: move(p, control)[0]), (G, control, lambda c: move(pose, c)[0])):
        numeric = [(of(at_ + d) - of(at_ - d)) / (2 * step) for d in np.eye(len(at_)) * step]
        np.testing.assert_allclose(slope, np.stack(numeric, axis=-1), atol=1e-8)


ARM = Arm.from_dh(
    [{**row, "mass": 2.0 + k, "center": [0.05, 0.02, 0.03], "torque": 1e4} for k, row in enumerate(UP6_ROWS)], unit="mm"
)
JOINTS = tuple(f"joint{k}" for k in range(1, 7))
INFO = ArmInfo(
    joints=JOINTS,
    lower=np.full(6, -3.0),
    upper=np.full(6, 3.0),
    max_velocity=np.full(6, 2.0),
    max_torque=np.full(6, 1e4),
    model=ARM,
)
JOINTED = replace(ROBOT, arms={"arm": INFO})
Q, QD = np.array([0.3, -0.4, 0.5, 0.2, -0.6, 0.1]), np.array([0.2, 0.1, -0.3, 0.4, 0.0, -0.2])
GOAL, RATE, FASTER = Q + 0.01, QD - 0.05, np.array([0.5, -0.5, 0.2, 0.0, 0.1, 0.3])
W = 20.0


def asked(controller, *, goal=None, torques=None):
    controller.start(JOINTED, "arm", RNG)
    state = JointState(0.0, Q, QD, np.zeros(6))
    wheels = JointState(0.0, np.zeros(0), np.zeros(0), np.zeros(0))
    goal = goal or JointGoal(
        positions=tuple(GOAL), velocities=tuple(RATE), accelerations=tuple(FASTER), torques=torques
    )
    return np.array(controller.torques(FastReading(0.0, 0.004, {"arm": state}, wheels), Command(joints={"arm": goal})))


def test_computed_torque_makes_each_error_a_damped_oscillator_of_its_own():
    told = asked(ComputedTorque(frequency=W))
    wanted = FASTER + 2.0 * W * (RATE - QD) + W**2 * (GOAL - Q)
    nonlinear = ARM.rne_nofriction(Q, QD, np.zeros(6))
    np.testing.assert_allclose(told, ARM.inertia(Q) @ wanted + nonlinear + ARM.friction(RATE), rtol=1e-9)
    extra = asked(ComputedTorque(frequency=W), torques=(1.0, 2.0, 3.0, 4.0, 5.0, 6.0))
    np.testing.assert_allclose(extra - told, np.arange(1.0, 7.0))
    still = asked(ComputedTorque(frequency=W), goal=JointGoal(positions=tuple(GOAL)))
    wanted = 2.0 * W * -QD + W**2 * (GOAL - Q)
    np.testing.assert_allclose(still, ARM.inertia(Q) @ wanted + nonlinear, rtol=1e-9)


def test_adaptive_control_with_the_true_masses_is_computed_torque():
    told = asked(Adaptive(frequency=W))
    e, rate = GOAL - Q, RATE - QD
    reference, faster = RATE + W * e, FASTER + W * rate
    s = reference - QD
    # Y(q, qd, v, v') a is M v' + C(q, qd) v + g; C is bilinear in the two rates.
    coriolis = ARM.rne_nofriction(Q, QD + reference, np.zeros(6)) - ARM.rne_nofriction(Q, QD, np.zeros(6))
    coriolis = 0.5 * (coriolis - ARM.rne_nofriction(Q, reference, np.zeros(6)) + ARM.gravload(Q))
    wanted = ARM.inertia(Q) @ faster + coriolis + ARM.gravload(Q) + W * ARM.inertia(Q) @ s + ARM.friction(RATE)
    # The first step of adaptation is small beside that.
    np.testing.assert_allclose(told, wanted, rtol=0.02, atol=0.02 * np.abs(wanted).max())


@pytest.mark.parametrize("make", [ComputedTorque, PdGravity, Adaptive])
def test_gains_of_an_arm_are_above_zero_and_torques_within_its_motors(make):
    for keys in ({"frequency": 0.0}, {"mass_scale": 0.0}):
        with pytest.raises(ValueError, match=r"is 0\.0; it must be above 0"):
            make(**keys)
    with pytest.raises(ValueError, match="adaptation is -1"):
        Adaptive(adaptation=-1.0)
    weak = replace(INFO, max_torque=np.full(6, 2.0))
    np.testing.assert_array_equal(within_limits(np.array([-9.0, 0, 1.5, 2.5, 2, -2]), weak), [-2.0, 0, 1.5, 2, 2, -2])


@pytest.mark.parametrize("joint", [1, 3])
def test_a_joint_has_its_own_law_and_the_others_stay_with_theirs(joint):
    others = asked(PdGravity(frequency=W))
    k, held = joint - 1, ARM.gravload(GOAL)[joint - 1]
    told = asked(JointLoop(f"joint{joint}", gain=[50.0, 7.0], frequency=W))
    assert told[k] == pytest.approx(held + 50.0 * (GOAL - Q)[k] + 7.0 * (RATE - QD)[k])
    np.testing.assert_allclose(np.delete(told, k), np.delete(others, k))
    told = asked(JointLoop(f"joint{joint}", num=[3.0, 50.0], den=[0.01, 1.0], frequency=W))
    assert told[k] == pytest.approx(held + TransferLaw([3.0, 50.0], [0.01, 1.0]).output(float((GOAL - Q)[k]), 0.004))


def test_laws_that_are_half_given_are_refused():
    for keys in ({}, {"num": [1.0]}, {"den": [1.0]}, {"num": [1.0], "den": [1.0], "gain": [1.0, 1.0]}):
        with pytest.raises(ValueError, match="give num and den, or gain"):
            JointLoop("joint1", **keys)
    with pytest.raises(ValueError, match="give two numbers"):
        JointLoop("joint1", gain=[1.0])
    with pytest.raises(ValueError, match="has no joint 'joint9'; its joints are joint1, joint2"):
        asked(JointLoop("joint9", gain=[1.0, 1.0]))
    assert StateFeedback([1.0, 2.0, 3.0, 4.0]).design(None, wheel_radius=0.1, dt=0.1) == (1.0, 2.0, 3.0, 4.0)
    for gain in ([1.0], [1.0, 2.0, 3.0, math.inf]):
        with pytest.raises(ValueError, match="give four finite numbers"):
            StateFeedback(gain)


def test_a_pid_that_is_reset_begins_anew():
    pid = Pid(2.0, 0.5, 0.1, filter_time=0.1)
    first = [pid(error, 0.1) for error in (1.0, 0.5, -0.2)]
    pid.reset()
    assert [pid(error, 0.1) for error in (1.0, 0.5, -0.2)] == first


def own_map():
    root = RNG.normal(size=(7, 7))
    P = root @ root.T
    places = {"a": np.array([1.0, 2.0]), "b": np.array([3.0, -1.0])}
    landmarks = {
        name: (place, P[3 + 2 * k : 5 + 2 * k, 3 + 2 * k : 5 + 2 * k]) for k, (name, place) in enumerate(places.items())
    }
    return Estimate(Pose(0.5, 0.6, 0.7), P[:3, :3], landmarks, (("a", np.zeros(2), np.eye(2)),), P)


def test_a_report_holds_the_map_without_the_pose_and_a_map_becomes_the_belief_again():
    own = own_map()
    told = map_from(report_of(own))
    assert told.names == ("a", "b")
    np.testing.assert_array_equal(told.mean, [1.0, 2.0, 3.0, -1.0])
    np.testing.assert_allclose(told.covariance, own.joint_covariance[3:, 3:])
    whole = map_of(own)
    np.testing.assert_array_equal(whole.mean, [0.5, 0.6, 0.7, 1.0, 2.0, 3.0, -1.0])
    again = belief_of(whole, own, report="said")
    np.testing.assert_allclose(again.pose.as_array(), own.pose.as_array())
    assert again.report == "said"
    assert again.innovations == own.innovations
    np.testing.assert_array_equal(again.covariance, own.covariance)
    for name, (place, P) in own.landmarks.items():
        np.testing.assert_array_equal(again.landmarks[name][0], place)
        np.testing.assert_array_equal(again.landmarks[name][1], P)


def test_the_known_part_of_a_grid_is_shown_as_probabilities_where_it_lies():
    grid = OccupancyGrid(cell=0.5)
    assert np.isnan(shown_grid(grid).cells).all()
    grid.lower, grid.log_odds = np.array([-1.0, 2.0]), np.zeros((5, 6))
    grid.log_odds[1, 2], grid.log_odds[3, 4] = math.log(3.0), -math.log(4.0)
    shown = shown_grid(grid)
    np.testing.assert_allclose(shown.cells, [[0.75, np.nan, np.nan], [np.nan] * 3, [np.nan, np.nan, 0.2]])
    assert shown.origin == Pose(0.0, 2.5, 0.0)
    assert shown.resolution == 0.5


def test_frontiers_are_free_cells_beside_unknown_ones_and_short_ones_are_left_out():
    explorer = Explore(cell=0.25, smallest=0.5)
    known = np.zeros((8, 10))
    known[2:6, 2:8], known[2, 2:8], known[5, 2:8], known[2:6, 2] = -1.0, 1.0, 1.0, 1.0
    explorer.grid.lower, explorer.grid.log_odds = np.zeros(2), known
    (frontier,) = explorer.frontiers()
    np.testing.assert_array_equal(frontier, [[3, 7], [4, 7]])
    explorer._smallest = 0.75
    assert explorer.frontiers() == []
