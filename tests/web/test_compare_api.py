"""What the page is told of recordings and sweeps that are compared: the same as `mjsim compare` says."""

import json
import math

import numpy as np
import pytest

import mjsim
from mjsim.bench.entering import client_of
from mjsim.report import compare, comparison_csv, mean_rows, metrics
from mjsim.web.review.comparing import compared_json
from mjsim.web.review.review_api import ReviewApi
from mjsim.web.server.server import Server
from mjsim.web.worlds.folder import Folder
from mjsim.web.worlds.world_files import listed

ROOM = """
mjsim: 1
name: room
walls: [{points: [[-2, -2], [2, -2], [2, 2], [-2, 2]], closed: true}]
robots: [{name: scout, preset: pioneer3dx, at: [0, 0], odometry: {noise: {distance: 0.05, turn: 0.1}}}]
run:
  seconds: 1
  drivers: {scout: {navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[1, 0]]}}}
"""
CLEAN = ROOM.replace("distance: 0.05, turn: 0.1", "distance: 0, turn: 0")
HALL = ROOM.replace("[2, 2], [-2, 2]", "[2, 3], [-2, 3]").replace("name: room", "name: hall")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with recordings of two settings, of another world, and what is none."""
    root = tmp_path_factory.mktemp("folder")
    for name, text, seed in (("noisy-1", ROOM, 1), ("noisy-2", ROOM, 2), ("clean-1", CLEAN, 1), ("hall-1", HALL, 1)):
        with mjsim.Simulation(mjsim.parse_world(text), seed=seed) as sim:
            mjsim.run(sim, record=root / f"{name}.mcap")
    (root / "none.mcap").write_bytes(b"nothing")
    (root / "swept").mkdir()
    (root / "swept" / "sweep.json").write_text("{}")
    return root


@pytest.fixture(scope="module")
def page(folder):
    api = ReviewApi(Folder(folder), scene=lambda world: {"items": [], "bounds": [-2.0, -2.0, 2.0, 2.0]})
    with Server(api.routes, closing=[api.close]) as server, client_of(server.url) as client:
        yield client


def ask(page, *paths):
    return page.get("/api/compare", params=[("path", path) for path in paths])


def test_the_page_is_told_what_the_command_says(page, folder):
    names = ("noisy-1.mcap", "noisy-2.mcap", "clean-1.mcap")
    answer = ask(page, *names)
    assert answer.status_code == 200, answer.text
    told, said = answer.json(), compare([folder / name for name in names])
    assert told["means"] == [list(row) for row in mean_rows(said)]
    assert told["know"] == [*said.consistency, *said.remarks]
    assert told["csv"] == comparison_csv(said)
    assert [group["label"] for group in told["groups"]] == [group.label for group in said.groups]
    assert [len(group["paths"]) for group in told["groups"]] == [2, 1]
    track = mjsim.read_recording(folder / "clean-1.mcap").robots["scout"]
    (path,), (errors,) = told["groups"][1]["paths"], told["groups"][1]["errors"]
    assert path["estimate"] == pytest.approx(track.estimate[:, :2], abs=1e-4)
    assert errors["values"] == pytest.approx(metrics.position_errors(track.truth, track.estimate), abs=1e-4)


def test_differences_are_called_as_the_means_are(page):
    told = ask(page, "noisy-1.mcap", "clean-1.mcap").json()
    titles = {each["figure"]: each["title"] for each in told["differences"]}
    assert titles["position_error_m.mean"] == "position error, mean"
    assert all(any(row[0].startswith(title) for row in told["means"]) for title in titles.values())


def test_other_worlds_are_a_one_line_error(page, folder):
    told = ask(page, "noisy-1.mcap", "hall-1.mcap").json()
    assert [group["label"] for group in told["groups"]] == ["room", "hall"]
    assert any("the worlds of these runs differ in walls" in line for line in told["know"])
    assert not [line for line in ask(page, "noisy-1.mcap", "clean-1.mcap").json()["know"] if "worlds" in line]


@pytest.mark.parametrize(
    ("paths", "status", "message"),
    [
        ([], 400, "0 recordings are chosen"),
        (["none.mcap", "clean-1.mcap"], 400, "'none.mcap' is not an MCAP file"),
        (["gone.mcap", "clean-1.mcap"], 404, "no file 'gone.mcap'"),
        (["swept", "clean-1.mcap"], 400, "the sweep in 'swept' cannot be read"),
        (["../clean-1.mcap"], 403, "is outside the folder"),
        ([f"{k}.mcap" for k in range(61)], 400, "choose 1 to 60"),
    ],
)
def test_what_cannot_be_compared_is_refused_in_one_line(page, folder, paths, status, message):
    answer = ask(page, *paths)
    assert (answer.status_code, message in answer.json()["error"]) == (status, True), answer.text
    assert str(folder) not in answer.text
    assert "\n" not in answer.json()["error"]


def test_folders_of_sweeps_are_listed(folder):
    found = listed(Folder(folder))
    assert found["sweeps"] == ["swept"]
    assert "clean-1.mcap" in found["recordings"]


def test_poses_that_are_not_known_are_gaps(folder):
    comparison = compare([folder / "clean-1.mcap"])
    series = comparison.groups[0].series[1]
    series.estimate[2] = math.nan
    series.position_error_m[2] = math.nan
    told = json.loads(json.dumps(compared_json(comparison, scene=None), allow_nan=False))
    (group,) = told["groups"]
    assert group["paths"][0]["estimate"][2] == [None, None]
    assert group["errors"][0]["values"][2] is None


def test_of_many_runs_the_median_is_drawn_and_the_paths_of_as_many_as_can_be_told_apart(tmp_path, monkeypatch):
    monkeypatch.setattr("mjsim.web.review.comparing.MAX_PATHS", 4)
    for seed in range(1, 6):
        with mjsim.Simulation(mjsim.parse_world(ROOM), seed=seed) as sim:
            mjsim.run(sim, seconds=0.2, record=tmp_path / f"run-{seed}.mcap")
    (group,) = compared_json(compare([tmp_path]), scene=None)["groups"]
    errors = [
        metrics.position_errors(track.truth, track.estimate)
        for track in (mjsim.read_recording(file).robots["scout"] for file in sorted(tmp_path.glob("*.mcap")))
    ]
    (line,) = group["errors"]
    assert line["values"] == pytest.approx(np.median(errors, axis=0), abs=1e-4)
    assert all(low <= high for low, high in zip(line["low"], line["high"], strict=True))
    assert (group["runs"], [path["seed"] for path in group["paths"]]) == (5, [1, 2, 3, 4])
