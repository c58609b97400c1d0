"""What is valid but implausible is reported with its place; what is plausible is let be."""

import os

import pytest

from mjsim.errors import WorldError
from mjsim.world import Opening, Source, Wall, World, check_world, load_world, parse_world, world_notes

ROOM = "walls: [{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true, thickness: 0.2, name: hall}]\n"
PICTURE = World().read_asset("posters/lion.jpg")


def told(text, source=None):
    return [str(problem) for problem in check_world(parse_world(text, file="w", source=source))]


@pytest.mark.parametrize(
    ("text", "doubt"),
    [
        (ROOM + "robots: [{name: a, at: [3, 4]}]", "w:2:24: robot 'a' at [3, 4] starts inside wall 'hall'"),
        (ROOM + "robots: [{name: a, at: [3, 0.3]}]", "w:2:24: robot 'a' at [3, 0.3] starts inside wall 'hall'"),
        (
            "robots: [{name: a, at: [1, 1]}]\nobstacles: [{cylinder: [0.1, 1], at: [1.3, 1]}]",
            "w:1:24: robot 'a' at [1, 1] starts inside obstacles[0]; its body needs 0.22 m free all around",
        ),
        (
            "robots: [{name: a, at: [1, 1]}, {name: b, at: [1.4, 1]}]",
            "w:1:47: robot 'b' at [1.4, 1] starts inside robot 'a'",
        ),
        ("walls: [{points: [[0, 0], [6000, 0]]}]", "w:1:8: the walls span 6000 m; lengths are in metres"),
        (
            ROOM + "beacons: [{name: r, at: [5.8, 2], marker: {dictionary: 4x4_50, id: 1}, width: 800}]",
            "w:2:79: beacon 'r' is 800 m wide; lengths are in metres",
        ),
        (
            "robots: [{name: a, at: [1, 1], sensors: [{camera: c, at: [100, 0, 1200]}]}]",
            "w:1:58: sensor 'c' is 1200 m away from its robot; lengths are in metres",
        ),
        (ROOM + "beacons: [{name: r, at: [6, 2]}]", "w:2:25: beacon 'r' at [6, 2] hangs inside wall 'hall'"),
        (
            ROOM + "beacons: [{name: r, at: [5.89, 2], heading_deg: 0, image: f.png}]",
            "w:2:25: beacon 'r' at [5.89, 2] faces into wall 'hall', where it cannot be seen; turn it around",
        ),
        (
            "walls: [{points: [[0, 0], [2, 0]], openings: [{at: 1.5, width: 0.9}]}]",
            "w:1:64: this opening goes from 1.5 to 2.4 m; segment 0 is 2 m long, keep it within",
        ),
        (
            "walls: [{points: [[0, 0], [4, 0]], openings: [{at: 1, width: 1}, {at: 1.9, width: 1}]}]",
            "w:1:66: this opening overlaps openings[0] of its wall",
        ),
        (
            "walls: [{points: [[0, 0], [4, 0]], height: 2, openings: [{at: 1, width: 1, head: 2.2}]}]",
            "w:1:82: head is 2.2 m; the wall is 2 m high, keep it below",
        ),
        (
            "walls: [{points: [[0, 0], [4, 0]], height: 1, openings: [{at: 1, width: 1, sill: 1.2}]}]",
            "w:1:82: sill is 1.2 m; the wall is 1 m high, keep it below",
        ),
        (
            ROOM + "shading: baked\nlamps: [{name: a, at: [3, 4]}]",
            "w:3:23: lamp 'a' at [3, 4] is inside wall 'hall' and lights nothing; move it out",
        ),
        (
            ROOM + "shading: baked\nceiling: {}\nlamps: [{at: [3, 2], height: 2.6}]",
            "w:4:30: lamps[0] is 2.6 m high, above the ceiling at 2.5 m, and lights nothing; lower it",
        ),
        (
            "robots: [{name: a, at: [1, 1], sensors: [{uwb: tag}]}]\nbeacons: [{name: r, at: [3, 3]}]",
            "w:1:48: tag 'tag' of robot 'a' has no anchors to measure in this world; add beacons with",
        ),
        (
            "robots: [{name: a, at: [1, 1], sensors: [{uwb: tag}]}]\n"
            "beacons: [{name: r, on: a, at: [0, 0], center: 1, anchor: true}]",
            "w:1:48: tag 'tag' of robot 'a' has no anchors to measure",
        ),
        (
            "robots: [{name: a, at: [1, 1]}]\n"
            "run: {events: [{time: 1, noise: robots.a.odometry.noise.trun, value: 1}]}",
            "w:2:33: robots.a.odometry.noise.trun: no key 'trun'; did you mean 'turn'?",
        ),
        (
            "robots: [{name: a, at: [1, 1]}]\nrun: {events: [{time: 1, noise: robots.a.odometry.ticks, value: 1}]}",
            "w:2:33: robots.a.odometry.ticks: ticks is 1.0; it must be a whole number",
        ),
    ],
)
def test_what_cannot_be_meant_is_told(text, doubt):
    (line,) = told(text, Source(file="w", attached={"f.png": PICTURE}))
    assert line.startswith(doubt)


@pytest.mark.parametrize(
    "text",
    [
        ROOM + "robots: [{name: a, at: [0.32, 0.32]}, {name: b, at: [0.76, 0.32]}]",
        ROOM
        + "beacons: [{name: r, at: [5.89, 2], heading_deg: 180, image: f.png}, {name: s, at: [0.1, 2], center: 3}]",
        ROOM + "beacons: [{name: r, at: [5.9, 2], heading_deg: 0}]",  # a reflector has no front
        "walls: [{points: [[0, 0], [4, 0]], openings: [{at: 1, width: 1}]}]\nrobots: [{name: a, at: [1.5, 0]}]",
        "walls: [{points: [[0, 0], [4, 0]], height: 1, openings: [{at: 1, width: 1}]}]",
        "walls: [{points: [[0, 0], [4, 0]], openings: [{at: 1, width: 1}, {at: 2, width: 2}]}]",
        "walls: [{points: [[0, 0], [4, 0]], openings: [{at: 1, width: 1, head: 1}, {at: 1, width: 1, sill: 1.5}]}]",
    ],
)
def test_what_can_be_meant_is_let_be(text):
    assert told(text, Source(file="w", attached={"f.png": PICTURE})) == []


def test_a_world_built_in_python_is_checked_too():
    world = World(walls=(Wall(points=((0, 0), (1, 0)), openings=(Opening(at=0.5, width=1),)),))
    (problem,) = check_world(world)
    assert str(problem).startswith("world:1:1: this opening goes from 0.5 to 1.5 m")


def test_a_link_that_leads_in_a_circle_beside_a_world_is_no_file_that_could_be_meant(tmp_path):
    (tmp_path / "poster.png").symlink_to("poster.png")
    os.mkfifo(tmp_path / "pasted.png")
    (tmp_path / "room.yaml").write_text("mjsim: 1\nbeacons: [{name: b, image: posted.png, at: [0, 0], width: 1}]\n")
    with pytest.raises(WorldError) as caught:
        load_world(tmp_path / "room.yaml")
    assert str(caught.value).endswith("no file 'posted.png' beside the world file or in assets")


@pytest.mark.parametrize("name", [b"qqq\xff.png", b"qqq\n.png"])
def test_a_file_whose_name_no_world_can_hold_is_not_meant(tmp_path, name):
    (tmp_path / os.fsdecode(name)).touch()
    (tmp_path / "room.yaml").write_text("mjsim: 1\nbeacons: [{name: b, image: qqq.png, at: [0, 0], width: 1}]\n")
    with pytest.raises(WorldError) as caught:
        load_world(tmp_path / "room.yaml")
    assert str(caught.value).endswith("no file 'qqq.png' beside the world file or in assets")


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
@pytest.mark.parametrize(("sill", "count"), [(2.0, 0), (1.9, 1)])
def test_a_window_may_stand_on_the_head_of_a_door_whichever_comes_first(order, sill, count):
    openings = ["{at: 1, width: 1, head: 2.0}", f"{{at: 1.2, width: 0.5, sill: {sill}, head: 2.4}}"]
    listed = ", ".join(openings[k] for k in order)
    assert len(told(f"walls: [{{points: [[0, 0], [4, 0]], openings: [{listed}]}}]")) == count


def test_a_start_outside_all_walls_is_a_note():
    walls = "walls: [{points: [[0, 0], [4, 0], [4, 3]]}]"
    robot = "robots: [{name: a, at: [%s], odometry: {noise: {distance: 0.0}}}]"
    assert not world_notes(parse_world(f"{walls}\n{robot % '3, 1'}"))
    (note,) = world_notes(parse_world(f"{walls}\n{robot % '3, -0.5'}"))
    assert note.message == "robot 'a' at [3, -0.5] starts outside the walls, which reach from [0, 0] to [4, 3]"
    assert not world_notes(parse_world(robot % "9, 9"))
    assert not world_notes(parse_world(f"walls: [{{points: [[0, 0], [4, 0]]}}]\n{robot % '3, -1'}"))
