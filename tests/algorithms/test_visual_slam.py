"""Visual SLAM: cameras that see points, poses from points, depths from motion, places that look alike, and a drive."""

from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from scipy.optimize import least_squares

import mjsim
from mjsim.algorithms import VisualSlam
from mjsim.algorithms.estimation.pose_graph import compose, step_between
from mjsim.algorithms.visual_slam import view_pose
from mjsim.algorithms.visual_slam.picture_points import PicturePoints, inverse_depths, spread_out
from mjsim.algorithms.visual_slam.places_seen import PlacesSeen
from mjsim.algorithms.visual_slam.view_geometry import LandmarkRays, rays_of, seen_from
from mjsim.algorithms.visual_slam.view_map import ViewMap
from mjsim.algorithms.visual_slam.view_pose import Located, locate, locate_anywhere
from mjsim.geometry import Pose
from mjsim.modules import notes_on
from tests.robots import pioneer

CAMERA = np.array([[0.0, 0.0, 1.0, 0.1], [-1.0, 0.0, 0.0, 0.02], [0.0, -1.0, 0.0, 1.1], [0.0, 0.0, 0.0, 1.0]])
"""A camera that looks ahead from a height of 1.1 m."""
EXTENT = np.array([-0.7, -0.5]), np.array([0.7, 0.5])
NOISE = 0.002
NONE = np.zeros(0, dtype=np.intp)


def room(count, *, seed=0):
    """Return points ahead of the origin (n, 3), and a random descriptor of each."""
    rng = np.random.default_rng(seed)
    points = np.stack([rng.uniform(2, 6, count), rng.uniform(-1.5, 1.5, count), rng.uniform(0.2, 2, count)], axis=1)
    return points, rng.integers(0, 2**63, (count, 4), dtype=np.uint64)


def picture_of(points, pose, *, noise=0.0, depth=True, seed=0):
    """Return what the camera sees of points from a pose in the plane: (x / z, y / z, 1 / z), by OpenCV."""
    world_from_robot = np.eye(4)
    world_from_robot[:2, :2], world_from_robot[:2, 3] = Pose(*pose).matrix()[:2, :2], pose[:2]
    camera_from_world = np.linalg.inv(world_from_robot @ CAMERA)
    turned = cv2.Rodrigues(camera_from_world[:3, :3])[0]
    places = cv2.projectPoints(points, turned, camera_from_world[:3, 3], np.eye(3), None)[0][:, 0]
    z = points @ camera_from_world[2, :3] + camera_from_world[2, 3]
    chance = np.random.default_rng(seed).standard_normal((len(points), 3)) * (noise, noise, noise)
    seen = np.concatenate([places, 1.0 / z[:, None]], axis=1) + chance
    if not depth:
        seen[:, 2] = 0.0
    return seen


def features(points, descriptors, pose, *, noise=0.0, depth=True, seed=0):
    seen = picture_of(points, pose, noise=noise, depth=depth, seed=seed)
    deviations = np.full((len(points), 3), NOISE)
    deviations[:, 2] = NOISE if depth else 1e3
    return PicturePoints(seen, deviations, descriptors)


def rays_to(points, *, noise=1e-9):
    """Return points as rays from the camera of a robot at the origin, their depths known."""
    seen = picture_of(points, (0.0, 0.0, 0.0))
    origins, directions = rays_of(seen[:, :2], np.zeros(5), CAMERA)
    return LandmarkRays(origins, directions, seen[:, 2], np.full(len(points), 1e-12), np.full(len(points), noise))


def located(points, rays, descriptors, guess, covariance):
    deviations = np.diag([*np.diag(covariance), 1e-8, 1e-8])
    guess = np.array([*guess, 0.0, 0.0])
    prior = guess, deviations
    return locate(points, rays, descriptors, guess, prior, robot_from_camera=CAMERA, extent=EXTENT)


def test_points_on_rays_are_where_they_were_and_are_seen_where_opencv_projects_them():
    points, _ = room(20)
    np.testing.assert_allclose(rays_to(points).points(), points, atol=1e-9)
    pose = (0.3, -0.2, 0.15)
    z, _, _ = seen_from(rays_to(points), np.array([*pose, 0.0, 0.0]), CAMERA)
    np.testing.assert_allclose(z, picture_of(points, pose), atol=1e-9)


def test_a_leaning_robot_sees_the_point_on_its_ray_in_the_same_place_at_any_depth():
    lean = np.array([0.0, 0.0, 0.0, 1e-4, -2e-4])
    places = np.random.default_rng(0).uniform(-0.4, 0.4, (10, 2))
    origins, directions = rays_of(places, lean, CAMERA)
    rays = LandmarkRays(origins, directions, np.linspace(0.1, 1.0, 10), np.zeros(10), np.zeros(10))
    np.testing.assert_allclose(seen_from(rays, lean, CAMERA)[0][:, :2], places, atol=1e-7)


def test_derivatives_match_central_differences():
    points, _ = room(10)
    rays, state, step = rays_to(points), np.array([0.2, 0.1, 0.3, 0.0, 0.0]), 1e-6
    _, H, H_inverse = seen_from(rays, state, CAMERA)
    for column, offset in enumerate(np.eye(5) * step):
        ahead, behind = (seen_from(rays, state + sign * offset, CAMERA)[0] for sign in (1, -1))
        np.testing.assert_allclose((ahead - behind) / (2 * step), H[:, :, column], atol=1e-7)
    moved = [
        LandmarkRays(rays.origins, rays.directions, rays.inverses + sign * step, rays.variances, rays.noise)
        for sign in (1, -1)
    ]
    ahead, behind = (seen_from(each, state, CAMERA)[0] for each in moved)
    np.testing.assert_allclose((ahead - behind) / (2 * step), H_inverse, atol=1e-7)


def test_the_pose_from_landmarks_is_that_of_a_general_least_squares_solver():
    points, descriptors = room(25)
    pose = np.array([0.1, -0.05, 0.04])
    picture = features(points, descriptors, pose, noise=0.2 * NOISE)
    found = located(picture, rays_to(points), descriptors, np.zeros(3), np.diag([0.3, 0.3, 0.1]) ** 2)
    assert len(found.landmarks) == 25

    def errors(state):
        return ((picture_of(points, state) - picture.rays) / NOISE).ravel()

    # The prior of 0.3 m and Cauchy's weights of such small errors move it by less than this.
    np.testing.assert_allclose(found.state[:3], least_squares(errors, np.zeros(3)).x, atol=2e-4)


@pytest.mark.slow
def test_its_covariance_is_that_of_many_tries(monkeypatch):
    monkeypatch.setattr(view_pose, "INDEPENDENT", np.inf)
    points, descriptors = room(25)
    rays, pose = rays_to(points), np.array([0.1, -0.05, 0.04])
    squares = []
    for seed in range(300):
        picture = features(points, descriptors, pose, noise=NOISE, seed=seed)
        found = located(picture, rays, descriptors, pose, np.diag([0.3, 0.3, 0.1]) ** 2)
        error = found.state[:3] - pose
        squares.append(error @ np.linalg.solve(found.covariance[:3, :3], error))
    # Cauchy's weights leave half of the information of normal errors out of the covariance.
    assert 1.5 < np.mean(squares) < 3.3


def test_wrong_matches_are_found_and_do_not_move_the_pose():
    points, descriptors = room(40)
    pose = np.array([0.1, -0.05, 0.04])
    picture = features(points, descriptors, pose)
    picture.rays[:8, 0] += 0.05
    found = located(picture, rays_to(points), descriptors, np.zeros(3), np.diag([0.3, 0.3, 0.1]) ** 2)
    assert set(found.landmarks.tolist()) == set(range(8, 40))
    np.testing.assert_allclose(found.state[:3], pose, atol=1e-3)


def test_more_matches_than_are_independent_do_not_make_it_surer():
    deviations = []
    for count in (200, 400):
        points, descriptors = room(count)
        picture = features(points, descriptors, np.zeros(3))
        found = located(picture, rays_to(points), descriptors, np.zeros(3), np.diag([0.3, 0.3, 0.1]) ** 2)
        deviations.append(np.sqrt(np.diag(found.covariance)[:3]))
    np.testing.assert_allclose(*deviations, rtol=0.15)


def test_a_pose_far_from_any_guess_is_found_by_appearance_and_none_in_another_room():
    points, descriptors = room(60)
    rays, pose = rays_to(points), np.array([0.6, -0.4, 0.3])
    picture = features(points, descriptors, pose, noise=NOISE)
    found = locate_anywhere(picture, rays, descriptors, robot_from_camera=CAMERA)
    np.testing.assert_allclose(found, pose, atol=0.1)
    # Features that look the same in other places: no pose explains them.
    shuffled = descriptors[np.random.default_rng(0).permutation(60)]
    assert locate_anywhere(picture, rays, shuffled, robot_from_camera=CAMERA) is None
    assert locate_anywhere(picture, rays, room(60, seed=1)[1], robot_from_camera=CAMERA) is None
    # From the same points seen by a camera half a metre higher, no robot on the floor has such a view.
    lifted = CAMERA.copy()
    lifted[2, 3] += 0.5
    assert locate_anywhere(picture, rays, descriptors, robot_from_camera=lifted) is None


def view_map(prior=(0.0, 0.0, 0.0)):
    camera = SimpleNamespace(robot_from_camera=CAMERA, extent=EXTENT)
    return ViewMap(np.array(prior), np.zeros((3, 3)), camera)


def test_depths_of_one_camera_come_from_motion():
    points, descriptors = room(40)
    poses = [np.array([0.1 * k, -0.15 * k, 0.0]) for k in range(7)]
    built = view_map()
    for number, pose in enumerate(poses):
        picture = features(points, descriptors, pose, noise=NOISE, depth=False, seed=number)
        step = step_between(poses[max(number - 1, 0)], pose)
        state, all_of_them = np.array([*step, 0.0, 0.0]), np.arange(40)
        shown = all_of_them if number else NONE
        found = Located(state, np.diag([1e-6] * 5), shown, shown, shown)
        built.add(picture, found, all_of_them, 1e-6 * np.eye(3))
    rays = built.rays(np.arange(40), 0)
    inverses = picture_of(points, (0.0, 0.0, 0.0))[:, 2]
    error = (rays.inverses - inverses) / np.sqrt(rays.variances)
    assert np.median(np.abs(rays.inverses / inverses - 1.0)) < 0.02
    # The error of the first picture is in all steps, which the filter takes as independent.
    assert 0.2 < np.mean(error**2) < 3.0


def test_a_loop_is_closed_where_the_same_landmarks_are_and_not_where_others_are():
    points, descriptors = room(60)
    others = room(60, seed=1)
    built = view_map()
    drift = np.array([0.02, 0.015, 0.01])
    poses = [*(np.array([0.0, 0.0, 0.4 * k]) for k in range(16)), drift, drift, drift]
    for number, pose in enumerate(poses):
        # A turn on the spot in front of another wall each time, and then the first one again.
        here = number in (0, 16, 17, 18)
        wall, looks = (points, descriptors) if here else (others[0], room(60, seed=number + 1)[1])
        picture = features(wall, looks, np.zeros(3), noise=NOISE, seed=number)
        state = np.array([*step_between(poses[max(number - 1, 0)], pose), 0.0, 0.0])
        built.add(picture, Located(state, np.eye(5), NONE, NONE, NONE), NONE, np.diag([0.01, 0.01, 0.01]) ** 2)
        built.work()
        assert built.loops.closed == (number == 18)
    built.finish()
    np.testing.assert_allclose(compose(np.zeros(3), built.graph.poses[16]), np.zeros(3), atol=0.01)


def test_a_keyframe_looks_most_like_one_with_the_same_features():
    rng, places = np.random.default_rng(0), PlacesSeen()
    looks = [rng.integers(0, 2**63, (50, 4), dtype=np.uint64) for _ in range(8)]
    for look in looks:
        places.add(look)
    again = looks[3].copy()
    again[:, 0] ^= 0b1011  # three bits of each feature differ
    again[:10] = looks[6][:10]
    places.add(again)
    likeness = places.likeness(8, np.arange(8))
    assert np.argsort(-likeness)[:2].tolist() == [3, 6]
    assert likeness[[0, 1, 2, 4, 5, 7]].max() < 0.3 * likeness[3]


def test_features_are_spread_and_the_strongest_of_each_cell_come_first():
    rng = np.random.default_rng(0)
    crowd, rest = rng.uniform(0, 40, (300, 2)), rng.uniform(40, 320, (40, 2))
    pixels, strong = np.concatenate([crowd, rest]), np.concatenate([rng.uniform(1, 2, 300), rng.uniform(0, 1, 40)])
    chosen = spread_out(pixels, strong, count=60)
    assert len(chosen) == 60
    assert np.mean(chosen >= 300) > 0.5
    assert chosen[0] == np.argmax(strong)
    gaps = np.linalg.norm(pixels[chosen][:, None] - pixels[chosen][None], axis=2) + 99.0 * np.eye(60)
    assert gaps.min() > 0.0


def test_depth_at_an_edge_is_that_of_the_nearer_side_and_what_is_behind_is_named():
    depth = np.full((60, 80), 4.0)
    depth[:, 40:] = 2.0
    depth[:, 70:] = np.inf
    pixels = np.array([[20.0, 30.0], [39.0, 30.0], [36.0, 30.0], [41.0, 30.0], [60.0, 30.0], [78.0, 30.0]])
    inverse, deviation, behind = inverse_depths(depth, pixels, farthest=10.0)
    np.testing.assert_allclose(inverse, [0.25, 0.5, 0.25, 0.5, 0.5, 0.05])
    assert behind.tolist() == [False, False, True, False, False, False]
    np.testing.assert_allclose(deviation, [0, 0, 0, 0, 0, 0.05])
    depth[30, 20] = np.nan
    assert np.isnan(inverse_depths(depth, pixels, farthest=10.0)[0][0])


WORLD = """
mjsim: 1
style: office
walls: [{points: [[0, 0], [7, 0], [7, 5], [0, 5]], closed: true, texture: materials/plaster.jpg}]
obstacles:
  - {model: furniture/shelf.urdf, at: [6.6, 1.5], heading_deg: 90}
  - {model: furniture/table.xml, at: [3.5, 4.4]}
beacons:
  - {name: lion, image: posters/lion.jpg, at: [2.2, 4.93], heading_deg: -90, width: 0.8}
ceiling: {texture: materials/ceiling_panels.jpg}
floor: {texture: materials/terrazzo.jpg, tile: 1.2}
robots:
  - name: r
    preset: pioneer3dx
    at: [1.2, 1.2]
    drive: {noise: {speed: 0.02, turn: 0.02}}
    odometry: {noise: {distance: 0.01, turn: 0.03}}
    sensors: [SENSORS]
run:
  seconds: 40
  drivers:
    r:
      estimator: {use: "mjsim.algorithms.visual_slam:VisualSlam", camera: front}
      navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[5.5, 1.2], [5.5, 3.4], [1.2, 3.4], [1.2, 1.2]]}
"""
EYE = "{camera: front, at: [0.1, 0, 1], width: 320, height: 240, fov_deg: 70, rate_hz: 6.25, depth: DEPTH}"


@pytest.mark.slow
@pytest.mark.timeout(300)
@pytest.mark.parametrize("depth", ["{range: [0.3, 10], noise: 0.005}", "false"], ids=["depth", "one camera"])
def test_a_drive_through_a_furnished_room_errs_by_less_than_one_percent_of_the_way(depth, tmp_path):
    world = mjsim.parse_world(WORLD.replace("SENSORS", EYE.replace("DEPTH", depth)))
    recording = mjsim.run(world, seed=1, record=tmp_path / "run.mcap")
    found = mjsim.statistics(recording)["r"]
    assert found["position_error_m"]["rmse"] < 0.01 * found["distance_m"]
    assert 0.1 < found["nees"]["mean"] < 6.0


@pytest.mark.slow
def test_a_robot_without_the_camera_is_told_in_one_line_and_by_check():
    with pytest.raises(ValueError, match=r"^robot 'r' has no camera 'front'; it has none$"):
        VisualSlam("front").start(pioneer(name="r"), {}, np.random.default_rng(0))
    # A camera without a calibration, as of a log, is of no use.
    eye = mjsim.interface.SensorInfo("camera", CAMERA, 5.0)
    with pytest.raises(ValueError, match=r"^the calibration of camera 'front' is not known; give its intrinsics$"):
        VisualSlam().start(pioneer(sensors={"front": eye}), {}, np.random.default_rng(0))
    for sensors, note in (
        ("", "uses cameras, which robot 'r' does not get"),
        (EYE.replace("front", "left"), "'front'"),
    ):
        world = mjsim.parse_world(WORLD.replace("SENSORS", sensors.replace("DEPTH", "false")))
        assert any("VisualSlam" in str(each) and note in str(each) for each in notes_on(world))


@pytest.mark.parametrize(
    "rule", [{"features": -3}, {"distance": 0.0}, {"turn_deg": -1.0}, {"odometry_scale": float("nan")}]
)
def test_rules_that_are_too_small_are_refused(rule):
    (name,) = rule
    with pytest.raises(ValueError, match=f"^{name} is {rule[name]}; it must be a"):
        VisualSlam(**rule)
