"""The main job, whole: the gallery with camera, recognition and SLAM, measured against the truth."""

from pathlib import Path

import numpy as np
import pytest

import mjsim
from mjsim.record import numeric_topics, same_run

GALLERY = Path(__file__).parents[2] / "worlds" / "gallery.yaml"

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def figures(tmp_path_factory):
    """The figures of the robot after half a lap of the tour with five pictures in two seconds, and its track."""
    file = tmp_path_factory.mktemp("gallery") / "run.mcap"
    with mjsim.Simulation(mjsim.load_world(GALLERY, settings=["robots.scout.sensors.front.rate_hz=2.5"])) as sim:
        recording = mjsim.run(sim, seconds=33.0, record=file, pictures=False)
    return mjsim.statistics(recording)["scout"], recording


def test_the_estimate_is_near_the_truth_and_far_better_than_odometry(figures):
    own, _ = figures
    assert own["position_error_m"]["mean"] < 0.03
    assert own["position_error_m"]["mean"] < own["odometry_error_m"]["mean"] / 3
    assert own["heading_error_deg"]["mean"] < 2.0


def test_every_poster_that_is_passed_is_in_the_map_where_it_hangs_and_no_other(figures):
    own, recording = figures
    passed = [beacon.name for beacon in recording.world.beacons[:16]]
    landmarks = own["landmark_error_m"]
    assert (passed[0], passed[-1]) == ("lion", "guitar")
    assert set(passed) <= set(landmarks["aligned_each"])
    assert landmarks["aligned_max"] < 0.05
    assert landmarks["false"] == 0


def test_the_robot_drives_its_tour_without_a_bump(figures):
    own, recording = figures
    track = recording.robots["scout"]
    assert own["bumps"] == 0
    # Through the door to the other room and around it: the wall between them stands at x = 7.
    assert np.count_nonzero(np.diff(np.sign(track.truth[:, 0] - 7.0))) == 1
    np.testing.assert_allclose(track.truth[-1, :2], (9.6, 8.1), atol=1.0)


def test_a_seed_gives_the_same_bytes_with_camera_and_recognition_and_another_does_not(tmp_path):
    files = [tmp_path / f"{name}.mcap" for name in "abc"]
    for file, seed in zip(files, (1, 1, 2), strict=True):
        with mjsim.Simulation("manipulator", seed=seed) as sim:
            mjsim.run(sim, seconds=0.6, record=file)
    assert same_run(files[0], files[1])
    first, other = numeric_topics(files[0]), numeric_topics(files[2])
    for topic in ("observation", "estimate", "sightings"):
        assert first[f"/fetcher/{topic}"] != other[f"/fetcher/{topic}"]
