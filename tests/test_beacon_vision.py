"""Pictures recognised in drawn views: which, where, how surely, and never one that is not there."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import mujoco
import numpy as np
import pytest
from robots import pioneer
from rooms import forwarded, look_from

from mjsim.algorithms.beacon_vision import BeaconVision, PictureBeacons
from mjsim.algorithms.picture_beacons import View
from mjsim.algorithms.picture_features import LIKELY_BITS, MATCH_BITS, match
from mjsim.algorithms.planar_pose import fit_pose, picture_corners, project, rotation_of
from mjsim.compile import compile_world
from mjsim.geometry import Array, Pose
from mjsim.interface import BeaconInfo, CameraFrame, Detection, Observation, Odometry, Picture, RobotInfo, SensorInfo
from mjsim.sim.canvas import Canvas
from mjsim.sim.lens import intrinsics_of
from mjsim.sim.renderer import Renderer
from mjsim.world import World, parse_world
from mjsim.world.sensors import Camera

POSTERS = Path(__file__).parent.parent / "assets" / "posters"
KNOWN = ("lion", "owl", "whale", "moon", "key", "cat", "fish", "pear", "anchor", "rocket", "tulip", "castle")
STRANGE = ("crown", "daisy", "kite", "snail")
"""They hang here too, but are not searched for."""
ABSENT = ("guitar", "penguin", "teapot", "volcano", "sunrise", "mushroom")
WIDTH = 0.6


def read_posters(names: tuple[str, ...]) -> dict[str, Picture]:
    return {
        name: np.asarray(cv2.imread(str(POSTERS / f"{name}.jpg"), cv2.IMREAD_COLOR_RGB), dtype=np.uint8)
        for name in names
    }


PICTURES = read_posters(KNOWN + STRANGE)
INTRINSICS = intrinsics_of(Camera(camera="front"))
HANGING = "".join(
    f"  - {{name: {name}, image: posters/{name}.jpg, at: [0.07, {2.0 + 1.1 * k:.1f}], width: {WIDTH}, center: 1.2}}\n"
    for k, name in enumerate(KNOWN + STRANGE)
)
ROOM = f"""
mjsim: 1
walls:
  - {{points: [[0, -4], [9, -4], [9, 24], [0, 24]], closed: true}}
floor: {{texture: floors/oak.jpg}}
beacons:
{HANGING}robots:
  - {{name: scout, at: [4, 4], sensors: [{{camera: front}}]}}
"""


@dataclass(frozen=True)
class Shot:
    """A view with its truth."""

    image: Picture
    positions: dict[str, Array]
    """Of the pictures' middles in the optical frame [m]."""
    whole: frozenset[str]
    """Which pictures are whole in the image."""


class Studio:
    """Draws views of the room."""

    def __init__(self) -> None:
        self.world: World = parse_world(ROOM)
        self.model = compile_world(self.world).compile()
        self.data = forwarded(self.model)
        self.canvas = Canvas(self.model)
        self.renderer = Renderer(self.model, width=640, height=480, canvas=self.canvas)

    def shoot(self, at: Array, ahead: Array, *, noise: float = 0.0, rng: np.random.Generator | None = None) -> Shot:
        """Look from a place [m] in a level direction."""
        mujoco.mj_forward(self.model, self.data)
        look_from(self.model, self.data, "scout/front", at, ahead)
        image = self.renderer.render(self.data, "scout/front").copy()
        if rng is not None:
            image = np.clip(np.rint(image + rng.normal(0.0, noise, image.shape)), 0, 255).astype(np.uint8)
        z = ahead / np.linalg.norm(ahead)
        x = np.array([z[1], -z[0], 0.0])
        camera_from_world = np.stack([x, np.cross(z, x), z])
        positions, whole = {}, set()
        for beacon in self.world.beacons:
            middle = np.array([*beacon.at, beacon.center])
            positions[beacon.name] = camera_from_world @ (middle - at)
            height, width = PICTURES[beacon.name].shape[:2]
            half = np.array([0.0, WIDTH / 2, WIDTH / 2 * height / width])
            corners = (middle + half * [[0, -1, -1], [0, -1, 1], [0, 1, 1], [0, 1, -1]] - at) @ camera_from_world.T
            if corners[:, 2].min() > 0.1:
                pixels = project(corners, INTRINSICS)
                if np.all((pixels > 2.0) & (pixels < (637.0, 477.0))):
                    whole.add(beacon.name)
        return Shot(image, positions, frozenset(whole))

    def before(
        self,
        name: str,
        distance: float,
        yaw_deg: float,
        *,
        aside_deg: float = 0.0,
        rng: np.random.Generator | None = None,
    ) -> Shot:
        """Look at a picture from a distance [m], from the side by yaw, with it aside from the image's middle."""
        beacon = next(beacon for beacon in self.world.beacons if beacon.name == name)
        yaw, look = np.radians(yaw_deg), np.radians(yaw_deg + 180.0 + aside_deg)
        at = np.array([*beacon.at, beacon.center]) + distance * np.array([np.cos(yaw), np.sin(yaw), 0.0])
        return self.shoot(at, np.array([np.cos(look), np.sin(look), 0.0]), noise=2.0, rng=rng)


@pytest.fixture(scope="module")
def studio() -> Iterator[Studio]:
    studio = Studio()
    yield studio
    studio.canvas.close()


@pytest.fixture(scope="module")
def beacons() -> PictureBeacons:
    return PictureBeacons({name: (PICTURES[name], WIDTH) for name in KNOWN})


def polar(position: Array) -> tuple[float, float]:
    """Return horizontal range [m] and bearing [deg] of a position in the optical frame."""
    return float(np.hypot(position[0], position[2])), float(np.degrees(np.arctan2(-position[0], position[2])))


def distance_squared(found: Detection, truth: Array) -> float:
    """Return the squared Mahalanobis distance of a detection from the truth."""
    error = found.position - truth
    return float(error @ np.linalg.solve(found.covariance, error))


def random_pose(rng: np.random.Generator) -> tuple[Array, Array]:
    """Return rotation and position of a picture in view, turned by up to 50 degrees."""
    axis = rng.normal(size=3)
    angle = np.radians(rng.uniform(5.0, 50.0))
    position = np.array([rng.uniform(-0.5, 0.5), rng.uniform(-0.3, 0.3), 1.0]) * rng.uniform(1.5, 4.0)
    return rotation_of(axis / np.linalg.norm(axis) * angle), position


def test_the_pose_of_exact_corners_is_found_again():
    rng, size = np.random.default_rng(0), (0.6, 0.8)
    for _ in range(30):
        rotation, position = random_pose(rng)
        corners = project(picture_corners(*size) @ rotation.T + position, INTRINSICS)
        fit = fit_pose(corners, np.eye(8) * 0.01, size, INTRINSICS)
        np.testing.assert_allclose(fit.position, position, atol=1e-6)
        np.testing.assert_allclose(fit.rotation, rotation, atol=1e-5)


def test_the_covariance_of_a_pose_is_the_spread_of_many_noisy_ones():
    rng, size, sigma = np.random.default_rng(1), (0.6, 0.8), 0.05
    distances = []
    for _ in range(300):
        rotation, position = random_pose(rng)
        corners = project(picture_corners(*size) @ rotation.T + position, INTRINSICS)
        fit = fit_pose(corners + rng.normal(0.0, sigma, (4, 2)), np.eye(8) * sigma**2, size, INTRINSICS)
        error = fit.position - position
        distances.append(error @ np.linalg.solve(fit.covariance[:3, :3], error))
    # Mean of 300 chi-square values with 3 degrees of freedom: 3 +- 3 standard deviations of sqrt(6 / 300).
    assert 2.57 < np.mean(distances) < 3.43


def test_matching_is_that_of_brute_force_among_pairs_that_begin_alike():
    rng = np.random.default_rng(2)
    entries = rng.integers(0, 2**63, (400, 4), dtype=np.uint64)
    flips = np.packbits(rng.uniform(size=(150, 256)) < rng.uniform(0.05, 0.3, (150, 1)), axis=1).view(np.uint64)
    rows = entries[rng.integers(0, 400, 150)] ^ flips
    expected = {}
    for k, row in enumerate(rows):
        bits = np.unpackbits((entries ^ row).view(np.uint8), axis=1)
        full = np.where(bits[:, :64].sum(axis=1) <= LIKELY_BITS, bits.sum(axis=1), 999)
        if full.min() <= MATCH_BITS:
            expected[k] = int(np.argmin(full))
    found_rows, found_entries = match(rows, entries)
    assert dict(zip(found_rows.tolist(), found_entries.tolist(), strict=True)) == expected


def test_a_picture_is_found_where_it_hangs(studio: Studio, beacons: PictureBeacons):
    shot = studio.before("owl", 3.0, 20.0, aside_deg=8.0)
    found = {each.name: each for each in beacons.detect(shot.image, INTRINSICS)}
    assert shot.whole & set(KNOWN) <= set(found)
    # A tenth of a pixel of a picture 110 px wide, at 3 m.
    np.testing.assert_allclose(found["owl"].position, shot.positions["owl"], atol=3e-3)
    top_left, top_right, bottom_right, bottom_left = found["owl"].corners
    assert top_left[0] < top_right[0]
    assert top_left[1] < bottom_left[1]
    assert bottom_left[0] < bottom_right[0]


def test_pictures_that_do_not_hang_here_are_never_reported(studio: Studio):
    absent = PictureBeacons({name: (picture, WIDTH) for name, picture in read_posters(ABSENT).items()})
    for name in KNOWN:
        for distance, yaw in ((1.2, 0.0), (3.0, 30.0)):
            assert absent.detect(studio.before(name, distance, yaw).image, INTRINSICS) == []


def test_a_plain_image_or_an_empty_catalogue_gives_nothing(studio: Studio, beacons: PictureBeacons):
    assert beacons.detect(np.full((480, 640, 3), 180, dtype=np.uint8), INTRINSICS) == []
    assert PictureBeacons({}).detect(studio.before("lion", 2.0, 0.0).image, INTRINSICS) == []


def test_a_mirrored_picture_is_not_reported(studio: Studio, beacons: PictureBeacons):
    shot = studio.before("lion", 1.5, 0.0)
    assert beacons.detect(shot.image, INTRINSICS)
    assert not beacons.detect(np.ascontiguousarray(shot.image[:, ::-1]), INTRINSICS)


@pytest.mark.parametrize("share", [0.2, 0.4, 0.6])
def test_a_partly_hidden_picture_is_right_or_withheld(studio: Studio, beacons: PictureBeacons, share: float):
    for name in ("lion", "castle", "fish"):
        for side in (0, 1):
            shot = studio.before(name, 1.8, 15.0)
            outline = next(each for each in beacons.detect(shot.image, INTRINSICS) if each.name == name).corners
            low, high = outline.min(axis=0), outline.max(axis=0)
            start, stop = low.copy(), high.copy()
            stop[side] = low[side] + share * (high - low)[side]
            hidden = shot.image.copy()
            hidden[int(start[1]) : int(stop[1]), int(start[0]) : int(stop[0])] = (90, 110, 70)
            for each in beacons.detect(hidden, INTRINSICS):
                np.testing.assert_allclose(each.position, shot.positions[each.name], atol=0.02)


def test_a_picture_cut_by_the_edge_of_the_image_is_right_or_withheld(studio: Studio, beacons: PictureBeacons):
    seen = 0
    for aside in np.arange(20.0, 36.0, 2.0):
        shot = studio.before("rocket", 2.0, 0.0, aside_deg=float(aside))
        for each in beacons.detect(shot.image, INTRINSICS):
            seen += "rocket" not in shot.whole
            np.testing.assert_allclose(each.position, shot.positions[each.name], atol=0.02)
    assert seen > 0


def test_following_a_picture_measures_the_same_as_finding_it(studio: Studio, beacons: PictureBeacons):
    for distance, yaw in ((1.5, 0.0), (2.5, 25.0), (4.0, -35.0)):
        shot = studio.before("anchor", distance, yaw, rng=np.random.default_rng(3))
        view = View(shot.image, INTRINSICS)
        cold = next(each for each in beacons.search(view) if each.detection.name == "anchor")
        # As far off as odometry may be after a fast turn: 10 px.
        guess = cold.pose.position + np.array([10.0 / INTRINSICS.fx * distance, 0.0, 0.02])
        followed = beacons.track("anchor", cold.pose.rotation, guess, view)
        assert followed is not None
        assert distance_squared(followed.detection, cold.detection.position) < 1.0


def robot_info(robot_from_camera: Array) -> RobotInfo:
    camera = SensorInfo("camera", robot_from_camera, 12.5, intrinsics=INTRINSICS)
    return pioneer(dt=0.08, prior=Pose(0.0, 0.0, 0.0), sensors={"front": camera})


def test_the_observer_follows_pictures_through_a_fast_turn(studio: Studio):
    offset = np.array([0.15, 0.05, 1.1])
    robot_from_camera = np.eye(4)
    robot_from_camera[:3, :3] = [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]
    robot_from_camera[:3, 3] = offset
    observer = BeaconVision("front")
    catalogue = {name: BeaconInfo(name, PICTURES[name], WIDTH, WIDTH) for name in KNOWN}
    observer.start(robot_info(robot_from_camera), catalogue, np.random.default_rng(0))
    pose, step, seen = Pose(3.0, 9.0, 2.2), Pose(0.03, 0.0, np.radians(8.0)), set()
    for k in range(12):
        pose = pose @ step
        ahead = np.array([np.cos(pose.heading), np.sin(pose.heading), 0.0])
        left = np.array([-ahead[1], ahead[0], 0.0])
        at = np.array([pose.x, pose.y, 0.0]) + offset[0] * ahead + offset[1] * left + [0.0, 0.0, offset[2]]
        shot = studio.shoot(at, ahead)
        # Wheels tell half a degree too much, 5 px: 2 standard deviations of odometry after such a turn.
        told = Odometry(step.x, 0.0, step.heading + np.radians(0.5), np.eye(3))
        frame = CameraFrame(0.08 * k, shot.image, INTRINSICS)
        for sighting in observer.observe(Observation(0.08 * k, 0.08, told, cameras={"front": frame})):
            place = next(beacon.at for beacon in studio.world.beacons if beacon.name == sighting.name)
            x, y = pose.inverse().transform(place)
            # Both are ten times what is usual, and far from what a wrong match gives.
            assert sighting.range == pytest.approx(np.hypot(x, y), rel=5e-3)
            assert sighting.bearing == pytest.approx(np.arctan2(y, x), abs=1e-3)
            seen.add(sighting.name)
    assert len(seen) >= 4


def test_a_tick_without_an_image_gives_nothing_and_a_wrong_camera_is_named():
    observer = BeaconVision("frnt")
    with pytest.raises(ValueError, match="no camera 'frnt' on this robot; it has front"):
        observer.start(robot_info(np.eye(4)), {}, np.random.default_rng(0))
    observer = BeaconVision()
    observer.start(
        robot_info(np.eye(4)), {"lion": BeaconInfo("lion", PICTURES["lion"], 0.6, 0.8)}, np.random.default_rng(0)
    )
    assert observer.observe(Observation(0.0, 0.08, Odometry(0.0, 0.0, 0.0, np.eye(3)))) == ()


@pytest.mark.slow
def test_pictures_are_found_and_measured_from_1_to_4_metres_and_45_degrees(studio: Studio, beacons: PictureBeacons):
    rng, counts, errors, distances = np.random.default_rng(4), {30: [0, 0], 45: [0, 0]}, [], []
    for k in range(120):
        name = KNOWN[k % len(KNOWN)]
        yaw = float(rng.uniform(-45.0, 45.0))
        shot = studio.before(name, float(rng.uniform(1.3, 4.0)), yaw, aside_deg=float(rng.uniform(-12, 12)), rng=rng)
        found = {each.name: each for each in beacons.detect(shot.image, INTRINSICS)}
        assert set(found) <= set(KNOWN)
        for each in found.values():
            (distance, bearing), (truth, direction) = polar(each.position), polar(shot.positions[each.name])
            assert abs(distance / truth - 1.0) < 0.1, f"{each.name} in view {k}"
            assert abs(bearing - direction) < 2.0, f"{each.name} in view {k}"
            errors.append((abs(distance / truth - 1.0), abs(bearing - direction)))
        if name in shot.whole:
            count = counts[30 if abs(yaw) <= 30.0 else 45]
            count[0] += name in found
            count[1] += 1
            if name in found:
                distances.append(distance_squared(found[name], shot.positions[name]))
    assert counts[30][0] >= 0.95 * counts[30][1] > 40
    assert counts[45][0] >= 0.85 * counts[45][1] > 15
    median = np.median(errors, axis=0)
    assert median[0] < 0.002
    assert median[1] < 0.01
    # Honest: 3 for a perfect covariance.
    assert 1.0 < np.mean(distances) < 4.5
