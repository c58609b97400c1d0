"""Recordings of different length, of a single tick and with odd names in Review, in a real browser."""

import pytest
from playwright.sync_api import expect

import mjsim
from mjsim.web import Studio
from mjsim.world import parse_world, with_values
from tests.windows import PATIENCE, page_at

pytestmark = pytest.mark.slow
ROOM = """
mjsim: 1
walls: [{points: [[-2, -2], [2, -2], [2, 2], [-2, 2]], closed: true}]
robots: [{name: scout, preset: pioneer3dx, at: [0, 0]}]
run: {drivers: {scout: {navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[1, 0]]}}}}
"""
BEYOND = """side => [
  side.scrollWidth - side.clientWidth,
  ...[...side.querySelectorAll("[role=tab]")].map(tab => tab.offsetLeft + tab.offsetWidth - side.clientWidth),
]"""
"""How far a column, and each of its tabs, lie beyond its right edge [px]."""
LENGTHS = {"a'\"#&%2F <b>.mcap": 0.4, "longer.mcap": 0.8, "tick.mcap": 0.04}


def recordings_with_odd_names_are_opened_by_keys(review):
    for name in LENGTHS:
        entry = review.locator("[data-path]").filter(has_text=name)
        entry.press("Enter")
        expect(review.locator(".review-title")).to_have_text(name)
        expect(entry).to_have_attribute("aria-current", "true")
        expect(entry).to_be_focused()


def a_recording_that_comes_late_does_not_take_the_place_of_the_one_chosen_after_it(page, review):
    held = []
    page.route("**/api/recording?*tick*", lambda route: held.append(route))
    review.locator("[data-path='tick.mcap']").click()
    review.locator("[data-path='longer.mcap']").click()
    shown = review.locator(".run-time")
    expect(shown).to_contain_text("of 0.76 s")
    with page.expect_response("**/api/recording?*tick*") as late:
        held[0].continue_()
    assert late.value.ok
    late.value.body()
    page.wait_for_timeout(200)  # it would be taken up in this time
    expect(shown).to_contain_text("of 0.76 s")
    expect(review.locator(".review-title")).to_have_text("longer.mcap")


def those_of_different_length_are_compared(review):
    for name in list(LENGTHS)[:2]:
        review.get_by_label(f"Compare {name}").check()
    review.get_by_role("button", name="Compare 2 chosen").click()
    nees = review.locator(".compare .run-chart", has_text="NEES")
    # Where one of them has ended, its column has no value at all, which is no NEES either.
    expect(nees).to_have_class("run-chart unknown")
    assert "dead reckoning" in nees.locator(".run-chart-box").get_attribute("data-empty")


def words_of_other_languages_are_longer_and_no_tab_lies_beside_the_column(page, review):
    page.goto(f"{page.url.partition('#')[0]}?lang=en-XA#review")
    expect(review.get_by_role("tab", name="[Récórdíngs~]")).to_be_visible()
    review.locator("[data-path='longer.mcap']").click()
    assert max(review.locator(".run-side").evaluate(BEYOND)) <= 0


def test_odd_recordings_are_opened_in_order_and_compared(browser, tmp_path):
    expect.set_options(timeout=PATIENCE)
    for name, seconds in LENGTHS.items():
        with mjsim.Simulation(with_values(parse_world(ROOM), {"run.seconds": seconds}), seed=1) as sim:
            mjsim.run(sim, record=tmp_path / name)
    with Studio(tmp_path) as studio, page_at(browser, studio.url) as page:
        page.get_by_role("tab", name="Review", exact=True).click()
        review = page.locator("#view-review")
        recordings_with_odd_names_are_opened_by_keys(review)
        a_recording_that_comes_late_does_not_take_the_place_of_the_one_chosen_after_it(page, review)
        page.unroute_all()
        those_of_different_length_are_compared(review)
        words_of_other_languages_are_longer_and_no_tab_lies_beside_the_column(page, review)
