"""EKF-SLAM beside the textbook's, given the same drives."""

import tarfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mjsim.algorithms.ekf_slam.ekf_slam import EkfSlam
from mjsim.algorithms.textbook import TextbookEkfSlam
from mjsim.bench.slam_rooms import ROOMS, ekf_slam, scores_in_log, scores_in_room
from tests.real_logs import imported

pytestmark = pytest.mark.slow
VARIANTS = ("standard", "first-estimates", "invariant")


def brief(room, seconds):
    """Return a room in which a run is shorter."""
    return replace(room, text=room.text.replace("seconds: 60", f"seconds: {seconds}"))


@pytest.mark.parametrize(("name", "seconds", "seeds"), [("plain", 30, (1, 5)), ("nameless", 20, (1,))])
def test_the_estimator_loses_nothing_beside_the_textbook(name, seconds, seeds):
    room = brief(ROOMS[name], seconds)
    runs = [scores_in_room(room, {v: ekf_slam(room, v) for v in VARIANTS}, seed=seed) for seed in seeds]
    for variant in VARIANTS:
        book, own = (np.array([[run[who].error, run[who].nees] for run in runs]) for who in ("textbook", variant))
        assert np.all(own[:, 0] < np.maximum(1.3 * book[:, 0], book[:, 0] + 0.015)), variant
        # Over twelve drives the means are within 5 and 10 %.
        error, nees = own.mean(axis=0) / book.mean(axis=0)
        assert error < 1.1, variant
        assert 0.85 < nees < 1.15, variant


@pytest.fixture(scope="module")
def mrclam(tmp_path_factory):
    """The first 220 s of a real robot, which sees landmarks poorly at first; tests/data/mrclam says whose."""
    folder = tmp_path_factory.mktemp("mrclam")
    with tarfile.open(Path(__file__).parents[1] / "data" / "mrclam" / "robot1.tar.xz") as archive:
        archive.extractall(folder, filter="data")
    return imported(folder).between(0.0, 220.0)


def test_every_variant_stands_the_poor_first_looks_of_a_real_robot(mrclam):
    variants = {variant: EkfSlam(jacobians=variant) for variant in VARIANTS}
    variants["start"] = EkfSlam(jacobians="invariant", frame="start")
    scores = scores_in_log(mrclam, "robot1", {"textbook": TextbookEkfSlam(), **variants})
    # First estimates that stay at a poor first look: 1.0 m.
    assert scores["textbook"].ate < 0.4
    assert scores["first-estimates"].ate < 0.25
    assert max(scores["standard"].ate, scores["invariant"].ate) < 0.6
    # Not aligned: what knows how little it knows of its heading comes back to it.
    assert scores["start"].error < scores["textbook"].error
    # The frame of the map keeps what was reported before that, and its covariance says so.
    assert scores["invariant"].ate < scores["start"].ate
    assert scores["invariant"].nees < 4.5


def test_graph_slam_solves_the_plain_room_and_a_real_log(mrclam):
    pytest.importorskip("gtsam", reason="an extra")
    from mjsim.algorithms.graph_slam import GraphSlam

    # Odometry claims to be exact along a direction when the robot turns on the spot; it does so after 12 s.
    for seed in range(2):
        assert scores_in_room(brief(ROOMS["plain"], 16), {"graph": GraphSlam()}, seed=seed)["graph"].error < 0.08
    scores = scores_in_log(mrclam, "robot1", {"map": GraphSlam(), "start": GraphSlam(frame="start")})
    # In the frame of the map what was told before stays right, 0.16 m; in that of the start it does not, 0.27 m, but
    # the start is where it was: 0.53 m unaligned, not 0.73.
    assert scores["map"].ate < 0.2
    assert scores["start"].error < 0.6
    assert max(each.nees for each in scores.values()) < 4.5
