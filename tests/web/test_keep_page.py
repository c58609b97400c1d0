"""A browser keeps as an event what another one still drags, in real browsers."""

import pytest
from playwright.sync_api import expect

from mjsim.world import load_world
from tests.browser import browser as listener
from tests.web.test_joints_page import GATE, running

pytestmark = pytest.mark.slow


def test_the_rest_of_a_drag_is_kept_after_a_part_of_it_was(browser, tmp_path):
    with running(browser, tmp_path, GATE) as (studio, page), listener(studio.url) as other:

        def drag(to_deg, drag):
            other.say("touch", event={"lead": "gate", "joint": "swing", "to_deg": to_deg}, drag=drag)
            other.until("touched")
            other.until("tick")
            other.until("tick")

        page.get_by_role("tab", name="Events").locator("visible=true").click()
        keep, kept = (page.get_by_role("button", name=name) for name in ("Keep 1 as event", "Kept as events"))
        drag(5, "first")
        keep.click()
        expect(kept).to_be_disabled()
        for to_deg in (10, 15):
            drag(to_deg, "next")
        keep.click()
        expect(kept).to_be_disabled()
        page.keyboard.press("Control+s")
        expect(page.locator(".world .dot")).to_be_hidden()
    (event,) = load_world(tmp_path / "room.yaml").run.events
    assert (event.to_deg, [row[1] for row in event.then]) == (5, [10, 15])
