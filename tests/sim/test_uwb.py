"""Ranges to radio anchors, held to distances in space and to the distributions of their errors."""

import csv
import json
import math

import numpy as np
import pytest
from scipy import stats
from scipy.spatial.transform import Rotation

import mjsim
from mjsim.env import GymEnvironment, Task
from mjsim.geometry import Pose
from mjsim.interface import Command
from mjsim.record import export_csv, export_mat, export_npz
from mjsim.sim import Simulation
from mjsim.world import parse_world
from tests.sim.devices import taken

ORIGIN = Pose(0, 0, 0)
ANCHORS = {"low": (3.0, 0.0, 0.2), "left": (1.0, 4.0, 2.4), "behind": (-5.0, -2.0, 1.2)}
OPEN = "beacons:\n" + "".join(
    f"  - {{name: {name}, at: [{x}, {y}], center: {z}, anchor: true}}\n" for name, (x, y, z) in ANCHORS.items()
)
WALLED = """
walls: [{points: [[2, -3], [2, 3]], height: 2.5, openings: [{at: 2.5, width: 1, sill: 0.9, head: 2.0}]}]
obstacles: [{name: table, box: [0.6, 0.6, 0.7], at: [-1.5, 0]}]
beacons:
  - {name: wall, at: [4, 2.5], center: 1.2, anchor: true}
  - {name: window, at: [4, 0.3], center: 1.4, anchor: true}
  - {name: desk, at: [-3, 0], center: 0.5, anchor: true}
  - {name: above, at: [-3, 0], center: 2.4, anchor: true}
"""
"""From a tag at the origin, 1.2 m up: behind a wall, behind its window, and low and high behind a table."""


def tagged(keys: str = "", *, world: str = OPEN, pose: Pose = ORIGIN, rate: float = 25.0, seed: int = 1) -> Simulation:
    place = f"at: [{pose.x}, {pose.y}], heading_deg: {math.degrees(pose.heading)}"
    robot = f"{{name: r, {place}, sensors: [{{uwb: tag{keys}}}]}}"
    run = f"run: {{rate_hz: {rate}, seed: {seed}}}"
    return Simulation(parse_world(f"mjsim: 1\n{world}\nrobots: [{robot}]\n{run}\n"))


def readings(sim: Simulation, count: int) -> list[dict[str, float]]:
    """Return the ranges of a robot that stands still, one dict a reading."""
    told = []
    with sim:
        while len(told) < count:
            seen = sim.sense("r").ranges
            if seen:
                told.append(dict(seen["tag"].ranges))
            sim.step()
    return told


def columns(keys: str, *anchors: str, count: int, **options) -> np.ndarray:
    with tagged(f", at: [0, 0, 1.2], rate_hz: 250{keys}", rate=250, **options) as sim:
        told = [reading.ranges for reading in taken(sim, count, seed=sim.seed)]
    return np.array([[reading.get(anchor, np.nan) for anchor in anchors] for reading in told])


@pytest.mark.parametrize("pose", [Pose(0, 0, 0), Pose(0.5, -1, 2.5), Pose(-1, 1, -1.2)])
def test_a_range_is_the_distance_in_space_from_the_tag_to_the_anchors_middle(pose):
    with tagged(", at: [0.2, -0.1, 0.4]", pose=pose) as sim:
        seen = sim.sense("r")
        tag = np.array([pose.x, pose.y, 0]) + Rotation.from_euler("z", pose.heading).apply([0.2, -0.1, 0.4])
        reading = seen.ranges["tag"]
        assert reading.stamp == seen.time == 0.0
        assert list(reading.ranges) == list(ANCHORS)
        for name, place in ANCHORS.items():
            # A robot stands on its wheels to within a tenth of a millimetre.
            assert reading.ranges[name] == pytest.approx(math.dist(tag, place), abs=2e-4)


def test_it_hears_what_is_in_reach_on_other_robots_too_and_not_its_own():
    world = OPEN + "  - {name: own, at: [3.5, 0], center: 0.5, anchor: true, on: r}\n"
    world += "  - {name: friend, at: [0, 0], center: 0.5, anchor: true, on: other}\n  - {name: deaf, at: [1, 1]}\n"
    robots = (
        "[{name: r, at: [0, 0], sensors: [{uwb: tag, at: [0, 0, 0.5], range: [3, 6]}]}, {name: other, at: [0, -4]}]"
    )
    with Simulation(parse_world(f"mjsim: 1\n{world}\nrobots: {robots}\n")) as sim:
        assert set(sim.sense("r").ranges["tag"].ranges) == {"low", "left", "behind", "friend"}
        sim.move("other", Pose(0, -2.0, 0))
        sim.remove("left")
        for _ in range(2):
            sim.step()
        assert set(sim.sense("r").ranges["tag"].ranges) == {"low", "behind"}
        assert sim.catalogue["own"].anchor
        assert not sim.catalogue["deaf"].anchor


def test_walls_and_things_block_a_way_at_the_height_at_which_it_leads():
    told = columns(", nlos: {missed: 1}", "wall", "window", "desk", "above", count=1, world=WALLED)
    assert np.isnan(told[0]).tolist() == [True, False, False, False]
    low = readings(tagged(", at: [0, 0, 0.3], nlos: {missed: 1}", world=WALLED), 1)
    assert set(low[0]) == {"above"}


def test_a_blocked_range_is_too_long_by_an_exponentially_distributed_excess_and_others_are_not():
    told = columns(", nlos: {bias: 0.4}", "wall", "window", "desk", count=400, world=WALLED)
    truth = [math.dist((0, 0, 1.2), place) for place in ((4, 2.5, 1.2), (4, 0.3, 1.4), (-3, 0, 0.5))]
    excess = told[:, 0] - truth[0]
    # The body of the robot settles by less than a tenth of a millimetre.
    assert excess.min() > -1e-3
    assert excess.mean() == pytest.approx(0.4, abs=4 * 0.4 / math.sqrt(400))
    assert stats.kstest(excess, stats.expon(scale=0.4).cdf).pvalue > 1e-3
    np.testing.assert_allclose(told[:, 1:], np.broadcast_to(truth[1:], (400, 2)), atol=1e-3)


def test_noise_is_white_and_of_the_deviation_that_the_world_says():
    told = columns(", noise: {range: 0.1}", *ANCHORS, count=2000)
    errors = told - [math.dist((0, 0, 1.2), place) for place in ANCHORS.values()]
    assert np.all(np.abs(errors.mean(axis=0)) < 4 * 0.1 / math.sqrt(2000))
    assert np.all(np.abs(errors.std(axis=0) / 0.1 - 1) < 4 / math.sqrt(4000))
    white = np.corrcoef(np.hstack([errors[1:], errors[:-1]]).T) - np.eye(6)
    assert np.abs(white).max() < 4.5 / math.sqrt(2000)


def test_no_range_is_negative_however_near_an_anchor_is():
    near = "beacons: [{name: near, at: [0.1, 0], center: 1.2, anchor: true}]"
    told = columns(", noise: {range: 0.3}", "near", count=100, world=near)
    assert told.min() == 0.0
    assert 20 < (told == 0.0).sum() < 60


def test_a_bias_is_constant_in_a_run_and_differs_from_anchor_to_anchor_and_from_run_to_run():
    truth = [math.dist((0, 0, 1.2), place) for place in ANCHORS.values()]
    biases = []
    with tagged(", at: [0, 0, 1.2], bias: 0.2") as sim:
        for seed in range(60):
            told = np.array([[reading.ranges[name] for name in ANCHORS] for reading in taken(sim, 3, seed=seed)])
            np.testing.assert_array_equal(told, np.broadcast_to(told[0], told.shape))
            biases.append(told[0] - truth)
    assert np.std(biases) == pytest.approx(0.2, rel=4 / math.sqrt(2 * 180))
    assert abs(np.mean(biases)) < 4 * 0.2 / math.sqrt(180)


def test_ranges_are_missed_as_often_as_asked_for_with_and_without_line_of_sight():
    told = columns(", missed: 0.1, nlos: {missed: 0.5}", "wall", "window", count=2000, world=WALLED)
    missed = np.isnan(told).mean(axis=0)
    # Binomial: 4 standard deviations of 2000 trials.
    assert missed[0] == pytest.approx(1 - 0.9 * 0.5, abs=4 * 0.011)
    assert missed[1] == pytest.approx(0.1, abs=4 * 0.0067)


def test_what_stands_between_or_who_looks_leaves_all_other_chance_as_it_was():
    keys = ", noise: {range: 0.1}, nlos: {bias: 0.3, missed: 0.2}, missed: 0.1, bias: 0.1"
    wall = "walls: [{points: [[2, -1], [2, 1]]}]\n"
    free, blocked = readings(tagged(keys, world=OPEN), 40), readings(tagged(keys, world=wall + OPEN), 40)
    for name in ("left", "behind"):
        assert [reading.get(name) for reading in free] == [reading.get(name) for reading in blocked]
    assert any(reading.get("low") != other.get("low") for reading, other in zip(free, blocked, strict=True))
    with tagged(keys) as all_asked, tagged(keys) as few_asked:
        for tick in range(60):
            seen = all_asked.sense("r").ranges
            if tick % 6 == 0:
                assert few_asked.sense("r").ranges == seen
            all_asked.step()
            few_asked.step()


def test_a_late_reading_is_of_the_place_where_it_was_taken():
    with tagged(", rate_hz: 5, latency: 3") as late, tagged(", rate_hz: 25") as now:
        told, then = [], {}
        for _ in range(40):
            for sim in (late, now):
                sim.apply("r", Command(0.5, 0.0, 0.3))
                sim.step()
            seen = late.sense("r")
            then[round(now.time, 6)] = now.sense("r").ranges["tag"].ranges
            told += [(seen.time, reading) for reading in seen.ranges.values()]
        assert [round(time - reading.stamp, 6) for time, reading in told] == [0.12] * 8
        for _, reading in told[1:]:
            assert reading.ranges == then[round(reading.stamp, 6)]


def test_the_data_sheet_tells_what_a_sheet_would_and_modules_know_where_anchors_are_from_the_map_alone():
    with tagged(", at: [0.1, 0, 0.4], noise: {range: 0.1}, bias: 0.05, nlos: {bias: 1}, range: [0, 30]") as sim:
        info = sim.robots["r"].sensors["tag"]
        assert (info.kind, dict(info.noise), info.range, info.fov) == (
            "uwb",
            {"range": 0.1, "bias": 0.05},
            (0, 30),
            None,
        )
        assert info.robot_from_sensor[:3, 3].tolist() == [0.1, 0, 0.4]
        assert sim.sense("r").ranges["tag"].variance == pytest.approx(0.01)
        assert {beacon.pose for beacon in sim.catalogue.values()} == {None}
    known = parse_world(f"mjsim: 1\n{OPEN}\nrun: {{map: known}}\n")
    with Simulation(known) as sim:
        places = {n: (b.pose.x, b.pose.y, b.center) for n, b in sim.catalogue.items() if b.anchor}
        assert places == ANCHORS


def test_noise_may_change_while_it_runs():
    before = tagged(", noise: {range: 0.1}")
    after = tagged(", noise: {range: 0.5}, nlos: {bias: 0.2}, missed: 0.3").world
    with before as sim:
        sim.retune(after)
        told = [sim.sense("r").ranges["tag"]]
        assert told[0].variance == 0.25


class Heard:
    """An estimator whose covariance tells of the ranges that it was given."""

    def start(self, robot, catalogue, rng):
        self._sum = 0.0

    def update(self, seen):
        self._sum += sum(sum(reading.ranges.values()) for reading in seen.ranges.values())
        return mjsim.Estimate(pose=mjsim.Pose(0.0, 0.0, 0.0), covariance=np.eye(3) * (1.0 + self._sum))


class Ahead:
    def start(self, robot, map, rng):
        pass

    def command(self, seen, belief):
        return Command(0.4, 0.0, 0.3)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "run.mcap"
    with tagged(", noise: {range: 0.1}, missed: 0.4, latency: 1") as sim:
        driver = mjsim.Driver(estimator=Heard(), navigator=Ahead())
        return mjsim.run(sim, drivers={"r": driver}, seconds=3, record=path)


def test_ranges_are_recorded_exactly_and_left_out_where_there_are_none(run):
    given = []
    with Simulation(run.world, seed=run.seed) as sim:
        for _ in run.time:
            given.append(dict(sim.sense("r").ranges))
            sim.apply("r", Command(0.4, 0.0, 0.3))
            sim.step()
    assert [dict(seen.ranges) for seen in run.observations("r")] == given
    assert any(len(reading["tag"].ranges) < 3 for reading in given if reading)
    messages = [json.loads(data) for data in run.messages("/r/observation")]
    assert ["ranges" in message for message in messages[:4]] == [False, True, False, True]


def test_a_replay_is_given_the_same_ranges(run):
    again = mjsim.replay(run, robot="r", estimator=Heard())
    np.testing.assert_array_equal(again.robots["r"].covariance, run.robots["r"].covariance)
    assert run.robots["r"].covariance[-1, 0, 0] > 100


def test_ranges_are_exported_as_a_table_and_as_arrays(run, tmp_path):
    from scipy.io import loadmat

    given = [(seen.time, seen.ranges["tag"]) for seen in run.observations("r") if seen.ranges]
    export_csv(run, tmp_path)
    with (tmp_path / "r_ranges_tag.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(given)
    for row, (time, reading) in zip(rows, given, strict=True):
        assert (float(row["time"]), float(row["stamp"])) == (time, reading.stamp)
        assert {name: float(row[f"range_{name}"]) for name in ANCHORS if row[f"range_{name}"]} == reading.ranges
    with np.load(export_npz(run, tmp_path / "run.npz")) as arrays:
        names, ranges = arrays["r/ranges_tag/anchors"].tolist(), arrays["r/ranges_tag/ranges"]
    assert sorted(names) == sorted(ANCHORS)
    told = [{name: value for name, value in zip(names, row, strict=True) if value == value} for row in ranges.tolist()]
    assert told == [reading.ranges for _, reading in given]
    matlab = loadmat(export_mat(run, tmp_path / "run.mat"))["robots"]["r"][0, 0]["ranges_tag"][0, 0]
    np.testing.assert_array_equal(matlab["ranges"][0, 0], ranges)


def test_an_environment_observes_the_newest_ranges_in_the_order_of_the_world():
    world = tagged(", nlos: {missed: 1}", world="walls: [{points: [[2, -1], [2, 1]]}]\n" + OPEN).world
    env = GymEnvironment(Task(world=world, robots="r", observations=["tag"], seconds=1))
    seen, _ = env.reset(seed=1)
    assert env.observation_space.contains(seen)
    assert seen["tag"][0] == 40.0  # not heard
    assert seen["tag"][1] == pytest.approx(math.dist((0, 0, 0.3), ANCHORS["left"]), abs=1e-3)
    env.close()


def test_a_world_without_anchors_gives_empty_readings():
    assert readings(tagged(world=""), 3) == [{}, {}, {}]
