"""Keys of the text are explained where the pointer rests on them, in a real browser."""

import pytest
from playwright.sync_api import expect

pytestmark = pytest.mark.slow

ROOM = """\
mjsim: 1
name: room
robots:
  - name: scout
    preset: pioneer3dx
    at: [1, 1]
    sensors:
      - {lidar: scan, beams: 180, range: [0.05, 10]}
obstacles:
  - {box: [1, 1, 1], at: [3, 3], elevation: 0.5}
run:
  map: unknown
  drivers:
    scout:
      navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[1, 1]]}
"""


def test_a_key_tells_its_unit_its_meaning_and_its_default(sheet):
    hint = sheet.page.locator(".cm-hint")
    for key, pieces in {
        "elevation": ["elevation [m]", "default 0"],
        "beams": ["beams", "default"],
        "map": ["map", "one of unknown, known"],
    }.items():
        sheet.text.locator("span").get_by_text(key, exact=True).hover()
        for piece in pieces:
            expect(hint).to_contain_text(piece)
