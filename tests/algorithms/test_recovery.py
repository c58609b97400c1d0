"""EKF-SLAM on data that is not as its data sheets say: late looks, odometry that is off, robots carried away."""

import math

import numpy as np
import pytest

import mjsim.algorithms
from mjsim.algorithms.ekf_slam.ekf_slam import EkfSlam
from mjsim.algorithms.estimation.ekf_models import range_bearing
from mjsim.algorithms.estimation.recent_motion import RecentMotion
from mjsim.algorithms.estimation.relocation import Relocation, pose_from_sightings
from mjsim.bench import disturbed
from mjsim.bench.disturbed import DISTURBED
from mjsim.geometry import Array, Pose, wrap_angle
from mjsim.interface import Observation, Odometry, Sighting
from tests.robots import pioneer

R = np.diag([0.05, np.radians(1.0)]) ** 2
HUNG = {
    f"r{k}": place for k, place in enumerate([(6.0, 1.0), (5.0, 5.0), (0.0, 6.0), (-4.0, 3.0), (-3.0, -4.0), (3, -4)])
}
DT = 0.1


def looks_from(pose: Array, time: float, rng: np.random.Generator | None = None) -> list[Sighting]:
    """Return what a robot sees of all landmarks, with noise if there is a source of it."""
    Z, _, _ = range_bearing(pose, np.array(list(HUNG.values())))
    if rng is not None:
        Z = Z + rng.normal(0.0, np.sqrt(np.diag(R)), Z.shape)
    return [Sighting(time, name, float(r), float(b), R) for name, (r, b) in zip(HUNG, Z, strict=True)]


@pytest.mark.parametrize("late", [0.03, 0.1, 0.25])
def test_a_delayed_look_is_moved_to_the_current_pose(late):
    step, motion = Pose(0.05, 0.0, 0.08), RecentMotion()
    poses = [Pose(0.4, -0.2, 0.3)]
    for tick in range(1, 8):
        poses.append(poses[-1] @ step)
        motion.move(Odometry(step.x, step.y, step.heading, 1e-6 * np.eye(3)), DT * tick)
    ticks = late / DT
    # Between two ticks the robot was on the line between them.
    before, after = poses[-2 - int(ticks)], poses[-1 - int(ticks)]
    share = 1.0 - ticks % 1.0
    then = before.as_array() + share * (after.as_array() - before.as_array())
    now = poses[-1].as_array()
    for old, expected in zip(looks_from(then, 0.7 - late), looks_from(now, 0.7), strict=True):
        told = motion.to_now(old)
        assert told.range == pytest.approx(expected.range, abs=1e-9)
        assert wrap_angle(told.bearing - expected.bearing) == pytest.approx(0.0, abs=1e-9)
        assert np.linalg.eigvalsh(told.covariance)[0] > 0.0


def test_a_current_look_is_unchanged():
    motion = RecentMotion()
    motion.move(Odometry(0.05, 0.0, 0.1, 1e-6 * np.eye(3)), 0.1)
    look = looks_from(np.zeros(3), 0.1)[0]
    assert motion.to_now(look) is look


def test_a_pose_is_found_from_looks_of_which_one_is_wrong():
    pose = np.array([1.0, -0.5, 2.0])
    looks = looks_from(pose, 0.0)
    looks[2] = Sighting(0.0, "r2", 1.0, 0.0, R)
    places = {name: np.array(place) for name, place in HUNG.items()}
    found = pose_from_sightings(list(HUNG), looks, places)
    assert found is not None
    np.testing.assert_allclose(found.pose, pose, atol=1e-9)
    assert found.sightings.keys() == HUNG.keys() - {"r2"}
    # One landmark alone tells no pose.
    assert pose_from_sightings(["r1"], looks[1:2], places) is None


def drive(slam: EkfSlam, *, scale: float = 1.0, veer: float = 0.0, carried: Pose | None = None) -> Array:
    """Drive a circle of 1 m for 60 s; odometry tells a way `scale` times as long, `veer` [rad/m] too much to the left.

    Returns the errors of the position and of the heading at each tick, shape (N, 2) [m, rad]. At half of the time
    somebody may carry the robot away.
    """
    rng, step, truth = np.random.default_rng(3), Pose(0.05, 0.0, 0.05), Pose(0.0, 0.0, 0.0)
    slam.start(pioneer(prior=truth), {}, rng)
    noise, errors = np.array([0.02 * np.sqrt(0.05), 0.0, 0.05 * np.sqrt(0.05)]), []
    for tick in range(1, 601):
        truth = truth @ step
        if carried is not None and tick == 300:
            truth = carried
        told = step.as_array() * (scale, 1.0, 1.0) + (0.0, 0.0, veer * step.x) + noise * rng.standard_normal(3)
        moved = Odometry(*told.tolist(), np.diag(noise**2))
        seen = looks_from(truth.as_array(), DT * tick, rng) if tick % 5 == 0 else []
        near = tuple(look for look in seen if abs(look.bearing) < 1.0)
        belief = slam.update(Observation(time=DT * tick, dt=DT, odometry=moved, sightings=near)).pose
        off = wrap_angle(belief.heading - truth.heading)
        errors.append((np.hypot(belief.x - truth.x, belief.y - truth.y), off))
    return np.array(errors)


@pytest.mark.slow
@pytest.mark.parametrize("jacobians", ["first-estimates", "invariant"])
def test_systematic_errors_of_odometry_are_learnt(jacobians):
    slam = EkfSlam(jacobians=jacobians)
    drive(slam, scale=1.08, veer=0.06)
    # What is added to the way that odometry tells: it is 8 % too long, and turns by 0.06 rad too much in 1.08 m. On a
    # circle of 1 m a share of the turn is the same as so much turn for each metre.
    scale, veer, turn, _ = slam.systematic_errors
    assert (scale, veer + turn * 1.06 / 1.08) == pytest.approx((1.0 / 1.08 - 1.0, -0.06 / 1.08), abs=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("jacobians", ["first-estimates", "invariant"])
@pytest.mark.parametrize("ticks", [1.6, 0.0])
def test_a_robot_that_follows_its_commands_late_is_noticed(jacobians, ticks):
    """It turns left and right by turns, `ticks` of 0.1 s later than it is told."""
    rng, truth, slam = np.random.default_rng(4), Pose(0.0, 0.0, 0.0), EkfSlam(jacobians=jacobians)
    slam.start(pioneer(prior=truth), {}, rng)
    noise = np.array([0.02 * np.sqrt(0.05), 0.0, 0.05 * np.sqrt(0.05)])
    told = [np.array([0.05, 0.0, 0.08 if (tick // 20) % 2 else -0.05]) for tick in range(400)]
    whole, part = int(ticks), ticks - int(ticks)
    for tick, command in enumerate(told, start=1):
        newer, older = (told[max(tick - 1 - whole - back, 0)] for back in (0, 1))
        truth = truth @ Pose(*((1.0 - part) * newer + part * older + noise * rng.standard_normal(3)))
        seen = tuple(looks_from(truth.as_array(), DT * tick, rng)) if tick % 5 == 0 else ()
        moved = Odometry(*command.tolist(), np.diag(noise**2))
        slam.update(Observation(time=DT * tick, dt=DT, odometry=moved, sightings=seen))
    assert slam.systematic_errors[3] == pytest.approx(DT * ticks, abs=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("jacobians", ["first-estimates", "invariant"])
def test_a_robot_that_was_carried_away_finds_itself_on_its_map(jacobians):
    errors = drive(EkfSlam(jacobians=jacobians), carried=Pose(-1.5, 1.0, -2.0))
    assert errors[299, 0] > 1.0
    assert errors[400:, 0].mean() < 0.12


@pytest.mark.slow
def test_the_final_path_of_graph_slam_is_corrected_for_systematic_errors():
    pytest.importorskip("gtsam", reason="an extra")
    from mjsim.algorithms.graph_slam import GraphSlam

    slam, trusting = GraphSlam(), GraphSlam(systematic=math.inf)
    online = drive(slam, scale=1.08, veer=0.06)
    believed = drive(trusting, scale=1.08, veer=0.06)
    poses = [pose for _, pose in slam.path()]
    step, truth = Pose(0.05, 0.0, 0.05), Pose(0.0, 0.0, 0.0)
    apart = []
    for pose in poses:
        truth = truth @ step
        apart.append(np.hypot(pose.x - truth.x, pose.y - truth.y))
    # Online too they are learnt; the path has them from its beginning.
    assert np.mean(apart) < np.mean(online[:, 0]) < np.mean(believed[:, 0])
    assert np.mean(apart) < 0.6 * np.mean(believed[:, 0])


@pytest.mark.slow
@pytest.mark.parametrize(("case", "seconds"), [("pushed by 0.87 m in 2.5 s", 85), ("carried away", 100)])
def test_one_or_two_landmarks_at_a_time_find_a_robot_again_that_says_it_is_lost_until_then(case, seconds):
    shares = []

    class Watched(EkfSlam):
        def update(self, seen):
            belief = super().update(seen)
            if seen.time < 60.0:  # nothing disturbs it until then
                shares.append(self._relocation.elsewhere)
            return belief

    run = disturbed.drive({"slam": Watched()}, 0, DISTURBED[case], seconds=seconds)["slam"]
    assert max(shares) == 0.0
    last = run.time > run.time[-1] - 10.0
    assert run.position[last].mean() < 0.2
    assert run.lost.any()
    assert not run.lost[last | (run.time < 60.0)].any()
    # It is also evidence that landmarks are not seen that should be in view.
    assert run.surely_wrong() < 1.5
    if DISTURBED[case].to is not None:  # The first sighting that fails, or does not come, says a little already.
        assert run.nees.mean() < 10.0
    first = run.time[(run.time > 60.0) & (run.seen > 0)][0]
    assert run.nees[run.time > first + 10.0].mean() < 10.0


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["FastSlam", "GraphSlam"])
def test_so_do_particles_and_a_graph(kind):
    if kind == "GraphSlam":
        pytest.importorskip("gtsam", reason="an extra")
    slam = getattr(mjsim.algorithms, kind)()
    run = disturbed.drive({"slam": slam}, 1, DISTURBED["pushed by 2.1 m and turned"], seconds=85.0)["slam"]
    last = run.time > run.time[-1] - 10.0
    assert run.position[last].mean() < 0.1
    assert run.nees[last].mean() < 5.0
    assert run.lost.any()
    assert not run.lost[last | (run.time < 60.0)].any()
    if kind == "GraphSlam":  # Its final path is displaced when the robot was, not when it was found.
        assert run.path < 0.4 * run.position.mean()


@pytest.mark.slow
def test_a_push_that_is_not_noticed_online_is_in_the_final_path():
    pytest.importorskip("gtsam", reason="an extra")
    slam = mjsim.algorithms.GraphSlam()
    run = disturbed.drive({"slam": slam}, 1, DISTURBED["pushed by 0.87 m in 2.5 s"], seconds=85.0)["slam"]
    assert not run.lost.any()
    assert run.path < 0.5 * run.position.mean()


def test_a_landmark_that_left_the_map_says_nothing_about_a_lost_robot():
    relocation, pose = Relocation(), np.array([1.0, 1.0, 0.0])
    for tick in range(12):
        relocation.record("gone", Sighting(0.2 * tick, "gone", 2.0, 0.0, R), 100.0, gate=13.8)
    assert relocation.lost
    # On a circle of 2 m about a landmark that is 4 m away: the mean square of the distance, half along each axis.
    near = relocation.covariance(pose, {"gone": np.array([5.0, 1.0])})
    assert near[0, 0] == near[1, 1] == pytest.approx(0.5 * (4.0**2 + 2.0**2))
    assert relocation.covariance(pose, {})[0, 0] == 100.0
    assert relocation.find(RecentMotion(), 2.4, {}) is None
