"""What a sweep consists of, what travels with it, and how its runs become a table."""

import re

import numpy as np
import pytest
from scipy import stats

import mjsim
from mjsim.errors import UsageError
from mjsim.report import RunFigures, compare_tables, largest, mean_interval
from mjsim.sweep import SweepPlan, parse_seeds, parse_settings
from mjsim.sweep.bundle import bundle_of
from mjsim.sweep.seed_means import interval_of_mean
from mjsim.sweep.store import Store
from mjsim.sweep.sweep_table import parquet, rows_of

ROOM = """
mjsim: 1
include: [hall.yaml]
beacons: [{name: lion, image: lion.png, at: [5.9, 1], heading_deg: 180}]
robots: [{name: scout, at: [1, 1]}]
run: {drivers: {scout: {estimator: {use: "mine.py:Mine", weights: numbers.txt}}}}
"""


def test_seeds_are_ranges_without_their_end_and_single_numbers():
    assert parse_seeds("0:4") == (0, 1, 2, 3)
    assert parse_seeds("7, 1:3") == (7, 1, 2)


@pytest.mark.parametrize("text", ["", "a", "0:", "1-3", "-1", "0:99999999", "3:0", "1,4:4"])
def test_what_are_no_seeds_is_refused(text):
    with pytest.raises(UsageError, match="--seeds"):
        parse_seeds(text)


def test_settings_are_yaml_with_commas_between():
    settings = parse_settings(["run.seconds=1,2.5", "robots.scout.at=[1, 2],[3, 4]", "floor.texture=a.png,null"])
    assert settings == {
        "run.seconds": (1, 2.5),
        "robots.scout.at": ([1, 2], [3, 4]),
        "floor.texture": ("a.png", None),
    }


@pytest.mark.parametrize("texts", [["a"], ["a="], ["=1"], ["a=1", "a=2"], ["a=1,]"], ["a=*b"]])
def test_what_are_no_settings_is_refused(texts):
    with pytest.raises(UsageError, match="--set"):
        parse_settings(texts)


def test_values_of_settings_are_those_of_world_files():
    assert parse_settings(["a=2026-01-01,12:30", "b=no,0x1F"]) == {"a": ("2026-01-01", "12:30"), "b": ("no", 31)}


@pytest.mark.parametrize(("cases", "robots"), [(2, 1), (4, 1), (3, 2), (1, 3)])
def test_a_plan_knows_how_many_seeds_can_decide_before_it_runs(cases, robots):
    names = [f"r{number}" for number in range(robots)]
    told = SweepPlan(seeds=(1,), settings={"a": tuple(range(cases))}).too_few_seeds(names)
    needed = int(re.search(r"use at least (\d+)", told)[1])

    def verdicts(seeds):
        return compare_tables(
            RunFigures(
                label=str(case),
                seed=seed,
                robots={
                    name: {"position_error_m": {"mean": 1.0 + case + k + 0.01 * seed * (case + k + 1)}}
                    for k, name in enumerate(names)
                },
            )
            for case in range(cases)
            for seed in range(seeds)
        ).verdicts

    assert not SweepPlan(seeds=tuple(range(needed)), settings={"a": tuple(range(cases))}).too_few_seeds(names)
    assert SweepPlan(seeds=tuple(range(needed - 1)), settings={"a": tuple(range(cases))}).too_few_seeds(names)
    assert verdicts(needed)
    assert not verdicts(needed - 1)


def test_a_single_case_of_one_robot_has_nothing_to_decide():
    assert SweepPlan(seeds=(1,), settings={}).too_few_seeds(["r"]) is None


def test_a_plan_is_every_combination_of_settings_with_every_seed():
    plan = SweepPlan(seeds=(3, 5), settings={"a": (1, 2), "b": ("x",)})
    assert [(job.case, job.seed, job.settings) for job in plan.jobs()] == [
        (0, 3, ("a=1", 'b="x"')),
        (0, 5, ("a=1", 'b="x"')),
        (1, 3, ("a=2", 'b="x"')),
        (1, 5, ("a=2", 'b="x"')),
    ]
    assert len(plan) == 4
    assert len({job.name for job in plan.jobs()}) == 4


def test_a_seed_or_a_value_that_is_given_twice_is_refused():
    with pytest.raises(UsageError, match="seed 3 is given twice"):
        SweepPlan(seeds=(3, 3), settings={})
    with pytest.raises(UsageError, match="value of a 1 is given twice"):
        SweepPlan(seeds=(3,), settings={"a": (1, 1)})


@pytest.fixture
def room(tmp_path):
    """A world whose modules import others."""
    folder = tmp_path / "home"
    (folder / "tools" / "deep").mkdir(parents=True)
    files = {
        "room.yaml": ROOM,
        "hall.yaml": "walls: [{points: [[0, 0], [6, 0], [6, 4]]}]\n",
        "mine.py": "import helper, json, numpy, tools.deep.saw\nTABLE = 'table.csv'\nclass Mine: ...\n",
        "helper.py": "from further import thing\n",
        "further.py": "thing = 1\n",
        "tools/__init__.py": "",
        "tools/deep/saw.py": "from .. import deep\n",
        "table.csv": "1,2\n",
        "numbers.txt": "3\n",
        "other.py": "nobody = 'imports this'\n",
    }
    for name, text in files.items():
        (folder / name).write_text(text)
    import cv2

    cv2.imwrite(str(folder / "lion.png"), np.zeros((8, 8, 3), np.uint8))
    return folder


def test_the_world_travels_with_all_that_it_and_its_modules_name(room, tmp_path):
    world = mjsim.load_world(room / "room.yaml")
    bundle = bundle_of(world, [])
    assert set(bundle.files) == {path.relative_to(room).as_posix() for path in room.rglob("*.*")} - {"other.py"}
    there = mjsim.load_world(bundle.unpack(tmp_path / "there"))
    assert there == world
    assert there.read_asset("lion.png") == (room / "lion.png").read_bytes()


def test_a_package_of_the_users_own_travels_wherever_it_stands(room, tmp_path, monkeypatch):
    (tmp_path / "elsewhere" / "sextant").mkdir(parents=True)
    (tmp_path / "elsewhere" / "sextant" / "__init__.py").write_text("class Sextant: ...\n")
    monkeypatch.syspath_prepend(tmp_path / "elsewhere")
    text = ROOM.replace("mine.py:Mine", "sextant:Sextant")
    world = mjsim.parse_world(text, source=mjsim.load_world(room / "room.yaml").source)
    assert bundle_of(world, []).files["modules/sextant/__init__.py"] == b"class Sextant: ...\n"


def test_a_folder_that_holds_another_sweep_is_refused_and_the_difference_named(room, tmp_path):
    world, store = mjsim.load_world(room / "room.yaml"), Store(tmp_path / "out", keep=False)
    plan = SweepPlan(seeds=(1, 2), settings={"run.seconds": (1, 2)})
    store.open(plan, bundle_of(world, []))
    store.open(plan, bundle_of(world, []))
    others = {
        "seeds was [1, 2] and is [1]": SweepPlan(seeds=(1,), settings=plan.settings),
        'set was [["run.seconds", 1, 2]] and is []': SweepPlan(seeds=(1, 2), settings={}),
        "seconds was not given and is 3.0": SweepPlan(seeds=(1, 2), settings=plan.settings, seconds=3.0),
    }
    for difference, other in others.items():
        with pytest.raises(UsageError) as caught:
            store.open(other, bundle_of(world, []))
        assert str(caught.value) == f"'{tmp_path / 'out'}' holds another sweep: {difference}; name another folder"
    (room / "further.py").write_text("thing = 2\n")
    with pytest.raises(UsageError, match=r"holds another sweep: further\.py has changed"):
        store.open(plan, bundle_of(world, []))


def test_a_folder_that_holds_something_else_is_left_alone(room, tmp_path):
    (tmp_path / "photos").mkdir()
    (tmp_path / "photos" / "cat.jpg").write_bytes(b"")
    with pytest.raises(UsageError, match="contains files that do not belong to a sweep"):
        Store(tmp_path / "photos", keep=False).open(
            SweepPlan(seeds=(1,), settings={}), bundle_of(mjsim.load_world(room / "room.yaml"), [])
        )
    assert [path.name for path in (tmp_path / "photos").iterdir()] == ["cat.jpg"]


@pytest.mark.slow
def test_an_invalid_address_is_refused_before_anything_is_sent(room, tmp_path):
    with pytest.raises(UsageError, match=r"^'nonsense' is not the address of a Dask scheduler; write it as tcp://"):
        mjsim.sweep(room / "room.yaml", seeds=[0], folder=tmp_path / "out", dask="nonsense")


def test_values_of_arrays_are_taken_and_a_text_in_place_of_a_list_is_refused(room, tmp_path):
    with pytest.raises(UsageError, match=r"the values of 'run\.rate_hz' are the text '25'; give them as a list"):
        mjsim.sweep(room / "room.yaml", seeds=[0], folder=tmp_path, settings={"run.rate_hz": "25"})
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "else").touch()
    rates = {"run.rate_hz": np.array([25, 50])}
    # The seeds and the values were understood by then.
    with pytest.raises(UsageError, match="contains files that do not belong to a sweep"):
        mjsim.sweep(room / "room.yaml", seeds=np.arange(2), folder=tmp_path / "out", settings=rates)


def test_two_sweeps_at_once_do_not_share_a_folder(room, tmp_path):
    with (
        Store(tmp_path / "out", keep=False).held(),
        pytest.raises(
            UsageError, match=r"^another sweep is running in '.*out'; wait for its end, or name another folder$"
        ),
    ):
        mjsim.sweep(room / "room.yaml", seeds=[0], folder=tmp_path / "out")
    assert list((tmp_path / "out").iterdir()) == []


def test_the_interval_of_a_mean_is_students_of_few_runs_and_the_bootstrap_of_comparisons_of_more():
    values = np.random.default_rng(0).gamma(2.0, size=11)
    expected = stats.ttest_1samp(values[:5], 0.0).confidence_interval(0.95)
    assert interval_of_mean(values[:5]) == pytest.approx((expected.low, expected.high), rel=1e-12)
    assert interval_of_mean(values) == mean_interval(values)
    assert interval_of_mean(values[:1]) is None


def test_no_interval_holds_what_a_figure_cannot_be():
    assert stats.ttest_1samp([0.1, 0.1, 1.0], 0.0).confidence_interval(0.95).low < -0.8
    assert interval_of_mean(np.array([0.1, 0.1, 1.0]))[0] == 0.0
    assert interval_of_mean(np.array([0.9, 0.9, 1.0]), upper=largest("nees.in_band"))[1] == 1.0
    assert interval_of_mean(np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0]))[0] >= 0.0


def outcome(case, seed, error=None, **figures):
    robots = {} if error else {"scout": figures}
    return {"case": case, "seed": seed, "error": error, "run": {"sim_seconds": 2.0}, "robots": robots, "series": {}}


@pytest.mark.slow
def test_rows_have_the_settings_and_all_figures_and_the_table_is_read_back_by_pyarrow():
    from io import BytesIO

    from pyarrow import parquet as pq

    plan = SweepPlan(seeds=(1, 2), settings={"odd": (0.5, "never")})
    outcomes = [
        outcome(0, 1, bumps=2, nees={"mean": 3.5}, landmark_error_m={"each": {"a": 1.0}}),
        outcome(0, 2, bumps=0, nees={"mean": None}),
        outcome(1, 1, error="it fell over"),
        outcome(1, 2, bumps=1, nees={"mean": 1}),
    ]
    rows = rows_of(plan, outcomes, ["scout"])
    assert rows[0] == {
        "case": 0, "seed": 1, "odd": 0.5, "robot": "scout", "error": None,
        "sim_seconds": 2.0, "bumps": 2, "nees.mean": 3.5,
    }  # fmt: skip
    assert rows[2]["error"] == "it fell over"
    assert rows[2]["bumps"] is None
    data = parquet(rows)
    assert data == parquet(rows_of(plan, outcomes, ["scout"]))
    table = pq.read_table(BytesIO(data)).to_pydict()
    assert table["bumps"] == [2, 0, None, 1]
    assert table["nees.mean"] == [3.5, None, None, 1.0]
    assert table["odd"] == ["0.5", "0.5", "never", "never"]
