"""Plans in SVG are to scale, and come back as the walls that they show."""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import shapely

from mjsim.exchange import world_from_svg, write_svg
from mjsim.exchange.svg_out import solid_runs
from mjsim.world import World, load_world, parse_world, solid

WORLDS = Path(__file__).parents[2] / "worlds"
SVG = "{http://www.w3.org/2000/svg}"
ROOM = """
mjsim: 1
name: den
walls:
  - points: [[1, 1], [7, 1], [7, 5], [1, 5]]
    closed: true
    openings: [{at: 2, width: 0.9, name: exit, door: {}}, {segment: 2, at: 1, width: 1.2, sill: 0.9, head: 2.0}]
obstacles: [{name: chest, box: [0.8, 0.5, 0.4], at: [3, 3], heading_deg: 90}]
beacons: [{name: owl, at: [1.06, 3]}]
robots: [{name: scout, preset: pioneer3dx, at: [5, 3]}]
"""


def lines(path: Path, group: str) -> list[shapely.Geometry]:
    """Return the outlines of lines of a group with their widths, in metres, from the attributes alone."""
    found = []
    for shape in ElementTree.parse(path).find(f"{SVG}g[@id='{group}']"):
        if shape.tag != f"{SVG}text":
            points = np.array([pair.split(",") for pair in shape.get("points").split()], dtype=float) / 100 * [1, -1]
            line = shapely.LinearRing(points) if shape.tag == f"{SVG}polygon" else shapely.LineString(points)
            width = float(shape.get("stroke-width")) / 100
            found.append(line.buffer(width / 2, cap_style="flat", join_style="mitre"))
    return found


def test_walls_are_drawn_where_they_stand_as_thick_as_they_are(tmp_path):
    world = parse_world(ROOM).model_copy(update={"obstacles": ()})
    drawn = shapely.union_all(lines(write_svg(world, tmp_path / "den.svg"), "walls"))
    assert drawn.symmetric_difference(solid(world)).area < 1e-6


def test_the_paper_is_a_hundredth_of_the_room_and_says_all_names(tmp_path):
    root = ElementTree.parse(write_svg(parse_world(ROOM), tmp_path / "den.svg")).getroot()
    box = [float(value) for value in root.get("viewBox").split()]
    assert float(root.get("width").removesuffix("mm")) == pytest.approx(box[2] / 100 * 10)
    assert box[2] / 100 == pytest.approx(6.1 + 2)
    words = {text.text for text in root.iter(f"{SVG}text")}
    assert words == {"den, 6.1 x 4.1 m, 1 : 100", "1 m", "exit", "chest", "owl", "scout"}


@pytest.mark.parametrize("name", ["gallery", "maze"])
def test_a_plan_comes_back_as_the_same_walls(name, tmp_path):
    world = load_world(WORLDS / f"{name}.yaml").model_copy(update={"obstacles": (), "beacons": ()})
    back = world_from_svg(write_svg(world, tmp_path / "plan.svg"))
    corner = np.min([point for wall in world.walls for point in wall.points], axis=0)
    shape: shapely.Geometry = shapely.transform(solid(world), lambda points: points - corner)
    assert shape.boundary.hausdorff_distance(solid(back).boundary) < 0.01


def test_what_lies_on_the_floor_does_not_cover_the_walls(tmp_path):
    world = parse_world(ROOM + "floor: {patches: [{size: [3, 2], at: [1, 3], color: '#ff0000'}]}\n")
    root = ElementTree.parse(write_svg(world, tmp_path / "den.svg")).getroot()
    groups = [group.get("id") for group in root.iter(f"{SVG}g")]
    assert groups.index("things") < groups.index("walls") < groups.index("windows")


def test_a_world_without_anything_has_no_plan(tmp_path):
    from mjsim.errors import UsageError

    with pytest.raises(UsageError, match="no walls, things, people or robots; there is no plan to draw"):
        write_svg(World(), tmp_path / "plan.svg")


def test_openings_side_by_side_and_at_the_ends_of_a_wall_leave_what_stands_between():
    (wall,) = parse_world("""mjsim: 1
walls: [{points: [[0, 0], [4, 0], [4, 3]], openings: [
  {at: 0, width: 1}, {at: 1, width: 0.5}, {segment: 1, at: 2, width: 1}]}]
""").walls
    runs = solid_runs(wall, wall.openings)
    assert [(run.tolist(), closed) for run, closed in runs] == [([[1.5, 0.0], [4.0, 0.0], [4.0, 2.0]], False)]
