"""A newcomer is offered a tour and templates; both can be done by keys, and the tour is found again in the help."""

import re

import pytest
from playwright.sync_api import expect

from mjsim.web import Studio
from tests.web.test_axe_page import assert_faultless
from tests.windows import PATIENCE, page_at

pytestmark = pytest.mark.slow
TITLES = ("Build", "Find and change", "The text is the world", "Run", "Review and compare", "Help")


def test_the_tour_is_offered_once_goes_by_keys_and_is_found_again(browser, tmp_path):
    expect.set_options(timeout=PATIENCE)
    with Studio(tmp_path) as studio, page_at(browser, studio.url, width=1280, height=800) as page:
        offer = page.get_by_role("button", name="Take the six-step tour")
        offer.focus()
        page.keyboard.press("Enter")
        for number, title in enumerate(TITLES):
            card = page.get_by_role("dialog", name=title, exact=True)
            expect(card).to_contain_text(f"{number + 1} of 6")
            expect(card.get_by_role("button", name=re.compile("Next|Done"))).to_be_focused()
            expect(page.locator(".tour-spot")).to_be_visible()
            if number == 0:
                assert_faultless(page)
            page.keyboard.press("ArrowRight")
        page.keyboard.press("Enter")
        expect(page.get_by_role("dialog")).to_have_count(0)
        page.goto(studio.url)  # a reload has the world of the tour
        expect(page.get_by_text("Build a room for your robot")).to_be_visible()
        expect(offer).to_have_count(0)
        page.keyboard.press("?")
        page.get_by_role("button", name="Take the tour").click()
        expect(page.get_by_role("dialog", name="Build")).to_be_visible()
        page.keyboard.press("Escape")
        expect(page.get_by_role("dialog")).to_have_count(0)
        page.get_by_role("button", name="New world").first.click()
        expect(page.get_by_role("dialog")).to_contain_text("An office floor: twenty rooms along a corridor")
        page.get_by_role("dialog").get_by_role("button", name="corridor A long").click()
        expect(page.locator(".cm-content")).to_contain_text("name: corridor")
