"""Pictures recognised in drawn views: which, where, how surely, and never one that is not there."""

from collections.abc import Iterator

import numpy as np
import pytest

from mjsim.algorithms.beacon_vision.beacon_vision import BeaconVision, PictureBeacons
from mjsim.algorithms.beacon_vision.picture_beacons import PreparedImage
from mjsim.algorithms.beacon_vision.picture_features import LIKELY_BITS, MATCH_BITS, match
from mjsim.algorithms.beacon_vision.planar_pose import fit_pose, picture_corners, rotation_of
from mjsim.bench.views import (
    ABSENT,
    INTRINSICS,
    KNOWN,
    PICTURES,
    WIDTH,
    Studio,
    Tally,
    distance_squared,
    project,
    read_posters,
)
from mjsim.geometry import Array, Pose
from mjsim.interface import BeaconInfo, CameraFrame, Observation, Odometry, RobotInfo, SensorInfo
from tests.robots import pioneer


@pytest.fixture(scope="module")
def studio() -> Iterator[Studio]:
    studio = Studio()
    yield studio
    studio.canvas.close()


@pytest.fixture(scope="module")
def beacons() -> PictureBeacons:
    return PictureBeacons({name: (PICTURES[name], WIDTH) for name in KNOWN})


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


@pytest.mark.slow
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


@pytest.mark.slow
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


@pytest.mark.slow
def test_pictures_that_do_not_hang_here_are_never_reported(studio: Studio):
    absent = PictureBeacons({name: (picture, WIDTH) for name, picture in read_posters(ABSENT).items()})
    for name in KNOWN:
        assert absent.detect(studio.before(name, 1.2, 15.0).image, INTRINSICS) == []


@pytest.mark.slow
def test_a_plain_image_or_an_empty_catalogue_gives_nothing(studio: Studio, beacons: PictureBeacons):
    assert beacons.detect(np.full((480, 640, 3), 180, dtype=np.uint8), INTRINSICS) == []
    assert PictureBeacons({}).detect(studio.before("lion", 2.0, 0.0).image, INTRINSICS) == []


@pytest.mark.slow
def test_a_mirrored_picture_is_not_reported(studio: Studio, beacons: PictureBeacons):
    shot = studio.before("lion", 1.5, 0.0)
    assert beacons.detect(shot.image, INTRINSICS)
    assert not beacons.detect(np.ascontiguousarray(shot.image[:, ::-1]), INTRINSICS)


@pytest.mark.slow
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


@pytest.mark.slow
def test_a_picture_cut_by_the_edge_of_the_image_is_right_or_withheld(studio: Studio, beacons: PictureBeacons):
    seen = 0
    for aside in np.arange(20.0, 36.0, 2.0):
        shot = studio.before("rocket", 2.0, 0.0, aside_deg=float(aside))
        for each in beacons.detect(shot.image, INTRINSICS):
            seen += "rocket" not in shot.whole
            np.testing.assert_allclose(each.position, shot.positions[each.name], atol=0.02)
    assert seen > 0


@pytest.mark.slow
def test_following_a_picture_measures_the_same_as_finding_it(studio: Studio, beacons: PictureBeacons):
    for distance, yaw in ((1.5, 0.0), (2.5, 25.0), (4.0, -35.0)):
        shot = studio.before("anchor", distance, yaw, rng=np.random.default_rng(3))
        view = PreparedImage(shot.image, INTRINSICS)
        cold = next(each for each in beacons.search(view) if each.detection.name == "anchor")
        # As far off as odometry may be after a fast turn: 10 px.
        guess = cold.pose.position + np.array([10.0 / INTRINSICS.fx * distance, 0.0, 0.02])
        followed = beacons.track("anchor", cold.pose.rotation, guess, view)
        assert followed is not None
        assert distance_squared(followed.detection, cold.detection.position) < 1.0


def robot_info(robot_from_camera: Array) -> RobotInfo:
    camera = SensorInfo("camera", robot_from_camera, 12.5, intrinsics=INTRINSICS)
    return pioneer(dt=0.08, prior=Pose(0.0, 0.0, 0.0), sensors={"front": camera})


@pytest.mark.slow
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
    rng, tally = np.random.default_rng(4), Tally()
    for k in range(36):
        name, yaw = KNOWN[k % len(KNOWN)], float(rng.uniform(-45.0, 45.0))
        shot = studio.before(name, float(rng.uniform(1.3, 4.0)), yaw, aside_deg=float(rng.uniform(-12, 12)), rng=rng)
        found = beacons.detect(shot.image, INTRINSICS)
        assert {each.name for each in found} <= set(KNOWN)
        tally.add(name, yaw, shot, found)
    assert tally.gross == 0
    assert tally.found[30][0] >= 0.95 * tally.found[30][1] > 12
    assert tally.found[45][0] >= 0.85 * tally.found[45][1] > 4
    median = np.median(tally.errors, axis=0)
    assert median[0] < 0.002
    assert median[1] < 0.01
    # Honest: 3 for a perfect covariance.
    assert 1.0 < np.mean(tally.distances) < 4.5
