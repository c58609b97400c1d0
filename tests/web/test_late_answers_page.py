"""Answers of the server that come late belong to what was asked before: the page goes on with what was asked last."""

import json
import re

import pytest
from playwright.sync_api import expect

import mjsim
from mjsim.web import Studio
from tests.sheet import DRAWN
from tests.web.test_studio_hints_page import stand
from tests.windows import PATIENCE, page_at

pytestmark = pytest.mark.slow
ROOM = """\
mjsim: 1
name: NAME
walls: [{points: [[0, 0], [4, 0], [4, 4], [0, 4]], closed: true}]
obstacles: [{name: crate, box: [1, 1, 1], at: [2, 2]}]
robots: [{name: NAME, at: [1, 1], sensors: [{camera: eye, width: 64, height: 48}]}]
run: {seconds: 1}
"""


class Held:
    """Answers to requests with a text in them wait until they are let go."""

    def __init__(self, page, address, text) -> None:
        self.page, self.address, self.text, self.waiting = page, address, text, []
        page.route(address, self._take)

    def _take(self, route) -> None:
        if self.text in (route.request.post_data or "") + route.request.url:
            self.waiting.append(route)
        else:
            route.continue_()

    def until_asked(self) -> None:
        """Wait until a request is held."""
        for _ in range(int(PATIENCE / 20)):
            if self.waiting:
                return
            self.page.wait_for_timeout(20)
        raise AssertionError(f"nothing asked {self.address} for {self.text}")

    def let_go(self) -> None:
        """Let the held requests through, and wait until the page has the answers."""
        for route in self.waiting:
            with self.page.expect_response(lambda each, url=route.request.url: each.url == url) as answer:
                route.continue_()
            answer.value.finished()
        self.page.wait_for_timeout(200)  # what the page does with them


@pytest.fixture
def folder(tmp_path):
    """A folder with two worlds."""
    for name in ("slow", "quick"):
        (tmp_path / f"{name}.yaml").write_text(ROOM.replace("NAME", name))
    return tmp_path


def choose(page, world) -> None:
    """Open a world of the folder."""
    page.keyboard.press("Control+o")
    page.get_by_role("dialog").get_by_role("button", name=f"{world}.yaml", exact=True).click()


def the_world_that_was_chosen_last_stays_open_whichever_comes_first(page):
    page.get_by_role("button", name="quick.yaml", exact=True).wait_for()
    slow = Held(page, "**/api/open", "slow.yaml")
    choose(page, "slow")
    slow.until_asked()
    choose(page, "quick")
    expect(page.locator(".world .name")).to_have_text("quick.yaml")
    slow.let_go()
    expect(page.locator(".world .name")).to_have_text("quick.yaml")


def a_change_whose_text_was_typed_over_meanwhile_says_so(page):
    page.get_by_role("treeitem", name="crate").click()
    late = Held(page, "**/api/edit", "remove")
    page.get_by_role("button", name="Delete (Del)").click()
    late.until_asked()
    page.locator(".cm-content").click()
    page.keyboard.press("Control+Home")
    page.keyboard.type("# a note ")
    late.let_go()
    expect(page.locator(".toasts")).to_contain_text("he text was changed in the meantime; make this change again")
    expect(page.get_by_role("treeitem", name="crate")).to_be_visible()


def what_is_typed_while_another_world_is_on_its_way_is_not_lost(page):
    page.keyboard.press("Control+s")
    expect(page.locator(".world .dot")).to_be_hidden()
    slow = Held(page, "**/api/open", "slow.yaml")
    choose(page, "slow")
    slow.until_asked()
    page.locator(".cm-content").click()
    page.keyboard.type("# another note")
    slow.let_go()
    dialog = page.get_by_role("dialog")
    expect(dialog).to_contain_text("quick.yaml")
    dialog.get_by_role("button", name="Cancel").click()
    expect(page.locator(".cm-content")).to_contain_text("# another note")


def test_worlds_and_changes_that_are_answered_late_take_the_place_of_nothing_newer(browser, folder):
    with Studio(folder) as studio, page_at(browser, studio.url) as page:
        the_world_that_was_chosen_last_stays_open_whichever_comes_first(page)
        page.unroute_all()
        a_change_whose_text_was_typed_over_meanwhile_says_so(page)
        page.unroute_all()
        what_is_typed_while_another_world_is_on_its_way_is_not_lost(page)


def test_a_name_that_the_server_has_not_read_yet_is_offered_once_it_has(browser, folder):
    (folder / "slow.yaml").write_text(
        f"{ROOM}  events:\n    - {{time: 1, remove: }}\n".replace("{seconds: 1}", "\n  seconds: 1")
    )
    with Studio(folder, world="slow.yaml") as studio, page_at(browser, studio.url) as page:
        lines = page.locator(".cm-line")
        expect(page.get_by_role("treeitem", name="crate")).to_be_visible()
        late = Held(page, "**/api/parse", "barrel")
        begin = ROOM.splitlines()[3].index("crate")
        stand(lines.nth(3), begin, begin + len("crate"))
        page.keyboard.insert_text("barrel")
        stand(lines.filter(has_text="remove: "), len("    - {time: 1, remove: "))
        page.keyboard.press("Control+Space")
        late.until_asked()
        options = page.locator(".cm-tooltip-autocomplete li")
        late.let_go()
        expect(options.get_by_text("barrel", exact=True)).to_be_visible()
        expect(options.get_by_text("crate", exact=True)).to_have_count(0)


def test_modules_of_a_world_that_was_left_are_not_offered(browser, folder):
    with Studio(folder, world="slow.yaml") as studio, page_at(browser, studio.url) as page:
        expect(page.locator(".world .name")).to_have_text("slow.yaml")
        late = Held(page, "**/api/modules?*", "slow.yaml")

        def answered(route) -> None:
            # As if each world had a module of its own beside it.
            answer = route.fetch()
            name = "slow" if "slow.yaml" in route.request.url else "quick"
            told = answer.json()
            own = {
                "use": f"{name}.py:Own",
                "title": f"Own of {name}",
                "about": "",
                "needs": [],
                "parts": [],
                "options": {},
            }
            told["navigators"].append(own)
            route.fulfill(response=answer, body=json.dumps(told))

        page.route(
            "**/api/modules?*", lambda route: late._take(route) if "slow" in route.request.url else answered(route)
        )
        page.get_by_role("tab", name="Run", exact=True).click()
        late.until_asked()
        choose(page, "quick")
        page.get_by_role("tab", name="Run", exact=True).click()
        navigator = page.locator(".run-setup").locator(".module-pick[aria-label^='quick: Navigator']")
        navigator.click()
        page.get_by_role("dialog").get_by_role("button", name="Own of quick").click()
        expect(navigator).to_have_text("Own of quick")
        for route in late.waiting:
            answered(route)
        page.wait_for_timeout(300)
        expect(navigator).to_have_text("Own of quick")


def test_a_run_of_which_a_busy_server_tells_only_the_end_is_that_of_the_world_that_is_open(browser, folder):
    def only_ends(link):
        server = link.connect_to_server()
        alive = ('"state": "loading"', '"state": "running"')
        server.on_message(lambda told: None if any(state in str(told) for state in alive) else link.send(told))

    with Studio(folder, world="slow.yaml") as studio, page_at(browser, studio.url, own=True) as page:
        page.route_web_socket(re.compile("/api/run"), only_ends)
        page.reload()
        page.get_by_role("tab", name="Run", exact=True).click()
        page.get_by_role("button", name="Start", exact=True).click()
        expect(page.locator(".run-state")).to_have_text("Ended", timeout=PATIENCE)


def test_figures_that_fail_late_do_not_stand_in_the_place_of_others(browser, folder):
    with mjsim.Simulation(mjsim.load_world(folder / "quick.yaml")) as sim:
        mjsim.run(sim, record=folder / "run.mcap")
    with Studio(folder) as studio, page_at(browser, studio.url) as page:
        page.get_by_role("tab", name="Review", exact=True).click()
        review = page.locator("#view-review")
        review.locator("[data-path='run.mcap']").click()
        expect(review.locator(".run-time")).to_contain_text("of 0.96 s")
        late = Held(page, "**/api/recording/statistics?*", "")
        review.get_by_role("button", name="Mark start").click()
        page.keyboard.press("End")
        review.get_by_role("button", name="Mark end").click()
        late.until_asked()
        review.get_by_role("button", name="Clear").click()
        review.get_by_role("tab", name="Statistics").click()
        for route in late.waiting:
            route.fulfill(status=409, content_type="application/json", body='{"error": "lost its way"}')
        page.wait_for_timeout(300)
        expect(review.locator(".run-side")).not_to_contain_text("lost its way")


BUFFERS = """() => {
  const kept = window.buffers = {now: 0};
  for (const [name, by] of [["createBuffer", 1], ["deleteBuffer", -1]]) {
    const own = WebGL2RenderingContext.prototype[name];
    WebGL2RenderingContext.prototype[name] = function (...given) {
      kept.now += by;
      return own.apply(this, given);
    };
  }
}"""


def test_marks_in_3d_give_their_shapes_back(browser, folder):
    with Studio(folder, world="quick.yaml") as studio, page_at(browser, studio.url) as page:
        page.evaluate(BUFFERS)
        page.get_by_role("button", name="3-D").click()
        expect(page.locator(".scene")).to_have_attribute("data-filled", "", timeout=PATIENCE)
        counts = [0, 1]
        # What is drawn late adds some once; marks that keep theirs would add some with each round.
        while len(counts) < 20 and len(set(counts[-3:])) > 1:
            for name in ("crate", "wall 1"):
                page.get_by_role("treeitem", name=name).click()
                expect(page.locator(".scene-canvas")).to_have_attribute("data-selected", name)
                page.evaluate(DRAWN)
            counts.append(page.evaluate("window.buffers.now"))
        assert len(set(counts[-3:])) == 1, counts


SPLITS = """() => {
  const own = String.prototype.split;
  window.splits = 0;
  String.prototype.split = function (by, ...more) {
    if (by === "\\n" && this.length > 2000) window.splits += 1;
    return own.call(this, by, ...more);
  };
}"""


def test_the_text_is_not_cut_into_lines_for_each_thing_in_it(browser, tmp_path):
    crates = "\n".join(f"  - {{name: c{k}, box: [0.1, 0.1, 0.1], at: [{k}, 0]}}" for k in range(200))
    (tmp_path / "many.yaml").write_text(f"mjsim: 1\nname: many\nobstacles:\n{crates}\n")
    with Studio(tmp_path, world="many.yaml") as studio, page_at(browser, studio.url) as page:
        page.get_by_role("treeitem", name="c3 ").wait_for()
        page.evaluate(SPLITS)
        page.locator(".cm-line").nth(1).click()
        page.keyboard.press("Control+End")
        page.keyboard.press("ArrowUp")
        expect(page.get_by_role("treeitem", name="c199 ")).to_have_attribute("aria-selected", "true")
        assert page.evaluate("window.splits") <= 4
