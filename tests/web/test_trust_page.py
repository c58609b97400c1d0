"""The question whether a world's own code may run, in a real browser."""

import re

import pytest
from playwright.sync_api import expect

from mjsim.web import Studio
from tests.web.test_trust import ROOM, ROVER, TANK
from tests.windows import PATIENCE, page_at

pytestmark = pytest.mark.slow
CODE = """
import helper, mjsim
class Go:
    def start(self, *told): pass
    def command(self, seen, belief): return mjsim.Command()
"""
WORLD = """
mjsim: 1
name: driven
robots: [{name: scout, preset: pioneer3dx, at: [1, 1]}]
run: {seconds: 1000, drivers: {scout: {navigator: {use: "go.py:Go"}}}}
"""


@pytest.fixture
def page(browser, tmp_path):
    for name, text in (("driven.yaml", WORLD), ("go.py", CODE), ("helper.py", "")):
        (tmp_path / name).write_text(text)
    (tmp_path / "plain.yaml").write_text(WORLD.replace('{navigator: {use: "go.py:Go"}}', "{}"))
    with Studio(tmp_path) as studio, page_at(browser, studio.url) as page:
        yield page


def open_world(page, name):
    expect(page.get_by_role("tab", name="Run", exact=True)).to_be_visible(timeout=PATIENCE)  # who sees it heeds keys
    page.keyboard.press("Control+o")
    page.get_by_role("dialog").get_by_text(name, exact=True).click()
    # A world that is opened in Edit shows itself there, so the way to Run begins after that.
    expect(page).to_have_title(re.compile(f"^{re.escape(name)} "), timeout=PATIENCE)
    page.get_by_role("tab", name="Run", exact=True).click()


def start(page):
    page.get_by_role("button", name="Start", exact=True).click()


def runs(page):
    """Wait until it runs, and end that."""
    expect(page.locator(".run-state")).to_have_text("Running", timeout=PATIENCE)
    page.get_by_role("button", name="Stop the run").click()
    expect(page.locator(".run-state")).to_have_text("Ended", timeout=PATIENCE)


def code_that_changes_while_the_dialog_is_open_is_asked_for_again(page, tmp_path):
    open_world(page, "driven.yaml")
    start(page)
    dialog = page.get_by_role("dialog", name="Let this world's code run?")
    expect(dialog.get_by_role("listitem")).to_have_text(["go.py", "helper.py"], timeout=PATIENCE)
    dialog.get_by_role("button", name="Not now").click()
    expect(page.locator(".run-state")).not_to_have_text("Running")
    start(page)
    (tmp_path / "helper.py").write_text("changed = True\n")
    dialog.get_by_role("button", name="Allow").click()
    expect(page.get_by_text("this code has changed since you were asked: helper.py")).to_be_visible(timeout=PATIENCE)
    dialog.get_by_role("button", name="Allow").click()
    runs(page)


def a_module_that_is_chosen_for_a_run_is_asked_for_and_runs(page, tmp_path):
    (tmp_path / "go.py").write_text(f"{CODE}\n")
    (tmp_path / "helper.py").write_text("again = True\n")
    open_world(page, "plain.yaml")
    page.get_by_role("button", name="scout: Navigator: None").click()
    page.get_by_role("dialog").get_by_role("button", name="Go", exact=True).click()
    start(page)
    dialog = page.get_by_role("dialog", name="Let this world's code run?")
    expect(dialog.get_by_role("listitem")).to_have_text(["go.py", "helper.py"], timeout=PATIENCE)
    dialog.get_by_role("button", name="Allow").click()
    runs(page)


def a_scene_asks_once_about_the_same_code_and_shows_the_newest_text(page, tmp_path):
    (tmp_path / "rover.xml").write_text(ROVER)
    (tmp_path / "tank.py").write_text(TANK)
    (tmp_path / "tank.yaml").write_text(ROOM)
    open_world(page, "tank.yaml")
    page.get_by_role("tab", name="Edit", exact=True).click()
    page.get_by_role("button", name="3-D").locator("visible=true").first.click()
    dialog = page.get_by_role("dialog", name="Let this world's code run?")
    dialog.get_by_role("button", name="Not now").click(timeout=PATIENCE)
    door = page.locator("#view-edit .scene-door")
    review = door.get_by_role("button", name="Review the code")
    expect(review).to_be_visible(timeout=PATIENCE)
    with page.expect_response("**/api/scene"):  # the page reads what is new on disk
        (tmp_path / "tank.yaml").write_text(ROOM + "# one\n")
    expect(review).to_be_visible()
    expect(dialog).to_have_count(0)
    review.click()
    expect(dialog).to_be_visible()
    (tmp_path / "tank.yaml").write_text(ROOM + "# two\n")
    expect(page.locator(".cm-content")).to_contain_text("# two", timeout=PATIENCE)
    dialog.get_by_role("button", name="Allow").click()
    expect(door).to_have_attribute("data-scene", "there", timeout=PATIENCE)


def test_code_is_asked_for_once_and_again_when_it_is_another(page, tmp_path):
    code_that_changes_while_the_dialog_is_open_is_asked_for_again(page, tmp_path)
    a_module_that_is_chosen_for_a_run_is_asked_for_and_runs(page, tmp_path)
    a_scene_asks_once_about_the_same_code_and_shows_the_newest_text(page, tmp_path)
