"""The Run view in a real browser, on a real server."""

import os
import re
import sys
from contextlib import contextmanager
from itertools import islice

import pytest
from playwright.sync_api import Page, expect

import mjsim
from mjsim.web import LiveView, Studio
from mjsim.web.server.local import listen
from tests.browser import browser as listener
from tests.children import child
from tests.windows import PATIENCE, agreed, page_at

pytestmark = pytest.mark.slow
DT = 0.04
ROOM = """
mjsim: 1
name: room
walls: [{points: [[-3, -3], [3, -3], [3, 3], [-3, 3]], closed: true}]
beacons: [{name: lion, image: posters/lion.jpg, at: [2.9, 0], heading_deg: 180, center: 0.5}]
robots:
  - name: scout
    preset: pioneer3dx
    at: [0, 0]
    odometry: {noise: {distance: 0.01, turn: 0.02}}
    sensors: [{camera: front, width: 160, height: 120, rate_hz: 25}]
run:
  seconds: 1000
  drivers:
    scout: {estimator: {use: "mjsim.algorithms.ekf_slam:EkfSlam"}}
"""


GOAL = """
mjsim: 1
walls: [{points: [[-3, -3], [3, -3], [3, 3], [-3, 3]], closed: true}]
robots: [{name: scout, preset: pioneer3dx, at: [-2, 0]}]
run:
  seconds: 1000
  map: known
  drivers: {scout: {navigator: {use: "mjsim.algorithms.go_to_goal:GoToGoal", goals: [[2, 2]]}}}
"""
CRANK = """
mjsim: 1
mechanisms:
  - name: wheel
    at: [0, 0]
    elevation: 1
    bodies: [{name: crank, rod: [1.0, 0.05]}]
    joints: [{revolute: q2, of: [ground, crank], axis: [0, 1, 0]}]
    actuators: [{velocity: q2, signal: {constant: {value_deg: 90}}}]
run: {seconds: 1000}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("folder")
    (place / "room.yaml").write_text(ROOM)
    return place


@contextmanager
def run_page(browser, url, **window):
    with page_at(browser, url, outside=True, **window) as page:
        page.get_by_role("tab", name="Run", exact=True).click()
        yield page


@pytest.fixture
def started(browser, folder):
    """The Run view of a studio in which the room runs, and the studio."""
    with Studio(folder, world="room.yaml") as studio, run_page(browser, studio.url) as page:
        start(page)
        yield page, studio


def start(page: Page) -> None:
    page.get_by_role("button", name="Start", exact=True).click()
    is_in(page, "Running")


def is_in(page: Page, state: str) -> None:
    expect(page.locator(".run-state")).to_have_text(state, timeout=PATIENCE)


def pause(page: Page) -> None:
    page.get_by_role("button", name="Pause", exact=True).click()
    is_in(page, "Paused")


def picture_of(page: Page, view: str) -> str:
    """Return the pixels that a view shows, once it shows any."""
    canvas = page.locator(f"[data-view='{view}'] canvas[data-filled]")
    canvas.wait_for(timeout=PATIENCE)
    return canvas.evaluate("canvas => canvas.toDataURL()")


def wait_for_another(page: Page, view: str, before: str) -> None:
    script = "([view, before]) => document.querySelector(`[data-view='${view}'] canvas`).toDataURL() !== before"
    page.wait_for_function(script, arg=[view, before], timeout=PATIENCE)


def test_the_page_says_what_to_do_before_and_after_a_run(browser, folder):
    (folder / "bare.yaml").write_text(ROOM[: ROOM.index("robots:")])
    (folder / "crank.yaml").write_text(CRANK)
    (folder / "goal.yaml").write_text(GOAL)
    with Studio(folder) as studio, run_page(browser, studio.url) as page:
        advice = page.locator(".run-advice")
        expect(advice).to_contain_text("No world is open", timeout=PATIENCE)
        open_world(page, "room.yaml")
        page.get_by_label("Record to a file").check()
        page.get_by_label("Duration", exact=True).fill("0.4")
        page.get_by_role("button", name="Start", exact=True).click()
        advice.get_by_role("button", name="Review it").click()
        expect(page.locator(".review-title")).to_have_text("out/room/run.mcap", timeout=PATIENCE)
        page.get_by_role("tab", name="Run", exact=True).click()
        open_world(page, "bare.yaml")
        expect(advice).to_contain_text("This world has no robot", timeout=PATIENCE)
        is_in(page, "Ready")  # what ended was the run of another world
        a_reload_and_the_steps_of_the_browser_lead_to_what_was_shown(page)
        a_world_without_robots_is_seen_from_outside_and_its_joints_in_charts(page)
        goals_are_set_on_the_plan_and_in_3d_while_it_runs(page)


def goals_are_set_on_the_plan_and_in_3d_while_it_runs(page):
    def drag(on):
        box = on.bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x, y - 60, steps=3)
        page.mouse.up()

    page.get_by_role("button", name="Stop the run").click()
    open_world(page, "goal.yaml")
    page.evaluate("() => localStorage.setItem('mjsim.run.scene.slow', 'yes')")
    start(page)
    page.get_by_role("tab", name="Events", exact=True).click()
    page.get_by_role("button", name="Goal:").click()
    drag(page.locator("#view-run .run-floor"))
    sent = page.locator("#view-run").get_by_text(re.compile(r"is sent to \[.*heading (8\d|9\d)"))
    expect(sent).to_have_count(1, timeout=PATIENCE)
    page.locator("#view-run").get_by_title("View in 3-D").click()
    page.locator("#view-run .scene[data-filled]").wait_for(timeout=PATIENCE)
    drag(page.locator("#view-run .scene canvas"))
    expect(page.locator("#view-run").get_by_text("is sent to")).to_have_count(2, timeout=PATIENCE)


def a_reload_and_the_steps_of_the_browser_lead_to_what_was_shown(page):
    name, title = page.locator(".world .name"), page.locator(".review-title")
    page.wait_for_function("() => location.hash === '#run?world=bare.yaml'")
    page.reload()
    expect(name).to_have_text("bare.yaml", timeout=PATIENCE)
    expect(page.locator("#view-run")).to_be_visible()
    page.get_by_role("tab", name="Review", exact=True).click()
    page.wait_for_function("() => location.hash === '#review?world=bare.yaml'")  # a step of its own
    page.locator("[data-path='out/room/run.mcap']").click()
    expect(title).to_have_text("out/room/run.mcap", timeout=PATIENCE)
    page.get_by_role("slider", name="Time").evaluate("e => { e.value = 0.2; e.dispatchEvent(new Event('input')); }")
    page.wait_for_function("() => location.hash.endsWith('recording=out/room/run.mcap&time=0.2')")
    page.reload()
    expect(page.locator("#view-review .run-time")).to_contain_text("0.20 s of", timeout=PATIENCE)
    page.go_back()
    page.go_back()
    expect(page.locator("#view-run")).to_be_visible(timeout=PATIENCE)
    page.go_forward()
    page.go_forward()
    expect(title).to_have_text("out/room/run.mcap", timeout=PATIENCE)


def a_world_without_robots_is_seen_from_outside_and_its_joints_in_charts(page):
    page.get_by_role("tab", name="Run", exact=True).click()
    open_world(page, "crank.yaml")
    start(page)
    picture_of(page, "outside")
    expect(page.locator("#view-run .plotter-chart figcaption")).to_contain_text("q2.position", timeout=PATIENCE)
    expect(page.locator("#view-run .run-sheet > .run-chart")).to_have_count(0)
    for name in ("Depth", "Segments"):
        expect(page.locator("#view-run").get_by_role("button", name=name)).to_be_hidden()


def open_world(page: Page, name: str) -> None:
    """Open a world of the folder from the Run view, which stays."""
    page.keyboard.press("Control+o")
    page.get_by_role("searchbox", name="Find a world").fill(name)
    page.keyboard.press("Enter")
    expect(page.locator(".world .name")).to_have_text(name, timeout=PATIENCE)
    expect(page.locator("#view-run")).to_be_visible()


def a_single_tick_takes_the_run_on_by_one_tick_exactly(started):
    page, studio = started
    pause(page)
    with listener(studio.url) as watcher:
        before = watcher.until("tick")["time"]
    expect(page.locator(".run-time")).to_contain_text(f"{before:.2f} s", timeout=PATIENCE)
    for count in range(1, 4):
        page.get_by_role("button", name="Single tick").click()
        expect(page.locator(".run-time")).to_contain_text(f"{before + count * DT:.2f} s", timeout=PATIENCE)
    is_in(page, "Paused")
    page.locator(".run-time").click()  # on a button, the space bar would press it
    page.keyboard.press("Space")
    is_in(page, "Running")


def keys_drive_the_robot_and_letting_go_stops_it(started):
    page, studio = started
    page.keyboard.down("w")
    with listener(studio.url) as watcher:
        while watcher.until("tick")["robots"]["scout"]["truth"][0] < 0.1:
            pass
        page.keyboard.up("w")
        while watcher.until("tick")["robots"]["scout"]["command"] != [0.0, 0.0, 0.0]:
            pass


def a_slider_changes_the_noise_of_the_run_and_its_button_puts_it_back(started):
    page, studio = started
    key = "robots.scout.odometry.noise.turn"
    page.get_by_role("tab", name="Noise").click()
    row = page.locator(".run-noise-row", has=page.locator(f"[data-key='{key}']"))
    with listener(studio.url) as watcher:
        row.locator("input[type=range]").press("End")
        assert noise_of(watcher, key, 0.02) == pytest.approx(8 * 0.02)
        row.get_by_role("button", name="Reset turn").click()
        assert noise_of(watcher, key, 8 * 0.02) == pytest.approx(0.02)


def noise_of(watcher, key: str, before: float) -> float:
    """Wait until the run's noise is another than before, and return it."""
    while True:
        told = {each["key"]: each["value"] for each in watcher.until("run").get("noise", [])}
        if told.get(key, before) != before:
            return told[key]


def two_browsers_see_the_same_run_also_who_comes_late(browser, started):
    page, studio = started
    pause(page)
    with run_page(browser, studio.url) as late:
        is_in(late, "Paused")
        agreed(page, page.locator(".run-time").inner_text, late.locator(".run-time").inner_text)
        agreed(page, lambda: picture_of(late, "scout/front"), lambda: picture_of(page, "scout/front"))
        assert agreed(page, lambda: modules_of(late), lambda: modules_of(page)).count("rgb") > 1
        late.get_by_role("button", name="Resume").click()
        is_in(page, "Running")


def test_a_run_is_taken_on_driven_disturbed_and_seen_by_a_second_browser(browser, started):
    keys_drive_the_robot_and_letting_go_stops_it(started)
    a_slider_changes_the_noise_of_the_run_and_its_button_puts_it_back(started)
    a_single_tick_takes_the_run_on_by_one_tick_exactly(started)
    two_browsers_see_the_same_run_also_who_comes_late(browser, started)


def modules_of(page) -> str:
    """Return the names of the modules of a run and the colours that they have in its chart."""
    legend = page.locator(".run-chart", has_text="Time").locator(".run-chart-legend > *")
    return str(
        legend.evaluate_all("all => all.map(each => [each.textContent, each.querySelector('i').style.background])")
    )


def test_a_run_from_python_is_seen_alone_and_its_end_too(browser):
    world = mjsim.parse_world(ROOM)
    with mjsim.Simulation(world) as sim, LiveView(world) as view, page_at(browser, view.url, outside=True) as page:
        for tick in islice(mjsim.ticks(sim, {"scout": mjsim.Driver()}), 5):
            view.show(tick)
        expect(page.locator(".run-time")).to_contain_text("0.16 s", timeout=PATIENCE)
        picture_of(page, "scout/front")
        expect(page.get_by_role("tab", name="Edit")).to_have_count(0)
        for name in ("Start", "Pause", "Single tick", "Stop the run", "Restart from the beginning"):
            expect(page.get_by_role("button", name=name)).to_be_hidden()
        with page_at(browser, view.url, outside=True) as late:
            picture_of(late, "scout/front")
            picture_of(late, "outside")
        view.close()
        is_in(page, "Ended")


def test_the_page_finds_back_to_a_server_that_was_killed(browser, folder):
    with listen(0) as free:
        port = free.getsockname()[1]
    command = [
        sys.executable,
        "-c",
        "from mjsim.cli import main; main()",
        "studio",
        "room.yaml",
        "--no-browser",
        "--port",
        str(port),
    ]
    with serving(command, folder) as (first, url), page_at(browser, url, outside=True) as page:
        expect(page.locator("#view-edit .plan")).to_be_visible(timeout=PATIENCE)
        page.route("**/api/schema", lambda asked: asked.abort("connectionreset"))  # it is gone meanwhile
        page.get_by_role("tab", name="Run", exact=True).click()
        is_in(page, "Ready")
        expect(page.locator(".toast.error")).to_contain_text("The studio does not answer", timeout=PATIENCE)
        page.unroute_all()
        # The world is open as well.
        expect(page.get_by_role("button", name="Start", exact=True)).to_be_enabled(timeout=PATIENCE)
        first.kill()
        is_in(page, "Connection lost; trying again")
        with Studio(folder, world="room.yaml", port=port) as again:
            is_in(page, "No access")
            expect(page.get_by_text("Open the address that it printed")).to_be_visible()
            # It lets in all pages of the browser.
            open_in(page.context, again.url)
            is_in(page, "Ready")
            # The forms, which nobody answered for, have come as well.
            expect(page.get_by_label("Duration", exact=True)).to_be_visible(timeout=PATIENCE)
            start(page)
            picture_of(page, "scout/front")


def open_in(context, url):
    """Open another page in the same browser; it stays, since closing one that has just come sometimes never ends."""
    context.new_page().goto(url)


@contextmanager
def serving(command, folder):
    """Run the studio from the command line until it answers; end it afterwards."""
    environment = os.environ | {"PYTHONUNBUFFERED": "1"}
    with child(command, cwd=folder, env=environment) as process:
        yield process, re.search(r"http://\S+", process.line("stderr"))[0]
