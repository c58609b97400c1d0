"""Every kind of thing that has a place is put down with the mouse, in a real browser."""

import pytest
from playwright.sync_api import expect

from mjsim.world import check_world, load_world
from tests.windows import NO_PICTURE, PATIENCE

pytestmark = pytest.mark.slow

STOOL = '<mujoco><worldbody><geom type="cylinder" size="0.2 0.25" pos="0 0 0.25"/></worldbody></mujoco>'
ROOM = """\
mjsim: 1
name: room
walls:
  - {points: [[0, 0], [16, 0], [16, 10], [0, 10]], closed: true}
"""


def portrait(route):
    """Answer with a blank one, or none of what is no model: test_studio_pictures looks at those of the server."""
    if "other.xml" in route.request.url:
        route.fulfill(status=409, json={"error": "no model"})
    else:
        route.fulfill(content_type="image/svg+xml", body=NO_PICTURE)


def test_every_kind_of_thing_is_put_down(sheet, tmp_path):
    sheet.press("m")
    kind = sheet.page.get_by_label("Kind")
    places = [(x, y) for y in (2, 5, 8) for x in (2, 5, 8, 11)]
    names = ["Ramp", "Steps", "Platform", "Sphere", "Area of floor", "Lamp", "Person", "Arm", "Mechanism"]
    for place, name in zip(places, names, strict=False):
        kind.select_option(name)
        sheet.click(*place)
        expect(sheet.page.locator(".outline-row[aria-selected=true]")).to_have_count(1)
        expect(sheet.page.locator(".problems")).to_have_text("No problems")
    kind.select_option("Model")
    (tmp_path / "own").mkdir()
    (tmp_path / "own" / "stool.xml").write_text(STOOL)
    (tmp_path / "own" / "other.xml").write_text("<html/>")
    sheet.page.route("**/api/portrait?*", portrait)
    sheet.page.get_by_title("Choose a model").click()
    cards = sheet.page.get_by_role("dialog").locator(".card")
    expect(cards).to_have_count(6)
    # Each is drawn, or its place says that it is not; the search leaves what it finds, and arrows go to it.
    drawn = "() => [...document.querySelectorAll('.gallery img')].every(each => each.naturalWidth === 4)"
    sheet.page.wait_for_function(drawn, timeout=PATIENCE)
    sheet.page.keyboard.type("own stool")
    expect(cards.locator("visible=true")).to_have_text(["stoolown/stool.xml"])
    sheet.page.get_by_label("Search").and_(sheet.page.get_by_role("dialog").locator("input")).fill("nothing")
    expect(sheet.page.get_by_role("dialog")).to_contain_text("Nothing matches 'nothing'; clear the search")
    sheet.page.keyboard.press("Control+a")
    sheet.page.keyboard.type("SHELF")
    sheet.page.keyboard.press("ArrowDown")
    expect(cards.filter(has_text="shelf")).to_be_focused()
    sheet.page.keyboard.press("Enter")
    sheet.drag((14, 5), (14, 7))
    sheet.reads("model: furniture/shelf.urdf, at: [14, 5], heading_deg: 90")
    kind.select_option("Ramp")
    sheet.drag((13, 1), (15, 2))
    sheet.reads("ramp: [2, 1, 0.2], at: [14, 1.5]")
    sheet.save()
    world = load_world(tmp_path / "room.yaml")
    assert [type(thing).__name__.removesuffix("Obstacle") for thing in world.obstacles] == [
        *("Ramp", "Steps", "Box", "Sphere", "Model", "Ramp")
    ]
    assert [len(things) for things in (world.floor.patches, world.lamps, world.people, world.mechanisms)] == [1] * 4
    assert (world.robots[0].name, world.robots[0].arms[0].preset) == ("arm", "motoman_up6")
    assert check_world(world) == []
