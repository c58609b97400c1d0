"""Evaluations of the experiments on recordings that are made up, the page, and the plots as numbers."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from mjsim.errors import UsageError
from mjsim.experiments import classic, experiment_plots, run_experiments
from mjsim.experiments.experiment_page import lines, number, write_page
from mjsim.experiments.finding import Plot, Result, at_least, at_most, exactly, within
from mjsim.experiments.offline import Fixes, _bearing_error, _position
from mjsim.interface import Sighting
from mjsim.record import Landmarks, RobotEvent, Track
from mjsim.world import parse_world

N, DT = 121, 0.1
WORLD = parse_world("""mjsim: 1
walls: [{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true}]
beacons: [{name: a, at: [5.9, 1]}, {name: b, at: [0.1, 3]}]
robots: [{name: scout, at: [1, 1]}]
""")
RADIUS = WORLD.robots[0].body.radius
HALF = WORLD.walls[0].thickness / 2


@pytest.fixture
def drawn(monkeypatch):
    """The figures that were drawn, in order; as files they are empty."""
    found = []
    monkeypatch.setattr(experiment_plots, "png_of", lambda figure: found.append(figure) or b"")
    return found


def recording(truth, *, estimate=None, events=(), mean=None, sightings=None):
    truth = np.asarray(truth, dtype=float)
    n = len(truth)
    mean = np.full((1, 2, 2), np.nan) if mean is None else mean
    track = Track(
        time=DT * np.arange(n),
        truth=truth,
        truth_pose=np.zeros((n, 7)),
        odometry=truth + np.array([0.3, 0.4, 0.0]),
        odometry_covariance=np.zeros((n, 3, 3)),
        estimate=truth + np.array([0.03, 0.04, 0.01]) if estimate is None else estimate,
        covariance=np.tile(np.diag([0.01, 0.01, 0.0025]), (n, 1, 1)),
        command=np.zeros((n, 3)),
        landmarks=Landmarks(names=("a", "b"), mean=mean, covariance=np.tile(0.01 * np.eye(2), (1, 2, 1, 1))),
        sightings=tuple((sightings or {}).get(row, ()) for row in range(n)),
        innovations=((),) * n,
        events=tuple(RobotEvent(kind=kind, time=time, text="") for kind, time in events),
    )
    return SimpleNamespace(world=WORLD, robots={"scout": track}, time=track.time)


def sight(distance, bearing):
    return Sighting(stamp=0.0, name=None, range=distance, bearing=bearing, covariance=np.eye(2))


def into_the_wall(*, depth=0.0, after=0.0, wriggle=0.1):
    """Return poses that drive to the eastern wall in 5 s, and wriggle there."""
    time = DT * np.arange(N)
    end = 6.0 - HALF - RADIUS + depth
    x = np.where(time < 5.0, 1.0 + (end - 1.0) * time / 5.0, end)
    y = 2.0 + np.where(time > 8.0, after, 0.0)
    return np.column_stack([x, y, np.where(time > 6.0, wriggle * np.sin(3 * time), 0.0)])


def values(result):
    return [finding.value for finding in result.findings]


def verdicts(result):
    return [finding.holds for finding in result.findings]


def test_a_bump_is_judged_by_its_number_way_turn_and_depth(drawn):
    poses = into_the_wall(depth=0.004, after=0.03)
    result = classic.bump(recording(poses, events=[("other", 1.0), ("bump", 5.0), ("bump", 7.0)]))
    turned = np.degrees(np.ptp(0.1 * np.sin(3 * DT * np.arange(61, N))))
    assert values(result) == pytest.approx([2, 0.03, turned, 0.004], abs=1e-9)
    assert result.holds
    assert [plot.name for plot in result.pictures] == ["bump_path", "bump_motion"]
    above, below = drawn[1].axes
    assert [list(axes.lines[-1].get_xdata()) for axes in (above, below)] == [[5.0, 5.0]] * 2
    first = above.lines[0]
    assert first.get_ydata()[0] == pytest.approx((6.0 - HALF - RADIUS + 0.004 - 1.0) / 5.0)
    assert first.get_xdata()[0] == pytest.approx(DT)
    np.testing.assert_allclose(below.lines[0].get_ydata(), np.degrees(poses[:, 2]))
    assert (above.get_ylabel(), below.get_ylabel(), below.get_xlabel()) == ("speed [m/s]", "heading [deg]", "time [s]")


@pytest.mark.parametrize(
    ("changed", "failing"),
    [
        ({"depth": 0.006}, [3]),
        ({"after": 0.06}, [1]),
        ({"wriggle": 0.005}, [2]),
        ({"depth": -0.5}, []),
    ],
)
def test_what_a_robot_must_not_do_at_a_wall_fails(drawn, changed, failing):
    result = classic.bump(recording(into_the_wall(**changed), events=[("bump", 5.0)]))
    assert [number for number, holds in enumerate(verdicts(result)) if not holds] == failing
    assert result.holds == (not failing)
    assert result.findings[3].value == pytest.approx(max(0.0, changed.get("depth", 0.0)), abs=1e-9)


def test_without_a_bump_nothing_holds_but_the_depth(drawn):
    assert verdicts(classic.bump(recording(into_the_wall()))) == [False, False, False, True]


def walks(scale=1.0, *, runs=20, rows=200):
    """Return random walks with the covariance that they have, times a factor."""
    rng = np.random.default_rng(2)
    steps = rng.normal(size=(runs, rows, 3)) * 0.01
    honest = 1e-4 * np.arange(1, rows + 1)[None, :, None, None] * np.eye(3) * np.ones((runs, 1, 1, 1))
    return np.zeros((runs, rows, 3)), np.cumsum(steps, axis=1), scale * honest


def test_dead_reckoning_is_judged_by_growth_and_consistency(drawn):
    run = recording(np.zeros((200, 3)))
    truth, estimate, P = walks()
    result = classic.odometry(run, (truth, estimate, P))
    assert verdicts(result) == [True] * 4
    rms = np.sqrt((estimate[..., 0] ** 2 + estimate[..., 1] ** 2).mean(axis=0))
    assert values(result)[:3] == pytest.approx([rms[-1] / rms[50], np.sqrt(200 / 51), rms[-1] / np.sqrt(2e-4 * 200)])
    low, high = stats.chi2.ppf((0.025, 0.975), 60) / 20
    nees = ((estimate**2).sum(axis=-1) / (1e-4 * np.arange(1, 201))).mean(axis=0)
    inside = (nees[10:] >= low) & (nees[10:] <= high)
    assert values(result)[3] == pytest.approx(inside.mean())
    assert verdicts(classic.odometry(run, walks(0.5))) == [True, True, False, False]
    assert verdicts(classic.odometry(run, walks(2.5))) == [True, True, False, False]
    still = classic.odometry(run, (truth, np.full_like(truth, 0.01), np.full_like(P, 0.0) + 1e-4 * np.eye(3)))
    assert verdicts(still)[:2] == [False, False]
    above, below = drawn[1].axes
    labels = {line.get_label(): line for line in above.lines}
    np.testing.assert_allclose(labels["root mean square of the runs"].get_ydata(), rms)
    np.testing.assert_allclose(labels["predicted"].get_ydata(), np.sqrt(2e-4 * np.arange(1, 201)))
    np.testing.assert_allclose(above.lines[3].get_ydata(), np.hypot(estimate[3, :, 0], estimate[3, :, 1]))
    mean = {line.get_label(): line for line in below.lines}["NEES, mean of 20 runs"]
    np.testing.assert_allclose(mean.get_ydata(), nees[1:])
    np.testing.assert_allclose(mean.get_xdata(), DT * np.arange(1, 200))
    assert (below.patches[0].get_y(), below.patches[0].get_height()) == pytest.approx((low, high - low))
    assert above.get_ylim()[0] == 0.0
    assert below.get_ylim() == pytest.approx((0.0, 2 * high))


def tour(corners):
    """Return poses that visit points in the room in 11 minutes."""
    points = np.repeat(np.array(corners, dtype=float), 2, axis=0)
    poses = np.column_stack([points, np.zeros(len(points))])
    run = recording(poses)
    track = replace(run.robots["scout"], time=np.linspace(0.0, 660.0, len(poses)))
    return SimpleNamespace(world=WORLD, robots={"scout": track}, time=track.time)


CORNERS = [(0.68, 0.68), (5.32, 0.68), (5.32, 3.32), (0.68, 3.32)]
"""Within a radius of the square in each corner."""


@pytest.mark.parametrize("bumps", [0, 1])
def test_avoidance_is_judged_by_time_bumps_corners_and_coverage(drawn, monkeypatch, bumps):
    monkeypatch.setattr(
        classic, "statistics", lambda _: {"scout": {"bumps": bumps, "coverage": 0.8, "coverage_area": 0.7}}
    )
    for missing in range(4):
        reached = [corner for k, corner in enumerate(CORNERS) if k != missing]
        result = classic.avoidance(tour([(3, 2), *reached[:1], (3, 2), *reached[1:2], (3, 2), *reached[2:], (3, 2)]))
        assert values(result)[2] == 3
    beside = HALF + classic.CORNER_SIDE + RADIUS + 0.01
    assert values(classic.avoidance(tour([(beside, beside), (6 - beside, 4 - beside)])))[2] == 0
    result = classic.avoidance(tour(CORNERS))
    assert values(result) == pytest.approx([11.0, bumps, 4, 0.8, 0.7])
    assert result.holds == (not bumps)
    (axes,) = drawn[-1].axes
    labels = {line.get_label(): line for line in axes.lines}
    assert np.ravel(labels["start"].get_data()).tolist() == [0.68, 0.68]
    assert np.ravel(labels["end"].get_data()).tolist() == [0.68, 3.32]
    swept = next(patch for patch in axes.patches if patch.get_label() == "floor covered")
    box = swept.get_path().get_extents()
    assert box.extents == pytest.approx([0.68 - RADIUS, 0.68 - RADIUS, 5.32 + RADIUS, 3.32 + RADIUS], abs=0.01)


def circle(n=N):
    time = np.linspace(0.0, 2 * np.pi, n)
    return np.column_stack([3 + 2 * np.cos(time), 2 + np.sin(time), time])


def test_slam_is_judged_by_its_errors_those_of_the_last_lap_and_its_map(drawn, monkeypatch):
    figures = {"landmark_error_m": {"count": 2, "aligned_rms": 0.04}}
    monkeypatch.setattr(classic, "statistics", lambda _: {"scout": figures})
    truth = circle()
    offset = np.where(np.arange(N) > 80, 0.05, 0.1)[:, None] * [1.0, 0.0, 0.0]
    seen = {20: (sight(0.1, 0.0),) * 2, 85: (sight(0.3, 0.0),), 100: (sight(1.0, 0.5), sight(1.5, -0.5))}
    mean = np.array([[[5.9, 1.1], [0.1, 3.0]]])
    run = recording(truth, estimate=truth + offset, mean=mean, sightings=seen | {90: (sight(2.0, 0.0),) * 2})
    result = classic.slam(run)
    assert values(result) == pytest.approx([(81 * 0.1 + 40 * 0.05) / 121, 0.05 / 0.5, 2, 0.04])
    assert result.holds
    far = classic.slam(
        recording(truth, estimate=truth + np.array([0.12, 0.0, 0.0]), mean=run.robots["scout"].landmarks.mean)
    )
    assert verdicts(far) == [False, True, True, True]
    figures["landmark_error_m"] = {"count": 1, "aligned_rms": 0.06}
    assert verdicts(classic.slam(run)) == [True, True, False, False]
    assert [plot.name for plot in result.pictures] == ["slam_path", "slam_enlarged", "slam_transient"]
    whole, enlarged, transient = drawn[:3]
    labels = {line.get_label(): line for line in whole.axes[0].lines}
    np.testing.assert_array_equal(np.column_stack(labels["estimate"].get_data()), (truth + offset)[:, :2])
    assert "landmarks" in labels
    assert len(whole.axes[0].collections[-2].get_paths()) == 30
    # Of the last third, which has rows 85, 90 and 100, row 100 sees two beacons most closely.
    (axes,) = enlarged.axes
    x, y, heading = (truth + offset)[100]
    ends = [[x + r * np.cos(heading + b), y + r * np.sin(heading + b)] for r, b in ((1.0, 0.5), (1.5, -0.5))]
    sights, of_map, of_robot = (each for each in axes.collections if each.get_zorder() > 0.9)
    np.testing.assert_allclose([line[1] for line in sights.get_segments()], ends)
    np.testing.assert_allclose([line[0] for line in sights.get_segments()], [[x, y]] * 2)
    assert np.clip(ends, *np.transpose([axes.get_xlim(), axes.get_ylim()])) == pytest.approx(np.array(ends))
    # An ellipse larger than the robot stays as it is.
    wide = [np.ptp(each.get_paths()[0].vertices[:, 0]) for each in (of_map, of_robot)]
    assert wide == pytest.approx([2 * 0.1 * np.sqrt(stats.chi2.ppf(0.95, 2))] * 2, rel=0.01)
    assert result.pictures[1].caption.endswith("at 10.0 s, with 95 % ellipses, magnified 1 times")
    assert len(transient.axes) == 4
    assert transient.axes[3].get_ylabel() == "position error [m]"


def test_triangulation_is_judged_by_the_errors_of_its_positions(drawn, monkeypatch):
    truth = circle(100)[:, :2]
    off = np.tile([[0.03, 0.04], [0.0, 0.15]], (50, 1))
    found = Fixes(time=np.arange(100.0), position=truth + off, truth=truth, places=np.zeros((2, 2)), wrong=0)
    monkeypatch.setattr(classic, "triangulated", lambda *_: found)
    result = classic.triangulation(recording(circle()))
    assert values(result) == pytest.approx([100, 0.1, 0.15, 0])
    assert verdicts(result) == [True, result.findings[1].value <= 0.1, True, True]
    worse = replace(found, position=truth + 4 * off, wrong=1)
    monkeypatch.setattr(classic, "triangulated", lambda *_: worse)
    assert verdicts(classic.triangulation(recording(circle()))) == [True, False, False, False]
    (plan,), (errors,) = drawn[0].axes, drawn[1].axes
    assert {line.get_label() for line in plan.lines} >= {"true path", "triangulated"}
    pairs = np.array(plan.collections[-1].get_segments())
    np.testing.assert_allclose(pairs, np.stack([truth, truth + off], axis=1))
    np.testing.assert_allclose(errors.lines[0].get_ydata(), np.tile([5.0, 15.0], 50))
    assert errors.lines[1].get_label() == "mean, 10.00 cm"
    assert list(errors.lines[1].get_ydata()) == pytest.approx([10.0, 10.0])
    assert (errors.get_xlabel(), errors.get_ylabel(), errors.get_yscale()) == ("time [s]", "error [cm]", "log")


PLACES = {"a": np.array([4.0, 1.0]), "b": np.array([0.0, 3.0]), "c": np.array([-3.0, -2.0])}


def sighting(name, pose, *, bearing_std=0.002):
    x, y = PLACES[name] - pose[:2]
    return Sighting(
        stamp=0.0, name=name, range=float(np.hypot(x, y)), bearing=float(np.arctan2(y, x) - pose[2]),
        covariance=np.diag([0.01, bearing_std**2]),
    )  # fmt: skip


def test_a_position_is_where_three_bearings_were_taken():
    pose = np.array([0.5, -0.3, 0.4])
    three = tuple(sighting(name, pose) for name in PLACES)
    assert _position(three, PLACES) == pytest.approx(pose[:2], abs=1e-6)
    assert _position(three[:2], PLACES) is None
    assert _position(tuple(sighting(name, pose, bearing_std=0.2) for name in PLACES), PLACES) is None


def test_a_bearing_error_is_never_a_whole_turn():
    pose = np.array([0.5, -0.3, 6.0])
    seen = sighting("a", pose)
    assert _bearing_error(seen, pose, PLACES["a"]) == pytest.approx(0.0, abs=1e-12)
    for off in (0.3, -0.3, 2 * np.pi - 0.3):
        assert _bearing_error(replace(seen, bearing=seen.bearing + off), pose, PLACES["a"]) == pytest.approx(0.3)


@pytest.mark.parametrize(
    ("make", "value", "holds", "wanted"),
    [
        (lambda v: at_least("w", v, 2), 2.0, True, "at least 2"),
        (lambda v: at_least("w", v, 2), 1.9, False, "at least 2"),
        (lambda v: at_most("w", v, 0.05), 0.05, True, "at most 0.05"),
        (lambda v: at_most("w", v, 0.05), 0.051, False, "at most 0.05"),
        (lambda v: exactly("w", v, 4), 4, True, "4"),
        (lambda v: exactly("w", v, 4), 5, False, "4"),
        (lambda v: exactly("w", v, 4), 3, False, "4"),
        (lambda v: within("w", v, 0.7, 1.3), 0.7, True, "0.7 to 1.3"),
        (lambda v: within("w", v, 0.7, 1.3), 1.3, True, "0.7 to 1.3"),
        (lambda v: within("w", v, 0.7, 1.3), 0.69, False, "0.7 to 1.3"),
        (lambda v: within("w", v, 0.7, 1.3), 1.31, False, "0.7 to 1.3"),
        (lambda v: at_least("w", v, 2), np.nan, False, "at least 2"),
    ],
)
def test_a_finding_holds_up_to_its_bound(make, value, holds, wanted):
    found = make(value)
    assert (found.what, found.holds, found.wanted) == ("w", holds, wanted)
    assert type(found.holds) is bool


def test_a_page_has_verdicts_numbers_and_pictures(tmp_path):
    good, bad = at_least("metres [m]", 2.0, 1), at_most("deviation", 0.12345, 0.1)
    plot = Plot(name="p", caption="A plot", png=b"1")
    results = [
        Result(name="x", title="1. X", question="Why?", findings=(good,), pictures=(plot,)),
        Result(name="y", title="2. Y", question="How?", findings=(good, bad), pictures=()),
    ]  # fmt: skip
    assert [number(each) for each in (good, bad)] == ["2", "0.123"]
    told = lines(results)
    assert told[0] == "1. X: holds"
    assert told[2] == "2. Y: does not hold"
    assert told[1].split() == ["metres", "[m]", "2", "at", "least", "1", "holds"]
    assert told[4].split() == ["deviation", "0.123", "at", "most", "0.1", "does", "not", "hold"]
    write_page(tmp_path, results)
    assert (tmp_path / "x" / "p.png").read_bytes() == b"1"
    page = (tmp_path / "index.html").read_text()
    facts = ("The classic experiments", "1. X", "Why?", "metres [m]", "at least 1", 'class="holds"', 'alt="A plot"')
    places = [page.find(fact) for fact in (*facts, 'src="x/p.png"', "2. Y", "0.123", 'class="fails"', "does not hold")]
    assert places == sorted(places)
    assert places[0] > 0
    assert json.loads((tmp_path / "results.json").read_text())["y"] == {
        "holds": False,
        "title": "2. Y",
        "question": "How?",
        "pictures": {},
        "findings": [
            {"what": "metres [m]", "value": 2.0, "wanted": "at least 1", "holds": True},
            {"what": "deviation", "value": 0.12345, "wanted": "at most 0.1", "holds": False},
        ],
    }
    with pytest.raises(UsageError, match=r"index\.html"):
        write_page(tmp_path, results)
    write_page(tmp_path, results, overwrite=True)


def test_files_of_an_earlier_time_are_kept_before_anything_runs(tmp_path):
    (tmp_path / "bump").mkdir()
    (tmp_path / "bump" / "run.mcap").write_text("kept")
    with pytest.raises(UsageError, match=r"run\.mcap"):
        run_experiments(tmp_path, only=["bump"])
    (tmp_path / "bump" / "run.mcap").unlink()
    (tmp_path / "results.json").write_text("kept")
    with pytest.raises(UsageError, match=r"results\.json"):
        run_experiments(tmp_path, only=["bump"])
    with pytest.raises(UsageError, match="no experiment 'slum'"):
        run_experiments(tmp_path, only=["slum"])


def test_an_interrupted_page_has_what_was_done_and_is_finished_by_the_same_command(tmp_path, monkeypatch):
    runs = []

    def recorded(name, path, progress, *, overwrite):
        runs.append(name)
        if runs == ["bump", "slam"]:
            raise KeyboardInterrupt
        return name

    def evaluated(name):
        plot = Plot(name="p", caption="A plot", png=name.encode())
        return Result(name=name, title=name, question="Why?", findings=(at_least("m", 2.0, 1),), pictures=(plot,))

    monkeypatch.setattr(classic, "recorded", recorded)
    monkeypatch.setattr(classic, "EXPERIMENTS", dict.fromkeys(["bump", "slam"], evaluated))
    with pytest.raises(KeyboardInterrupt):
        run_experiments(tmp_path)
    assert list(json.loads((tmp_path / "results.json").read_text())) == ["bump"]
    assert 'src="bump/p.png"' in (tmp_path / "index.html").read_text()
    assert run_experiments(tmp_path) == (evaluated("bump"), evaluated("slam"))
    assert runs == ["bump", "slam", "slam"]
    assert 'src="slam/p.png"' in (tmp_path / "index.html").read_text()
    run_experiments(tmp_path, overwrite=True)
    assert runs[3:] == ["bump", "slam"]


def test_each_experiment_has_its_evaluation(monkeypatch):
    asked = []
    monkeypatch.setattr(classic, "repeated", lambda world, runs: asked.append((world, runs)) or walks(rows=40))
    monkeypatch.setattr(experiment_plots, "png_of", lambda _: b"")
    run = recording(np.zeros((60, 3)))
    assert classic.EXPERIMENTS["odometry"](run).name == "odometry"
    assert asked == [(WORLD, 20)]
    assert list(classic.EXPERIMENTS) == ["bump", "odometry", "avoidance", "triangulation", "slam"]


def test_repeats_have_other_seeds_and_the_rows_of_one_run():
    world = parse_world("""mjsim: 1
walls: [{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true}]
robots: [{name: scout, at: [1, 1], odometry: {noise: {distance: 0.1, turn: 0.1}}}]
run:
  seconds: 0.2
  drivers: {scout: {navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[4, 1]]}}}
""")
    truth, estimate, P = classic.repeated(world, 2)
    ticks = round(0.2 * world.run.rate_hz)
    assert truth.shape == estimate.shape == (2, ticks, 3)
    assert P.shape == (2, ticks, 3, 3)
    assert truth[0, 0] == pytest.approx([1.0, 1.0, 0.0], abs=0.01)
    assert not np.array_equal(estimate[0], estimate[1])
