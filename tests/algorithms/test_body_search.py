"""Long bodies in GoToGoal: discs that cover them, the search of a path for their shape, and where it leads out."""

import math

import numpy as np
import pytest
from shapely import Point, Polygon
from shapely.affinity import affine_transform

import mjsim
from mjsim.algorithms.go_to_goal.body_discs import CLOSE_EXCESS, BodyDiscs
from mjsim.algorithms.go_to_goal.body_search import BodySearch, moves_of
from mjsim.algorithms.go_to_goal.curve_follower import CurveFollower
from mjsim.algorithms.go_to_goal.go_to_goal import GoToGoal
from mjsim.algorithms.go_to_goal.obstacle_map import ObstacleMap
from mjsim.algorithms.go_to_goal.way_plan import WayPlan
from mjsim.geometry import Pose
from mjsim.interface import RobotInfo

FORKS = np.array([[0.22, -0.27], [0.22, 0.27], [-0.93, 0.27], [-0.99, 0.36], [-1.57, 0.36], [-1.57, -0.36],
                  [-0.99, -0.36], [-0.93, -0.27]])  # fmt: skip


def robot(**keys):
    usual = {
        "name": "r", "drive": "tricycle", "max_speed": 1.0, "max_turn": 1.0, "max_acceleration": 0.5,
        "max_turn_acceleration": 0.4, "wheels": (), "wheel_radius": 0.1, "track": 0.4,
        "radius": float(np.hypot(*FORKS.T).max()), "dt": 0.04, "prior": Pose(0.0, 0.0, 0.0),
        "prior_covariance": np.zeros((3, 3)), "outline": FORKS,
    }  # fmt: skip
    return RobotInfo(**(usual | keys))


def test_discs_of_many_sizes_cover_a_long_outline_and_exceed_it_nowhere_by_more_than_2_cm():
    body, outline = BodyDiscs(robot()), Polygon(FORKS)
    assert body.is_long
    assert body.half_width == pytest.approx(0.36, abs=0.01)
    discs = [Point(centre).buffer(r, 32) for centre, r in zip(body.centres.tolist(), body.radii.tolist(), strict=True)]
    rim = [outline.exterior.interpolate(share, normalized=True) for share in np.linspace(0.0, 1.0, 400)]
    assert max(min(disc.distance(point) for disc in discs) for point in rim) < 0.002
    grown = outline.buffer(CLOSE_EXCESS + 0.002, 32)
    assert all(grown.contains(disc) for disc in discs)


def test_a_body_wider_than_long_that_cannot_drive_sideways_passes_only_where_its_width_does():
    wide = np.array([[0.1, -0.25], [0.1, 0.25], [-0.1, 0.25], [-0.1, -0.25]])
    keys = {"drive": "differential", "outline": wide, "radius": 0.27}
    assert BodyDiscs(robot(**keys)).half_width == 0.25
    assert BodyDiscs(robot(**keys, max_left=0.5)).half_width == pytest.approx(0.1, abs=0.01)


def alley():
    """Return points on the walls of a blind alley that opens to the left, and of a room around it, shape (n, 2) [m]."""
    lines = [((-2.0, -0.6), (0.6, -0.6)), ((0.6, -0.6), (0.6, 0.6)), ((0.6, 0.6), (-2.0, 0.6))]
    return np.concatenate([np.linspace(start, end, 150) for start, end in lines])


def test_a_search_leads_a_long_body_out_of_a_blind_alley_within_its_curvature_and_without_contact():
    info, points, start, goal = robot(), alley(), Pose(0.2, 0.0, 0.0), np.array([2.5, 0.0])
    body = BodyDiscs(info)
    way = WayPlan(np.zeros((0, 2)), None, half_width=body.half_width, gap=0.1, top=1.0, cell=0.05)
    way.lay_out(goal, np.array([[start.x, start.y], [-4.5, 3.0], [-4.5, -3.0]]))
    field = way.to(goal, np.array([start.x, start.y]), 0.0, points=points, stuck=[])
    map = ObstacleMap(np.array([start.x, start.y]), points, cell=0.0125, half=6.5)
    moves = moves_of(info, bend=2.0, fine=1.5)
    search = BodySearch(start, body, map, field, moves=moves, room=0.03, nearer=2.0, fine=1.5)
    for _ in range(400):
        if search.is_over:
            break
        search.advance(600)
    poses, bends, ways = search.found
    assert field.at(poses[-1, :2]) < field.at(poses[0, :2]) - 1.9
    assert ways[0] == -1.0
    assert np.abs(bends).max() <= 2.0
    steps = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    assert steps.max() < 0.035
    assert np.abs(np.diff(poses[:, 2])).max() <= 2.0 * steps.max() + 1e-9
    for x, y, heading in poses.tolist():
        c, s = math.cos(heading), math.sin(heading)
        shape = affine_transform(Polygon(FORKS), [c, -s, s, c, x, y])
        assert min(shape.distance(Point(point)) for point in points[::3].tolist()) > 0.005


def test_a_follower_stands_where_the_curve_bends_otherwise_and_turns_its_wheel_first():
    follower = CurveFollower(robot(), bend=2.0, top=0.4)
    along = 0.02 * np.arange(100)
    poses = np.stack([along, np.zeros(100), np.zeros(100)], axis=-1)
    follower.begin(poses, np.where(along < 1.0, 0.0, 2.0), np.ones(100))
    speeds = [follower.command(Pose(float(x), 0.0, 0.0)).forward for x in along[:49]]
    assert max(speeds) == pytest.approx(0.4)
    assert speeds[-1] < 0.15
    assert abs(follower.command(Pose(1.01, 0.0, 0.0)).forward) <= 0.011


LIDAR = (
    "{lidar: scan, at: [0.7, 0, 0.5], beams: 541, fov_deg: 270, range: [0.05, 10], rate_hz: 25, noise: {range: 0.01}}"
)
TRICYCLE = (
    "drive: {type: tricycle, wheelbase: 0.7, driven: front, max_steer_deg: 70, max_speed: 1.0},"
    " body: {box: [1.1, 0.55, 0.4], at: [0.3, 0]}"
)


@pytest.mark.slow
def test_a_tricycle_that_sees_nothing_behind_it_backs_out_of_a_blind_alley_without_a_touch():
    world = mjsim.parse_world(f"""
mjsim: 1
walls:
  - {{points: [[0, 0], [11, 0], [11, 8], [0, 8]], closed: true}}
  - {{points: [[3.6, 3.5], [6, 3.5], [6, 4.5], [3.6, 4.5]]}}
robots: [{{name: r, {TRICYCLE}, at: [4.95, 4], sensors: [{LIDAR}]}}]
""")
    navigator = GoToGoal([9.5, 4.0])
    with mjsim.Simulation(world, seed=1) as sim:
        for tick in mjsim.ticks(sim, {"r": mjsim.Driver(navigator=navigator)}):
            assert not any(event.kind == "bump" for event in tick.orders["r"].events)
            if navigator.is_done:
                break
            assert tick.time < 60.0
