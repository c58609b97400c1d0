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


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with recordings of two settings."""
    place = tmp_path_factory.mktemp("compared")
    for name, text in (("noisy", ROOM), ("clean", CLEAN)):
        with mjsim.Simulation(mjsim.parse_world(text), seed=1) as sim:
            mjsim.run(sim, record=place / f"{name}.mcap")
    return place


def test_each_run_of_a_kind_has_a_column_of_its_own_by_its_seed(browser, folder, tmp_path):
    expect.set_options(timeout=PATIENCE)
    for seed in (1, 2):
        with mjsim.Simulation(mjsim.parse_world(ROOM), seed=seed) as sim:
            mjsim.run(sim, record=tmp_path / f"run{seed}.mcap")
    with Studio(tmp_path) as studio, page_at(browser, studio.url) as page:
        page.get_by_role("tab", name="Review", exact=True).click()
        for seed in (1, 2):
            page.get_by_label(f"Compare run{seed}.mcap").check()
        page.get_by_role("button", name="Compare 2 chosen").click()
        chart = page.locator(".compare .run-chart", has_text="Position error")
        label = page.locator(".compare-legend b").inner_text()
        rows = list(csv.reader(kept(page, chart, "CSV", tmp_path).read_text().splitlines()))
        assert rows[0] == ["time [s]", f"{label}, seed 1", f"{label}, seed 2"]
        group = compare([tmp_path / f"run{seed}.mcap" for seed in (1, 2)]).groups[0]
        errors = [group.series[seed].position_error_m[26] for seed in (1, 2)]
        assert [float(value) for value in rows[27]] == pytest.approx([1.04, *errors], abs=1e-4)


def test_a_sweep_shows_the_paths_of_its_runs_on_the_plan_of_its_world(browser, tmp_path):
    expect.set_options(timeout=PATIENCE)
    (tmp_path / "room.yaml").write_text(ROOM)
    settings = {"robots.scout.odometry.noise.turn": [0.02, 0.2]}
    mjsim.sweep(tmp_path / "room.yaml", seeds=range(4), folder=tmp_path / "swept", settings=settings, workers=1)
    with Studio(tmp_path) as studio, page_at(browser, studio.url) as page:
        page.get_by_role("tab", name="Review", exact=True).click()
        page.get_by_label("Compare swept").check()
        page.get_by_role("button", name="Compare 1 chosen").click()
        tile = page.locator(".compare .run-tile")
        rows = list(csv.reader(kept(page, tile, "CSV", tmp_path).read_text().splitlines()))[1:]
        assert {(label, seed) for label, seed, *_ in rows} == {
            (f"noise.turn={turn}", str(seed)) for turn in (0.02, 0.2) for seed in range(4)
        }
        drawn = ElementTree.fromstring(kept(page, tile, "SVG", tmp_path).read_bytes())
        paths = [each.get("d") for each in drawn.iter("{http://www.w3.org/2000/svg}path")]
        assert len([path for path in paths if path.endswith("Z")]) >= 4  # the walls of the room
        assert len([path for path in paths if "L" in path and not path.endswith("Z")]) >= 2 * 2 * 4
        assert cv2.imread(str(kept(page, tile, "PNG", tmp_path))).size > 0
        expect(page.locator(".compare .run-chart-box[data-empty^='No estimator']")).to_be_visible()
        expect(page.locator(".compare-no-plan")).to_be_hidden()

        # A sweep of an earlier version kept no paths: the plan says so, and the figures are there.
        for file in (tmp_path / "swept" / "runs").glob("*.json"):
            outcome = json.loads(file.read_text())
            for series in outcome["series"].values():
                for key in [key for key in series if key.endswith(("_x_m", "_y_m"))]:
                    del series[key]
            file.write_text(json.dumps(outcome))
        page.keyboard.press("Escape")
        page.get_by_role("button", name="Compare 1 chosen").click()
        expect(page.locator(".compare-no-plan")).to_contain_text("No paths to draw")
        expect(page.locator(".compare-legend li")).to_have_count(2)


def kept(page, chart, kind, folder):
    """Return the file that the menu of a chart gives."""
    chart.get_by_label("Save as a file").click()
    with page.expect_download(timeout=PATIENCE) as download:
        chart.get_by_role("button", name=kind).click()
    download.value.save_as(folder / download.value.suggested_filename)
    return folder / download.value.suggested_filename


def test_recordings_are_compared_on_one_clock(browser, folder, tmp_path):
    expect.set_options(timeout=PATIENCE)
    said = compare([folder / "clean.mcap", folder / "noisy.mcap"])
    with Studio(folder) as studio, page_at(browser, studio.url, scheme="dark") as page:
        page.get_by_role("tab", name="Review", exact=True).click()
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
