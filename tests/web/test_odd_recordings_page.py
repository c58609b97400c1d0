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


def test_odd_recordings_are_opened_by_keys_and_compared(browser, tmp_path):
    expect.set_options(timeout=PATIENCE)
    for name, seconds in LENGTHS.items():
        with mjsim.Simulation(with_values(parse_world(ROOM), {"run.seconds": seconds}), seed=1) as sim:
            mjsim.run(sim, record=tmp_path / name)
    with Studio(tmp_path) as studio, page_at(browser, studio.url) as page:
        page.get_by_role("tab", name="Review", exact=True).click()
        review = page.locator("#view-review")
        for name in LENGTHS:
            entry = review.locator("[data-path]").filter(has_text=name)
            entry.press("Enter")
            expect(review.locator(".review-title")).to_have_text(name)
            expect(entry).to_have_attribute("aria-current", "true")
            expect(entry).to_be_focused()
        for name in list(LENGTHS)[:2]:
            review.get_by_label(f"Compare {name}").check()
        review.get_by_role("button", name="Compare 2 chosen").click()
        nees = review.locator(".compare .run-chart", has_text="NEES")
        # Where one of them has ended, its column has no value at all, which is no NEES either.
        expect(nees).to_have_class("run-chart unknown")
        assert "dead reckoning" in nees.locator(".run-chart-box").get_attribute("data-empty")
        # Words of other languages are longer: no tab lies beside the column.
        page.goto(f"{page.url.partition('#')[0]}?lang=en-XA#review")
        expect(review.get_by_role("tab", name="[Récórdíngs~]")).to_be_visible()
        review.locator("[data-path='longer.mcap']").click()
        assert max(review.locator(".run-side").evaluate(BEYOND)) <= 0
