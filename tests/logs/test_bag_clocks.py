"""Clocks that were set while a bag was recorded."""

import numpy as np
import pytest

from mjsim.geometry import Pose, Pose3
from mjsim.logs.bags.bag_clocks import Clocks
from mjsim.logs.bags.bag_order import set_backs
from tests.bags import START, new_bag
from tests.real_logs import imported


def _heard(recorded: np.ndarray, stamps: np.ndarray) -> tuple[np.ndarray, dict[str, str]]:
    """Return the times that two readings of a bag end with, and what is said."""
    clocks = Clocks()
    for pair in zip(recorded, stamps, strict=True):
        clocks.time("/odom", *pair)
    notes = clocks.settle()
    return np.array([clocks.time("/odom", *pair) for pair in zip(recorded, stamps, strict=True)]), dict(notes)


@pytest.mark.parametrize("step", [-0.3, -5.0, 120.0, -1.6e9])
def test_times_go_on_where_a_clock_was_set_and_set_again(step):
    true = START + 0.1 * np.arange(90)
    late = np.random.default_rng(0).uniform(0.0, 0.02, 90)
    stamps = true + np.repeat([0.0, step, 3.0], 30)
    times, notes = _heard(true + late, stamps)
    np.testing.assert_allclose(times, true, atol=0.05)
    assert notes["clock of /odom"].startswith(f"mended: set 2 times ({step:+.{int(abs(step) < 1)}f}"[:-2])


@pytest.mark.parametrize("wrong", [-1e9, -30.0, -0.3, 30.0])
def test_single_wrong_times_pauses_and_recorders_that_tell_nothing_set_no_clock(wrong):
    true = START + 0.1 * np.arange(60)
    stamps = true.copy()
    stamps[[20, 40]] += wrong
    pause = np.where(true > true[30], true + 500.0, true)
    for recorded, told in ((true, stamps), (pause, pause), (np.full(60, START), pause), (np.arange(60.0), true)):
        times, notes = _heard(recorded, told)
        assert not notes
        np.testing.assert_array_equal(times, told)


@pytest.mark.parametrize("others", [START, 0.0])
def test_topics_of_a_simulated_clock_beside_others_of_the_wall_clock_are_moved_to_that_of_most(others):
    clocks, recorded = Clocks(), START + 0.1 * np.arange(30)

    def heard():
        clocks.time("/odom", START, START - others)  # wrong, as of a stamp of 0 that is taken for missing
        odometry = [clocks.time("/odom", at, at - START + others) for at in np.repeat(recorded, 2)]
        return odometry[::2], [clocks.time("/scan", at, at - others) for at in recorded]

    heard()
    notes = clocks.settle()
    odometry, scans = heard()
    np.testing.assert_allclose(scans, odometry, atol=1e-3)
    assert len(notes) == 1
    assert notes["start of the clock of /scan"].startswith(f"mended: {START - 2 * others:+.6g} s from that of /odom;")


@pytest.mark.slow
def test_a_clock_that_is_set_back_does_not_mix_two_parts_of_a_drive(tmp_path):
    with new_bag(tmp_path / "run") as bag:
        for k in range(40):
            recorded = START + 0.1 * k
            at = recorded - (2.0 if k >= 20 else 0.0)
            pose = Pose3.from_planar(Pose(0.05 * k, 0.0, 0.0))
            bag.put("/odom", recorded, bag.odometry(bag.header(at, "odom"), "base_link", pose))
            bag.put("/scan", recorded, bag.scan(bag.header(at, "laser"), np.full(5, 1.0 + k), 0.0, 0.1, (0.1, 90.0)))
    run = imported(tmp_path / "run")
    seen = [each.scans["scan"].ranges[0] for each in run.observations("robot") if each.scans]
    assert seen == [1.0 + k for k in range(40)]
    assert min(each.odometry.forward for each in run.observations("robot")) >= 0.0
    assert run.metadata["clock of /scan"] == "mended: set 1 times (-2.0 s); the jumps are removed"


@pytest.mark.slow
@pytest.mark.parametrize("wrong", [range(3), range(57, 60)])
def test_a_clock_that_is_set_right_after_the_start_or_wrong_before_the_end_is_that_of_the_others(wrong, tmp_path):
    year = 3e7
    with new_bag(tmp_path / "bag") as bag:
        for k in range(60):
            at = START + 0.1 * k
            stamp = at + (year if k in wrong else 0.0)
            bag.put("/odom", at, bag.odometry(bag.header(at, "odom"), "base_link", Pose3(0.1 * k, *[0] * 5, 1)))
            bag.put("/scan", at, bag.scan(bag.header(stamp, "laser"), np.full(9, 1.0 + k), -0.4, 0.1, (0.1, 90.0)))
    run = imported(tmp_path / "bag")
    start = float(run.metadata["log start"]) - START
    scans = [seen.scans["scan"] for seen in run.observations("robot") if seen.scans]
    assert [scan.ranges[0] for scan in scans] == [1.0 + k for k in range(60)]
    np.testing.assert_allclose([scan.stamp + start for scan in scans], 0.1 * np.arange(60), atol=1e-3)
    assert run.metadata["/scan messages left out"] == "0"


def _put_drive(bag, recorded: list[float], *, is_own: bool = True) -> None:
    """Write odometry at 50 Hz, scans at 10 Hz, commands, and pictures once a second, by a clock at these times."""
    for k, at in enumerate(recorded):
        stamp = at if is_own else START + 0.02 * k
        bag.put("/odom", at, bag.odometry(bag.header(stamp, "odom"), "base_link", Pose3(0.01 * k, *[0] * 5, 1)))
        if k % 5 == 2:
            far = np.full(5, 1.0 + k // 5)
            bag.put("/scan", at + 0.004, bag.scan(bag.header(stamp + 0.003, "laser"), far, 0.0, 0.1, (0.1, 900.0)))
        if k % 10 == 6:
            twist = bag.make("geometry_msgs/Twist", linear=bag.xyz(1.0 + k // 10, 0, 0), angular=bag.xyz(0, 0, 0))
            bag.put("/cmd_vel", at + 0.001, twist)
        if k % 50 == 33:
            picture = np.full((16, 16), k // 50, dtype=np.uint8)
            bag.put("/eye/image_raw", at + 0.002, bag.image(bag.header(stamp + 0.001, "eye"), "mono8", picture))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("form", "back", "is_own"),
    [
        ("bag-lz4", 0.3, True),
        ("sqlite", 0.3, True),
        ("mcap", 0.3, True),
        ("mcap-storage", 7.0, True),
        ("mcap-message", 0.3, True),
        ("bag", 0.3, False),
    ],
)
def test_parts_do_not_mix_where_the_clock_of_the_recorder_was_set_back(form, back, is_own, tmp_path):
    true = [START + 0.02 * k for k in range(300)]
    path = tmp_path / ("run.bag" if form.startswith("bag") else "run")
    with new_bag(path, form) as bag:
        _put_drive(bag, [at - (back if k >= 125 else 0.0) for k, at in enumerate(true)], is_own=is_own)
    run = imported(path)
    assert (
        run.metadata["clock of the recorder"] == f"mended: set back 1 times (-{back:.2f} s); times continue from there"
    )
    seen = list(run.observations("robot"))
    assert [each.scans["scan"].ranges[0] for each in seen if each.scans] == [1.0 + k for k in range(60)]
    times = [each.scans["scan"].stamp for each in seen if each.scans]
    np.testing.assert_allclose(np.diff(times), 0.1, atol=0.005)
    moved = [each.odometry.forward for each in seen]
    assert min(moved) >= 0.0
    assert sum(moved) == pytest.approx(2.99, abs=0.05)
    pictures = [image[0, 0, 0] for _, image in run.images("robot", "eye")]
    assert pictures == list(range(6))
    np.testing.assert_allclose(np.diff([stamp for stamp, _ in run.images("robot", "eye")]), 1.0, atol=0.01)


def test_files_of_a_split_bag_stay_in_order_where_the_clock_was_set_back_before_the_first_one(tmp_path):
    (tmp_path / "run").mkdir()
    for part, (times, back) in enumerate([(range(20), 0.0), (range(20, 60), 3.0)]):
        with new_bag(tmp_path / f"part{part}") as bag:
            for k in times:
                at = START + 0.1 * k - back
                bag.put("/scan", at, bag.scan(bag.header(at, "laser"), np.full(5, 1.0 + k), 0.0, 0.1, (0.1, 900.0)))
        next((tmp_path / f"part{part}").glob("*.mcap")).rename(tmp_path / "run" / f"run_{part}.mcap")
    run = imported(tmp_path / "run")
    assert run.metadata["clock of the recorder"] == "mended: set back 1 times (-3.00 s); times continue from there"
    scans = [seen.scans["scan"].ranges[0] for seen in run.observations("robot") if seen.scans]
    assert scans == [1.0 + k for k in range(60)]


def test_disorder_of_a_bag_sets_no_clock(tmp_path):
    rng = np.random.default_rng(0)
    true = START + 0.02 * np.arange(400)
    late = np.where(np.arange(400) % 97 == 50, 0.3, 0.0)
    orders = {
        "late": np.argsort(true + late, kind="stable"),
        "jitter": np.argsort(true + rng.uniform(0.0, 0.05, 400), kind="stable"),
        # By topic, one after the other, as converters of data sets write.
        "topics": np.argsort(np.arange(400) % 4, kind="stable"),
        "pause": np.arange(400),
    }
    for name, order in orders.items():
        topics = order % 4 if name == "topics" else order % 2
        times = true[order] + (np.arange(400) > 200) * (5.0 if name == "pause" else 0.0)
        assert set_backs(topics, times - START) == [], name


def test_the_clock_of_topics_whose_times_are_far_from_each_other_is_found_to_be_set_back():
    """As in bags in which the times of recording are those of headers, by several clocks."""
    topics = np.arange(80) % 2
    times = 0.1 * np.arange(80) - 0.9 * (np.arange(80) >= 40) - 3.0 * (topics == 1)
    ((row, back),) = set_backs(topics, times)
    assert row == 40
    assert back == pytest.approx(0.9)
