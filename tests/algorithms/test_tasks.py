"""Tasks worked out without physics: a box is fetched, an unknown room explored, a tool led, a marker measured."""

import math

import cv2
import numpy as np
import pytest

import mjsim
from mjsim.algorithms.beacon_vision.beacon_vision import MarkerBeacons
from mjsim.algorithms.explore import Explore
from mjsim.algorithms.joint_path import ToolPath
from mjsim.algorithms.occupancy import OccupancyGrid, OccupancyMapping, shown_grid
from mjsim.algorithms.pick import PickUp
from mjsim.geometry import Pose
from mjsim.interface import Estimate, Intrinsics, JointState, Observation, Odometry, Scan, SensorInfo, Sighting
from tests.algorithms.test_joint_path import PUMA, followed
from tests.robots import pioneer

DT = 0.1
NO_MOTION = Odometry(0.0, 0.0, 0.0, np.zeros((3, 3)))
FETCHER = """
mjsim: 1
robots:
  - name: fetcher
    preset: pioneer3dx
    at: [1, 1]
    sensors: [{camera: front, at: [-0.08, 0, 0.85], pitch_deg: -15, width: 640, height: 480, fov_deg: 58, rate_hz: 5}]
    arms: [{name: arm, preset: picker, at: [0.12, 0, 0.25], start_deg: [0, -130, 150, -20, 0.07, 0.07]}]
run: {rate_hz: 10, drivers: {}}
"""
BOX = np.array([3.0, 1.6, 0.57])
"""Its centre [m]."""
FACING = math.radians(172.0)
SIZE, WIDTH = (0.08, 0.11, 0.14), 0.1


@pytest.fixture(scope="module")
def fetcher():
    with mjsim.Simulation(mjsim.parse_world(FETCHER)) as sim:
        return sim.robots["fetcher"]


def corners_of(pose, robot):
    """Return the corners of the picture on the box as the camera of a robot sees them; None out of view."""
    n, down = np.array([math.cos(FACING), math.sin(FACING), 0.0]), np.array([0.0, 0.0, -1.0])
    right = np.cross(n, down)
    square = 0.5 * WIDTH * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    points = BOX + 0.5 * SIZE[0] * n + square @ np.array([right, down])
    world_from_robot = np.eye(4)
    c, s = math.cos(pose.heading), math.sin(pose.heading)
    world_from_robot[:2, :2], world_from_robot[:2, 3] = [[c, -s], [s, c]], (pose.x, pose.y)
    sensor = robot.sensors["front"]
    camera = np.linalg.inv(world_from_robot @ sensor.robot_from_sensor)
    x, y, z = camera[:3, :3] @ points.T + camera[:3, 3:]
    if z.min() < 0.1:
        return None
    u, v, w = sensor.intrinsics.matrix() @ np.array([x, y, z])
    pixels = np.column_stack([u / w, v / w])
    inside = (pixels > 0).all() and (pixels[:, 0] < 640).all() and (pixels[:, 1] < 480).all()
    return pixels if inside else None


def fetched(task, robot, *, start=None, seconds=90.0):
    """Do a task with exact poses and sightings; return pose, joints and the command of each tick."""
    task.start(robot, None, np.random.default_rng(0))
    pose, rows = start or Pose(1.0, 1.0, 2.0), []
    q = np.array([*np.radians([0, -130, 150, -20]), 0.07, 0.07])
    for time in np.arange(0.0, seconds, DT).tolist():
        corners = corners_of(pose, robot)
        seen = (
            Sighting(time, "face", 1.0, 0.0, np.eye(2), corners=corners),
            Sighting(time, "other", 1.0, 0.0, np.eye(2), corners=np.eye(4)[:, :2]),
        )
        state = JointState(time, q, np.zeros(6), np.zeros(6))
        told = Observation(time, DT, NO_MOTION, sightings=seen[corners is None :], joints={"arm": state})
        command = task.command(told, Estimate(pose, np.zeros((3, 3))))
        q = np.array(command.joints["arm"].positions)
        pose = pose @ Pose(command.forward * DT, 0.0, command.turn * DT)
        rows.append((pose, q, command))
    return rows


@pytest.fixture(scope="module")
def done(fetcher):
    return fetched(PickUp("face", box=SIZE, width=WIDTH), fetcher)


def tool_of(robot, pose, q):
    """Return where the tool is in the world."""
    tool = robot.arms["arm"].model.fkine(q)
    x, y = pose.transform(tool[None, :2, 3])[0]
    return np.array([x, y, tool[2, 3]]), tool


@pytest.mark.slow
def test_a_box_is_gripped_from_the_front_lifted_and_held(fetcher, done):
    gripped = next(k for k, (_, _, command) in enumerate(done) if command.joints["arm"].torques[-1] < 0)
    pose, q, command = done[gripped]
    place, tool = tool_of(fetcher, pose, q)
    np.testing.assert_allclose(place, BOX, atol=0.003)
    # It is level and points at the box.
    np.testing.assert_allclose(tool[2, :3], [0.0, 0.0, 1.0], atol=0.02)
    assert command.joints["arm"].torques[:4] == (0.0,) * 4
    before = done[gripped - 1][1]
    assert before[-2:] == pytest.approx([0.075, 0.075])
    shut = done[gripped + 10][1]
    assert shut[-2:] == pytest.approx([SIZE[1] / 2] * 2)
    up = done[gripped + 10 + 19]
    place, _ = tool_of(fetcher, up[0], up[1])
    np.testing.assert_allclose(place, BOX + np.array([0.0, 0.0, 0.12]), atol=0.003)
    # It backs off for a second and a half, and holds.
    assert [command.forward for *_, command in done[gripped + 30 : gripped + 45]] == [-0.08] * 15
    assert done[-1][2].forward == 0.0
    assert done[-1][2].joints["arm"].torques[-2:] == (-8.0, -8.0)
    np.testing.assert_array_equal(done[-1][1], up[1])


def test_it_turns_until_it_sees_the_box_then_drives_before_it_in_two_steps(fetcher, done):
    assert done[0][2].turn == 0.7
    first = next(k for k, (pose, *_) in enumerate(done) if corners_of(pose, fetcher) is not None)
    assert all((command.turn, command.forward) == (0.7, 0.0) for *_, command in done[: first + 1])
    n = np.array([math.cos(FACING), math.sin(FACING)])
    # It stands for the time of a look at both places, facing the box.
    still = [k for k, (*_, command) in enumerate(done) if command.forward == command.turn == 0.0]
    stops = [k for k in still if k - 1 not in still]
    for stop, distance in zip(stops[:2], (0.95, 0.72), strict=True):
        pose = done[stop][0]
        assert np.array([pose.x, pose.y]) == pytest.approx(BOX[:2] + distance * n, abs=0.07)
        bearing = math.atan2(BOX[1] - pose.y, BOX[0] - pose.x) - pose.heading
        assert abs(math.remainder(bearing, 2 * math.pi)) < 0.012
        assert all(k in still for k in range(stop, stop + 15))
    near = done[stops[2]][0]
    ahead = near.inverse().transform(BOX[None, :2])[0]
    assert ahead[0] - 0.12 - 0.36 == pytest.approx(0.0, abs=0.012)
    assert max(abs(command.forward) for *_, command in done) <= 0.35
    assert max(abs(command.turn) for *_, command in done) <= 0.71


def test_the_arm_moves_without_jumps(done):
    q = np.array([row[1] for row in done])
    assert np.abs(np.diff(q, axis=0)).max() < 0.35
    rates = np.array([row[2].joints["arm"].velocities for row in done])
    # Rates are those of the positions, halfway between two.
    moving = np.abs(rates).max(axis=1) > 0
    assert moving.sum() > 50
    np.testing.assert_allclose(np.sum(rates * DT, axis=0), q[-1] - q[0], atol=0.05)


def test_what_is_not_seen_from_here_is_looked_for_at_the_places_given(fetcher):
    hidden = Pose(1.0, 1.0, 0.0)
    task = PickUp("none", box=SIZE, width=WIDTH, search=[[1.5, 1.0]], speed=0.3)
    rows = fetched(task, fetcher, start=hidden, seconds=30.0)
    turning = [command.turn for *_, command in rows]
    turns = math.ceil(2 * math.pi / (0.7 * DT))
    assert turning[:turns] == [0.7] * turns
    far = rows[turns + 40][0]
    assert np.hypot(far.x - 1.5, far.y - 1.0) < 0.04
    assert max(command.forward for *_, command in rows) <= 0.3
    assert turning[-1] == 0.7


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"box": (0.0, 1.0, 1.0)}, "box is 0.0; it must be above 0"),
        ({"width": -1.0}, "width is -1.0"),
        ({"force": 0.0}, "force is 0.0"),
        ({"lift": 0.0}, "lift is 0.0"),
        ({"speed": 0.0}, "speed is 0.0"),
    ],
)
def test_sizes_of_a_task_are_above_0(keys, message):
    with pytest.raises(ValueError, match=message):
        PickUp("face", **({"box": SIZE, "width": WIDTH} | keys))


def test_a_task_needs_a_camera_and_an_arm_with_fingers(fetcher):
    for keys, message in (({"camera": "rear"}, "no camera 'rear'"), ({"arm": "leg"}, "no arm 'leg' with two fingers")):
        with pytest.raises(ValueError, match=message):
            PickUp("face", box=SIZE, width=WIDTH, **keys).start(fetcher, None, np.random.default_rng(0))


ROOM = np.array([
    [0, 0, 6, 0], [6, 0, 6, 4], [6, 4, 0, 4], [0, 4, 0, 0], [3, 0, 3, 1.5], [3, 2.7, 3, 4],
], dtype=float)  # fmt: skip
"""Two rooms with a doorway, as ends of walls."""
SCOUT = pioneer(
    dt=DT,
    prior=Pose(1.0, 2.0, 0.0),
    sensors={"scan": SensorInfo(kind="lidar", robot_from_sensor=np.eye(4), rate_hz=10.0)},
)


def scan_from(pose, walls=ROOM, *, beams=360, farthest=10.0):
    """Return the scan of a lidar by the nearest crossing of each beam with a wall."""
    angles = -math.pi + 2 * math.pi / beams * np.arange(beams)
    way = np.column_stack([np.cos(angles + pose.heading), np.sin(angles + pose.heading)])
    start, along = walls[:, :2] - [pose.x, pose.y], walls[:, 2:] - walls[:, :2]
    cross = way[:, 0, None] * along[:, 1] - way[:, 1, None] * along[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (start[:, 0] * along[:, 1] - start[:, 1] * along[:, 0]) / cross
        u = (start[:, 0] * way[:, 1, None] - start[:, 1] * way[:, 0, None]) / cross
    t = np.where((u >= 0) & (u <= 1) & (t > 0), t, math.inf).min(axis=1)
    return Scan(0.0, np.where(t > farthest, math.inf, t), -math.pi, 2 * math.pi / beams, 0.05, farthest)


def looking(time, pose, walls=ROOM):
    return Observation(time, DT, NO_MOTION, scans={"scan": scan_from(pose, walls)})


def test_an_unknown_room_is_entered_by_its_doorway():
    explorer, pose = Explore(cell=0.1), SCOUT.prior
    explorer.start(SCOUT, None, np.random.default_rng(0))
    assert explorer.show() == ()
    # It looks, then plans, then goes.
    for tick in range(3):
        command = explorer.command(looking(DT * tick, pose), Estimate(pose, np.zeros((3, 3))))
    assert not explorer.done
    (path,) = explorer.show()
    end = path.points[-1, :2]
    assert path.points[0, :2] == pytest.approx([1.0, 2.0], abs=0.1)
    assert end[0] > 2.5  # through the doorway, where the next room is not seen
    assert 1.5 < np.interp(3.0, path.points[:, 0], path.points[:, 1]) < 2.7
    assert command.forward > 0.0 or command.turn != 0.0
    explorer.command(looking(3.8, pose), Estimate(pose, np.zeros((3, 3))))
    explorer.command(looking(3.9, pose), Estimate(pose, np.zeros((3, 3))))
    assert explorer.show()[0].points[-1, :2] == pytest.approx(end)  # the frontier is kept
    moved = Pose(1.5, 2.0, 0.0)
    for time in (4.0, 4.2, 4.4):
        explorer.command(looking(time, moved), Estimate(moved, np.zeros((3, 3))))
    assert explorer.show()[0].points[0, :2] == pytest.approx([1.5, 2.0], abs=0.1)


def test_frontiers_lie_where_known_and_unknown_meet():
    explorer = Explore(cell=0.1, smallest=0.5)
    explorer.grid.lower, explorer.grid.log_odds = np.zeros(2), np.zeros((20, 30))
    explorer.grid.log_odds[5:15, 5:20] = -1.0
    explorer.grid.log_odds[5:15, 5] = explorer.grid.log_odds[5, 5:20] = explorer.grid.log_odds[14, 5:20] = 1.0
    (found,) = explorer.frontiers()
    assert sorted(map(tuple, found.tolist())) == [(row, 19) for row in range(6, 14)]
    narrow = Explore(cell=0.1, smallest=0.81)
    narrow.grid.lower, narrow.grid.log_odds = explorer.grid.lower, explorer.grid.log_odds
    assert narrow.frontiers() == []


def test_where_nothing_is_left_to_see_it_stops():
    closed = ROOM[:4]
    explorer, pose = Explore(cell=0.1), Pose(3.0, 2.0, 0.0)
    explorer.start(SCOUT, None, np.random.default_rng(0))
    for k in range(3):
        command = explorer.command(looking(4.0 * k, pose, closed), Estimate(pose, np.zeros((3, 3))))
    assert explorer.done
    assert (command.forward, command.turn) == (0.0, 0.0)
    assert explorer.show() == ()
    with pytest.raises(ValueError, match="no lidar"):
        Explore().start(pioneer(), None, np.random.default_rng(0))


def test_a_grid_has_walls_where_beams_end_and_floor_before():
    grid, pose = OccupancyGrid(cell=0.1, farthest=8.0), Pose(1.03, 2.04, 0.3)
    for _ in range(3):
        grid.add(pose, scan_from(pose, ROOM[:4], beams=720))
    shown = shown_grid(grid)
    assert shown.resolution == 0.1
    x, y = (
        shown.origin.x + 0.1 * (np.arange(shown.cells.shape[1]) + 0.5),
        shown.origin.y + 0.1 * (np.arange(shown.cells.shape[0]) + 0.5),
    )
    inside = np.ix_((y > 0.2) & (y < 3.8), (x > 0.2) & (x < 5.8))
    assert np.nanmax(shown.cells[inside]) < 0.5
    assert np.isfinite(shown.cells[inside]).mean() > 0.95
    row, column = int((2.05 - shown.origin.y) / 0.1), int((6.0 - shown.origin.x) / 0.1)
    assert np.nanmax(shown.cells[row, column - 1 : column + 1]) > 0.5
    distances = grid.distances()
    assert distances.at(np.array([[3.0, 2.0]])) == pytest.approx(2.0, abs=0.15)
    assert grid.distances(unknown_is_wall=True).at(np.array([[1.0, 2.0]])) <= distances.at(np.array([[1.0, 2.0]]))


def test_a_map_is_made_by_odometry():
    mapping = OccupancyMapping(cell=0.1)
    mapping.start(SCOUT, {}, np.random.default_rng(0))
    pose, Q = SCOUT.prior, np.diag([1e-4, 1e-5, 1e-4])
    for k in range(3):
        step = Pose(0.2, 0.0, 0.1)
        pose = pose @ step
        seen = Observation(DT * k, DT, Odometry(0.2, 0.0, 0.1, Q), scans={"scan": scan_from(pose)})
        belief = mapping.update(seen)
    assert belief.pose.as_array() == pytest.approx(pose.as_array(), abs=0.01)
    assert np.diag(belief.covariance)[2] == pytest.approx(3e-4)
    assert 3e-4 < np.trace(belief.covariance[:2, :2]) < 6e-4
    assert mapping.grid.distances().at(np.array([[0.05, 2.0]])) < 0.15


def test_a_tool_follows_a_straight_line_and_turns_evenly():
    start = np.radians([10.0, 40.0, -30.0, 20.0, 50.0, 10.0])
    first = PUMA.fkine(start)
    to = first[:3, 3] + [-0.1, -0.05, -0.05]
    times, q, qd, _ = followed(ToolPath(to.tolist(), seconds=1.0), 1.2, start=start)
    poses = np.array([PUMA.fkine(each) for each in q])
    way = poses[:, :3, 3] - first[:3, 3]
    aim = to - first[:3, 3]
    np.testing.assert_allclose(np.cross(way, aim / np.linalg.norm(aim)), 0.0, atol=2e-4)
    np.testing.assert_allclose(poses[-1][:3, 3], to, atol=2e-4)
    np.testing.assert_allclose(poses[:, :3, :3], np.tile(first[:3, :3], (len(q), 1, 1)), atol=2e-3)
    np.testing.assert_allclose(np.gradient(q, times, axis=0)[2:-6], qd[2:-6], atol=0.05)
    assert not qd[-3:].any()
    turned = [20.0, -30.0, 100.0]
    _, q, _, _ = followed(ToolPath(first[:3, 3].tolist(), seconds=1.5, rpy_deg=turned), 1.6, start=start)
    cy, sy, cp, sp, cr, sr = (f(math.radians(turned[k])) for k in (2, 1, 0) for f in (math.cos, math.sin))
    R = (
        np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
        @ [[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]]
        @ [[1, 0, 0], [0, cr, -sr], [0, sr, cr]]
    )
    last = PUMA.fkine(q[-1])
    np.testing.assert_allclose(last[:3, :3], R, atol=2e-3)
    np.testing.assert_allclose(last[:3, 3], first[:3, 3], atol=1e-3)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"seconds": 0.0}, "seconds is 0.0; it must be above 0"),
        ({"seconds": math.inf}, "seconds is inf"),
        ({"to": [1, 2]}, "to is .* it must be three numbers"),
        ({"to": [1, 2, math.nan]}, "it must be three numbers"),
        ({"rpy_deg": [1]}, "rpy_deg is .* it must be three numbers"),
        ({"wait": -1.0}, "wait is -1.0"),
    ],
)
def test_keys_of_a_tool_path_are_checked(keys, message):
    with pytest.raises(ValueError, match=message):
        ToolPath(**({"to": [0.4, 0.1, 0.3], "seconds": 1.0} | keys))


def test_a_tool_cannot_leave_its_reach():
    with pytest.raises(ValueError, match="the tool cannot follow its path beyond"):
        followed(ToolPath([3.0, 0.0, 0.0], seconds=1.0), 1.0, start=np.radians([10.0, 40.0, -30.0, 20.0, 50.0, 10.0]))


INTRINSICS = Intrinsics(640, 480, 500.0, 500.0, 319.5, 239.5)


def view_of_marker(number, position, *, turn=0.0, width=0.3):
    """Return an RGB picture of a marker of 4x4 modules, with a white margin, at a place before a camera."""
    modules, pixels = 6, 40
    black = cv2.aruco.generateImageMarker(
        cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50), number, modules * pixels
    )
    printed = np.pad(black, pixels, constant_values=255)
    half = 0.5 * width * (modules + 2) / modules
    c, s = math.cos(turn), math.sin(turn)
    square = np.array([[-half, -half], [half, -half], [half, half], [-half, half]])
    places = np.array([[c * x, y, s * x] for x, y in square]) + position
    image = places[:, :2] / places[:, 2:] * 500.0 + [319.5, 239.5]
    size = len(printed) - 0.5
    ends = np.array([[-0.5, -0.5], [size, -0.5], [size, size], [-0.5, size]], dtype=np.float32)
    fine = cv2.getPerspectiveTransform(ends, ((image + 0.5) * 4 - 0.5).astype(np.float32))
    view = np.full((1920, 2560), 140, np.uint8)
    cv2.warpPerspective(printed, fine, (2560, 1920), view, cv2.INTER_LINEAR, cv2.BORDER_TRANSPARENT)
    small = cv2.resize(view, (640, 480), interpolation=cv2.INTER_AREA)
    inner = np.array([[c * x, y, s * x] for x, y in square * modules / (modules + 2)]) + position
    return np.repeat(small[:, :, None], 3, axis=2), inner[:, :2] / inner[:, 2:] * 500.0 + [319.5, 239.5]


@pytest.mark.parametrize(("position", "turn"), [((0.2, -0.1, 1.5), 0.0), ((-0.3, 0.1, 2.0), 0.5)])
def test_a_marker_is_measured_by_its_whole_picture(position, turn):
    image, corners = view_of_marker(9, np.array(position), turn=turn)
    (found,) = MarkerBeacons("4x4_50", 0.3).detect(image, INTRINSICS)
    assert found.name == "9"
    np.testing.assert_allclose(found.position, position, atol=0.01)
    np.testing.assert_allclose(found.corners, corners, atol=0.4)
    assert np.linalg.eigvalsh(found.covariance).min() > 0.0
    (named,) = MarkerBeacons("4x4_50", 0.3, names={9: "door"}).detect(image, INTRINSICS)
    assert named.name == "door"
    assert MarkerBeacons("4x4_50", 0.3, names={8: "door"}).detect(image, INTRINSICS) == []
    (twice,) = MarkerBeacons("4x4_50", 0.6).detect(image, INTRINSICS)
    np.testing.assert_allclose(twice.position, 2 * np.array(position), atol=0.02)
