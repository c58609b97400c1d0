"""The Review view in a real browser, on a real server and a real recording."""

import base64
import math
import time
from functools import partial

import av
import numpy as np
import pytest
from playwright.sync_api import expect

import mjsim
from mjsim.web import Studio
from tests.windows import PATIENCE, page_at

pytestmark = pytest.mark.slow
ROOM = """
mjsim: 1
name: room
walls: [{points: [[-3, -3], [3, -3], [3, 3], [-3, 3]], closed: true}]
beacons:
  - {name: lion, image: posters/lion.jpg, at: [2.9, 0], heading_deg: 180, center: 0.5}
  - {name: east, at: [2.9, 1]}
  - {name: west, at: [-2.9, 1]}
robots:
  - name: scout
    preset: pioneer3dx
    at: [0, 0]
    odometry: {noise: {distance: 0.05, turn: 0.05}}
    sensors:
      - {camera: front, width: 160, height: 120, rate_hz: 5}
      - {beacons: ring, range: [0.3, 8], fov_deg: 360, rate_hz: 5, noise: {range: 0.05, bearing_deg: 1}}
run:
  seconds: 8
  drivers:
    scout:
      estimator: {use: "mjsim.algorithms.ekf_slam:EkfSlam"}
      navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[1, 0], [1, 1], [0, 0]], laps: 100}
  events:
    - {time: 3, light: 0.5}
"""


@pytest.fixture
def recorded(tmp_path_factory):
    """A folder with a recording."""
    folder = tmp_path_factory.mktemp("folder")
    world = mjsim.parse_world(ROOM)
    (folder / "out").mkdir()
    with mjsim.Simulation(world, seed=1) as sim:
        mjsim.run(sim, record=folder / "out" / "run.mcap")
    return folder


@pytest.fixture
def review(browser, recorded):
    """The Review view with the recording open."""
    with Studio(recorded) as studio, page_at(browser, studio.url) as page:
        page.context.grant_permissions(["clipboard-read", "clipboard-write"])
        page.get_by_role("tab", name="Review", exact=True).click()
        page.locator("[data-path='out/run.mcap']").click()
        expect(page.locator(".run-time")).to_contain_text("of 7.96 s", timeout=PATIENCE)
        yield page


def seek(page, time: float) -> None:
    slider = page.get_by_role("slider", name="Time")
    slider.evaluate("(slider, time) => { slider.value = time; slider.dispatchEvent(new Event('input')) }", str(time))
    expect(page.locator(".run-time")).to_contain_text(f"{time:.2f} s of", timeout=PATIENCE)


def picture_at(page, time: float) -> str:
    """Return the pixels of the onboard camera's picture of a time."""
    canvas = page.locator(f"[data-view='scout/front'] canvas[data-time='{time:g}']")
    canvas.wait_for(timeout=PATIENCE)
    return canvas.evaluate("canvas => canvas.toDataURL()")


def scrubbing_shows_the_pictures_of_that_time(review):
    seek(review, 1.0)
    first = picture_at(review, 1.0)
    seek(review, 5.0)
    assert picture_at(review, 5.0) != first
    seek(review, 1.0)
    assert picture_at(review, 1.0) == first


def keys_go_from_tick_to_tick_and_events_stand_on_the_bar(review):
    seek(review, 2.0)
    review.keyboard.press(".")
    expect(review.locator(".run-time")).to_contain_text("2.04 s of")
    review.keyboard.press(",")
    review.keyboard.press(",")
    expect(review.locator(".run-time")).to_contain_text("1.96 s of")
    review.locator(".run-scrub-events button[data-event='light']").click()
    expect(review.locator(".run-time")).to_contain_text("3.00 s of")


def a_marked_part_has_the_figures_of_its_ticks(review, recorded):
    mark(review, 2.0, 6.0)
    track = mjsim.read_recording(recorded / "out" / "run.mcap").robots["scout"]
    part = (track.time >= 2.0 - 1e-9) & (track.time <= 6.0 + 1e-9)
    errors = np.hypot(*(track.estimate - track.truth)[part, :2].T)
    becomes(review, "Position error, RMSE", math.sqrt((errors**2).mean()))
    becomes(review, "Position error, max", errors.max())
    review.get_by_role("button", name="Copy as CSV").click()
    expect(review.get_by_text("Copied as CSV")).to_be_visible()
    rows = [line.split(",") for line in review.evaluate("navigator.clipboard.readText()").splitlines()]
    assert rows[0] == ["robot", "figure", "part", "value", "unit"]
    assert ["scout", "Position error", "max", repr(figure(review, "Position error, max")), "m"] in rows


def the_whole_recording_has_figures_before_anything_is_marked(review, recorded):
    track = mjsim.read_recording(recorded / "out" / "run.mcap").robots["scout"]
    errors = np.hypot(*(track.estimate - track.truth)[:, :2].T)
    review.get_by_role("tab", name="Statistics", exact=True).click()
    becomes(review, "Position error, RMSE", math.sqrt((errors**2).mean()))
    expect(review.locator(".run-figures-head")).to_contain_text("Whole recording")


def the_view_in_3d_that_is_opened_shows_the_time_that_is_looked_at(review):
    seek(review, 5.0)
    review.get_by_title("View in 3-D").click()
    canvas = review.locator("#view-review .scene canvas")
    expect(canvas).to_have_attribute("data-time", "5", timeout=PATIENCE)
    review.get_by_title("View in 3-D").click()


def test_a_recording_is_gone_through_has_figures_and_films_and_another_is_dropped(review, recorded, tmp_path):
    the_whole_recording_has_figures_before_anything_is_marked(review, recorded)
    the_view_in_3d_that_is_opened_shows_the_time_that_is_looked_at(review)
    scrubbing_shows_the_pictures_of_that_time(review)
    keys_go_from_tick_to_tick_and_events_stand_on_the_bar(review)
    a_marked_part_has_the_figures_of_its_ticks(review, recorded)
    a_marked_part_becomes_a_film_of_that_length(review, tmp_path)
    a_recording_that_is_dropped_is_the_one_that_is_opened(review, recorded, tmp_path)


DROP = """([name, base64]) => {
  const dropped = new DataTransfer();
  dropped.items.add(new File([Uint8Array.from(atob(base64), (each) => each.charCodeAt(0))], name));
  document.querySelector("#view-review").dispatchEvent(new DragEvent("drop", {dataTransfer: dropped, bubbles: true}));
}"""


def a_recording_that_is_dropped_is_the_one_that_is_opened(review, recorded, tmp_path):
    with mjsim.Simulation(mjsim.parse_world(ROOM), seed=2) as sim:
        mjsim.run(sim, seconds=0.4, record=tmp_path / "run.mcap")
    drop = partial(review.evaluate, DROP)
    drop(["run.mcap", base64.b64encode((tmp_path / "run.mcap").read_bytes()).decode()])
    expect(review.locator(".run-time")).to_contain_text("of 0.36 s", timeout=PATIENCE)  # not the one of the same name
    brought = set(recorded.rglob("*.mcap"))
    assert len(brought) == 2
    drop(["run.mcap", base64.b64encode((recorded / "out" / "run.mcap").read_bytes()).decode()])
    expect(review.locator(".run-time")).to_contain_text("of 7.96 s", timeout=PATIENCE)
    assert set(recorded.rglob("*.mcap")) == brought  # it lies there already


def mark(page, begin: float, end: float) -> None:
    seek(page, begin)
    page.keyboard.press("i")
    seek(page, end)
    page.keyboard.press("o")
    expect(page.get_by_text(f"{begin:.2f} s to {end:.2f} s").first).to_be_visible(timeout=PATIENCE)


def figure(page, name: str) -> float:
    cell = page.locator(f"[data-figure='{name}'] [data-value]")
    return float(cell.get_attribute("data-value", timeout=PATIENCE))


def becomes(page, name: str, value: float) -> None:
    """Wait until a figure has a value: those of the whole run stand there until the ones of a part come."""
    until = time.monotonic() + PATIENCE / 1000
    while figure(page, name) != pytest.approx(value, rel=1e-6):
        assert time.monotonic() < until, f"{name} is {figure(page, name)}, not {value}"
        page.wait_for_timeout(50)


def a_marked_part_becomes_a_film_of_that_length(review, tmp_path):
    mark(review, 1.0, 2.0)
    review.get_by_label("View of the video").select_option("scout/front")
    review.get_by_role("button", name="Export video").click()
    with review.expect_download(timeout=PATIENCE) as download:
        link = review.locator(".run-film-job a").first
        expect(link).to_be_in_viewport(timeout=PATIENCE)
        link.click()
    download.value.save_as(tmp_path / "film.mp4")
    with av.open(tmp_path / "film.mp4") as film:
        stream = film.streams.video[0]
        assert float(stream.duration * stream.time_base) == pytest.approx(1.0, abs=0.1)
