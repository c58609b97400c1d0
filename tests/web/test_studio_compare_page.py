"""Recordings compared in Review, in a real browser: chosen by ticks, drawn on one clock."""

import csv
import json
from xml.etree import ElementTree

import cv2
import pytest
from playwright.sync_api import expect

import mjsim
from mjsim.report import compare, comparison_csv, mean_rows
from mjsim.web import Studio
from tests.windows import PATIENCE, page_at

pytestmark = pytest.mark.slow
ROOM = """
mjsim: 1
name: room
walls: [{points: [[-2, -2], [2, -2], [2, 2], [-2, 2]], closed: true}]
robots: [{name: scout, preset: pioneer3dx, at: [0, 0], odometry: {noise: {distance: 0.05, turn: 0.1}}}]
run:
  seconds: 2
  drivers: {scout: {navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[1, 0]]}}}
"""
CLEAN = ROOM.replace("distance: 0.05, turn: 0.1", "distance: 0, turn: 0")


SEEDS = (1, 2)


@pytest.fixture
def folder(tmp_path):
    """A folder with recordings of two settings, one of them with two seeds, and a sweep."""
    place = tmp_path / "compared"
    place.mkdir()
    for name, text, seed in (("noisy", ROOM, 1), ("again", ROOM, 2), ("clean", CLEAN, 1)):
        with mjsim.Simulation(mjsim.parse_world(text), seed=seed) as sim:
            mjsim.run(sim, record=place / f"{name}.mcap")
    (place / "room.yaml").write_text(ROOM)
    settings = {"robots.scout.odometry.noise.turn": [0.02, 0.2]}
    mjsim.sweep(place / "room.yaml", seeds=SEEDS, folder=place / "swept", settings=settings, workers=1)
    return place


def tick(page, *names):
    """Tick these and no others."""
    ticked = page.locator("input[aria-label^='Compare ']:checked")
    while ticked.count():
        ticked.first.uncheck()
    for name in names:
        page.get_by_label(f"Compare {name}").check()


def each_run_of_a_kind_has_a_column_of_its_own_by_its_seed(page, folder, tmp_path):
    names = ("noisy.mcap", "again.mcap")
    tick(page, *names)
    page.get_by_role("button", name="Compare 2 chosen").click()
    chart = page.locator(".compare .run-chart", has_text="Position error")
    label = page.locator(".compare-legend b").inner_text()
    rows = list(csv.reader(kept(page, chart, "CSV", tmp_path).read_text().splitlines()))
    assert rows[0] == ["time [s]", f"{label}, seed 1", f"{label}, seed 2"]
    group = compare([folder / name for name in names]).groups[0]
    errors = [group.series[seed].position_error_m[26] for seed in SEEDS]
    assert [float(value) for value in rows[27]] == pytest.approx([1.04, *errors], abs=1e-4)
    page.keyboard.press("Escape")


def a_sweep_shows_the_paths_of_its_runs_on_the_plan_of_its_world(page, folder, tmp_path):
    tick(page, "swept")
    page.get_by_role("button", name="Compare 1 chosen").click()
    tile = page.locator(".compare .run-tile")
    rows = list(csv.reader(kept(page, tile, "CSV", tmp_path).read_text().splitlines()))[1:]
    assert {(label, seed) for label, seed, *_ in rows} == {
        (f"noise.turn={turn}", str(seed)) for turn in (0.02, 0.2) for seed in SEEDS
    }
    drawn = ElementTree.fromstring(kept(page, tile, "SVG", tmp_path).read_bytes())
    paths = [each.get("d") for each in drawn.iter("{http://www.w3.org/2000/svg}path")]
    assert len([path for path in paths if path.endswith("Z")]) >= 4  # the walls of the room
    assert len([path for path in paths if "L" in path and not path.endswith("Z")]) >= 2 * 2 * len(SEEDS)
    assert cv2.imread(str(kept(page, tile, "PNG", tmp_path))).size > 0
    expect(page.locator(".compare .run-chart-box[data-empty^='No estimator']")).to_be_visible()
    expect(page.locator(".compare-no-plan")).to_be_hidden()

    # A sweep of an earlier version kept no paths: the plan says so, and the figures are there.
    for file in (folder / "swept" / "runs").glob("*.json"):
        outcome = json.loads(file.read_text())
        for series in outcome["series"].values():
            for key in [key for key in series if key.endswith(("_x_m", "_y_m"))]:
                del series[key]
        file.write_text(json.dumps(outcome))
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Compare 1 chosen").click()
    expect(page.locator(".compare-no-plan")).to_contain_text("No paths to draw")
    expect(page.locator(".compare-legend li")).to_have_count(2)
    page.keyboard.press("Escape")


def kept(page, chart, kind, folder):
    """Return the file that the menu of a chart gives."""
    chart.get_by_label("Save as a file").click()
    with page.expect_download(timeout=PATIENCE) as download:
        chart.get_by_role("button", name=kind).click()
    download.value.save_as(folder / download.value.suggested_filename)
    return folder / download.value.suggested_filename


def recordings_are_compared_on_one_clock(page, folder, tmp_path):
    said = compare([folder / "clean.mcap", folder / "noisy.mcap"])
    tick(page)
    choose = page.get_by_role("button", name="Compare: tick two or more")
    page.get_by_label("Compare clean.mcap").check()
    expect(choose).to_be_disabled()
    page.get_by_label("Compare noisy.mcap").check()
    page.get_by_role("button", name="Compare 2 chosen").click()

    for row in mean_rows(said):
        shown = page.locator(".compare-means tbody tr", has=page.get_by_role("rowheader", name=row[0], exact=True))
        expect(shown.locator("td")).to_have_text(list(row[1:]))
    expect(page.locator(".compare-legend b")).to_have_text([group.label for group in said.groups])
    with page.expect_download(timeout=PATIENCE) as download:
        page.locator(".compare-figures").get_by_role("button", name="Save CSV").click()
    download.value.save_as(tmp_path / "figures.csv")
    assert (tmp_path / "figures.csv").read_text() == comparison_csv(said)

    page.keyboard.press("ArrowRight")
    page.keyboard.press(".")
    expect(page.locator(".compare .run-time")).to_have_text("1.04 s of 1.96 s")
    read = page.locator(".compare .run-chart", has_text="Position error").locator("output")
    errors = [next(iter(group.series.values())).position_error_m[26] for group in said.groups]
    expect(read.locator("span")).to_have_text([f"{error:.3f}" for error in errors])

    chart = page.locator(".compare .run-chart", has_text="Position error")
    files = {kind: kept(page, chart, kind, tmp_path) for kind in ("SVG", "PNG", "CSV")}
    svg = ElementTree.fromstring(files["SVG"].read_bytes())
    curves = [each.get("stroke") for each in svg.iter("{http://www.w3.org/2000/svg}path") if "L" in each.get("d")]
    assert curves == ["#0072b2", "#d55e00"]  # on white, whatever the colours of the page
    assert svg.find("{http://www.w3.org/2000/svg}rect").get("fill") == "#ffffff"
    assert cv2.imread(str(files["PNG"])).shape == (800, 1520, 3)
    rows = list(csv.reader(files["CSV"].read_text().splitlines()))
    assert rows[0] == ["time [s]", *(group.label for group in said.groups)]
    assert [float(value) for value in rows[27]] == pytest.approx([1.04, *errors], abs=1e-4)

    paths = ElementTree.fromstring(kept(page, page.locator(".compare .run-tile"), "SVG", tmp_path).read_bytes())
    told = [each.text for each in paths.iter("{http://www.w3.org/2000/svg}text")]
    assert {"Paths", "x [m]", "y [m]", *(group.label for group in said.groups)} <= set(told)

    # Space presses the button that the keyboard is at, and both ways the keyboard goes along.
    page.keyboard.press("Home")
    page.get_by_role("button", name="Back", exact=True).focus()
    page.keyboard.press(" ")
    expect(page.get_by_role("button", name="Compare 2 chosen")).to_be_focused()
    page.keyboard.press(" ")
    expect(page.locator(".compare")).to_be_focused()
    page.keyboard.press("Escape")
    expect(page.get_by_label("Compare clean.mcap")).to_be_checked()
    page.locator("[data-path='clean.mcap']").click()
    expect(page.locator(".run-time:visible")).to_contain_text("of 1.96 s")


def test_recordings_and_sweeps_are_compared_on_one_clock_and_on_the_plan_of_their_world(browser, folder, tmp_path):
    expect.set_options(timeout=PATIENCE)
    with Studio(folder) as studio, page_at(browser, studio.url, scheme="dark") as page:
        page.get_by_role("tab", name="Review", exact=True).click()
        expect(page.get_by_label("Compare swept")).to_be_visible()
        each_run_of_a_kind_has_a_column_of_its_own_by_its_seed(page, folder, tmp_path)
        a_sweep_shows_the_paths_of_its_runs_on_the_plan_of_its_world(page, folder, tmp_path)
        recordings_are_compared_on_one_clock(page, folder, tmp_path)
