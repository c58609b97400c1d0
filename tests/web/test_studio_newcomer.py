"""A newcomer at the studio: from an empty folder to a running world, and edits of one full of comments."""

import random
import re
from importlib import resources
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from mjsim.web import Studio
from mjsim.world import check_world, load_world, parse_world
from tests.sheet import DRAWN, Sheet, sheet_of
from tests.windows import PATIENCE, page_at, without_portraits

pytestmark = pytest.mark.slow
EDITS = 9
"""Each of the six kinds is done, those first that were not."""
KINDS = 6
WIDE, DEEP = 12, 8
"""How large the room is in which they are made [m]."""


def test_a_newcomer_builds_a_room_saves_it_sees_it_run_and_opens_a_shipped_world(browser, tmp_path):
    expect.set_options(timeout=PATIENCE)
    with Studio(tmp_path) as studio, page_at(browser, studio.url) as page:
        without_portraits(page)
        sheet = Sheet(page)
        page.locator("#view-edit").get_by_role("button", name="New world").press("Enter")
        expect(sheet.plan).to_be_focused()
        draw_a_room(sheet)
        save_as(page, "hall")
        world = load_world(tmp_path / "hall.yaml")
        assert world.walls[0].points == ((-3, -2), (3, -2), (3, 2), (-3, 2))
        assert (world.walls[0].closed, len(world.walls[0].openings)) == (True, 1)
        assert [beacon.image for beacon in world.beacons] == ["posters/cat.jpg"]
        assert (world.beacons[0].at, world.beacons[0].heading_deg) == ((2.94, 0), 180)  # on the wall, facing the room
        assert [robot.preset for robot in world.robots] == ["create3"]
        assert check_world(world) == []
        watch_it_run(page)
        a_shipped_world_is_opened_by_its_name_and_saved_where_one_works(page, tmp_path)


def a_shipped_world_is_opened_by_its_name_and_saved_where_one_works(page: Page, folder: Path) -> None:
    page.keyboard.press("Control+o")
    page.get_by_role("searchbox", name="Find a world").fill("dark")
    page.keyboard.press("Enter")
    expect(page.locator(".world .name")).to_have_text("dark")
    page.keyboard.press("Alt+1")
    expect(page.locator("#view-edit")).to_contain_text("name: dark")
    save_as(page, "mine")
    assert load_world(folder / "mine.yaml") == load_world("dark")


def draw_a_room(sheet: Sheet) -> None:
    """Put in walls corner by corner, a doorway, a picture of another than the usual choice, and a robot likewise."""
    sheet.button("Draw the first wall").click()
    for corner in ((-3, -2), (3, -2), (3, 2), (-3, 2), (-3, -2)):
        sheet.click(*corner)
    sheet.reads("closed: true")
    sheet.press("d")
    sheet.click(0, -2)
    sheet.reads("width: 0.9")
    sheet.press("p")
    sheet.button("lion.jpg").click()
    sheet.page.get_by_role("dialog").get_by_role("button", name="cat.jpg", exact=True).click()
    sheet.click(2.9, 0)
    sheet.reads("posters/cat.jpg")
    sheet.press("r")
    sheet.page.get_by_title("Choose a robot").click()
    sheet.page.get_by_title("create3", exact=True).click()
    sheet.drag((-1, 0), (1, 0))
    sheet.reads("preset: create3")


def save_as(page: Page, name: str) -> None:
    page.keyboard.press("Control+s")
    page.get_by_role("dialog").get_by_label("File").fill(name)
    # The dot alone tells nothing of a world that was never changed.
    with page.expect_response("**/api/save", timeout=PATIENCE):
        page.keyboard.press("Enter")
    expect(page.locator(".world .dot")).to_be_hidden()


def watch_it_run(page: Page) -> None:
    """Start the world by keys: what its camera sees comes, and its time goes on."""
    page.keyboard.press("Alt+2")
    start = page.get_by_role("button", name="Start", exact=True)
    expect(start).to_be_enabled()  # what is disabled takes no keys
    start.press("Enter")
    page.locator("[data-view='robot/front'] canvas[data-filled]").wait_for()
    seen = "() => Number(document.querySelector('.run-time').textContent.split(' s')[0]) > 0.5"
    page.wait_for_function(seen, timeout=PATIENCE)


def test_comments_outlive_all_kinds_of_edits_and_undo_leads_back_to_the_same_bytes(browser, tmp_path):
    text = commented(resources.files("mjsim.worlds").joinpath("dark.yaml").read_text(encoding="utf-8"))
    with sheet_of(browser, tmp_path, text) as sheet:
        scribe = Scribe(sheet, tmp_path / "room.yaml", seed=1)
        for _ in range(EDITS):
            before = scribe.text
            scribe.edit()
            assert scribe.text != before
            assert comments(scribe.text) == comments(text)
        assert len(scribe.done) == KINDS
        sheet.plan.focus()
        sheet.press(*["Control+z"] * EDITS)
        expect(sheet.button("Undo (Ctrl+Z)")).to_be_disabled()
        sheet.save()
        assert (tmp_path / "room.yaml").read_bytes() == text.encode()


def commented(text: str) -> str:
    """Return a world with a remark of its own on every line that has none."""
    lines = [line if "# " in line else f"{line}  # remark {number}" for number, line in enumerate(text.splitlines())]
    return "\n".join(lines) + "\n"


def comments(text: str) -> list[str]:
    return re.findall(r"(?:^|\s)(# .*)", text)


class Scribe:
    """Edits a world through the page by chance, saves each edit, and knows what then stands in the file."""

    def __init__(self, sheet: Sheet, path: Path, *, seed: int) -> None:
        self.sheet, self.path, self.chance = sheet, path, random.Random(seed)
        self.made: set[str] = set()
        self.done: set[str] = set()
        self._read()

    def edit(self) -> None:
        """Select a thing that can be seen, and do one of the edits to it; only copies are turned and deleted."""
        name, before = self._select(), set(self.things)
        edits = [self._drag, self._nudge, self._place, self._duplicate]
        if name in self.made:
            edits += [self._turn, self._delete]
        edit = self.chance.choice([each for each in edits if each.__name__ not in self.done] or edits)
        edit()
        self.done.add(edit.__name__)
        expect(self.sheet.unsaved, f"{edit.__name__} of {name}, chosen at {self.at}").to_be_visible()
        self.sheet.save()
        self._read()
        self.made |= set(self.things) - before

    def _read(self) -> None:
        self.text = self.path.read_bytes().decode()
        world = parse_world(self.text)
        named = {thing.name: thing.at for thing in (*world.obstacles, *world.beacons)}
        # Repetitions have names that do not stand in the text; they cannot be changed one by one.
        self.things = {name: at for name, at in named.items() if re.search(rf"name: {name}[,\s]", self.text)}

    def _select(self) -> str:
        """Click where things are until one that can be changed is on top there, and return its name."""
        copies = self.made & set(self.things)  # what is done to copies alone would come late
        while True:
            name = self.chance.choice(sorted(self.things) + 20 * sorted(copies))
            self.at = x, y = self.things[name]
            if not (0 < x < WIDE and 0 < y < DEEP):
                continue
            self.sheet.click(x, y)
            self.sheet.page.evaluate(DRAWN)
            name = self.sheet.title.inner_text()
            if name in self.things:
                return name

    def _drag(self) -> None:
        x, y = self.at
        self.sheet.drag(self.at, ((x + self.chance.uniform(2, 6)) % WIDE, (y + self.chance.uniform(2, 5)) % DEEP))

    def _nudge(self) -> None:
        self.sheet.press(self.chance.choice(["ArrowLeft", "ArrowUp", "Shift+ArrowDown", "Shift+ArrowRight"]))

    def _turn(self) -> None:
        self.sheet.press(self.chance.choice("[]"))

    def _place(self) -> None:
        self.sheet.field("At x").first.fill(f"{self.chance.uniform(1, 8):.3f}")
        self.sheet.press("Enter")

    def _duplicate(self) -> None:
        self.sheet.press("Control+d")

    def _delete(self) -> None:
        self.sheet.press("Delete")
