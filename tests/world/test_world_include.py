"""Worlds that include others, and what becomes of all that is reused: recordings, settings, and writing back."""

import gc
import shutil
import time

import pytest

from mjsim.errors import UsageError, WorldError
from mjsim.record import Recorder, read_recording, text_of
from mjsim.world import (
    Lamp,
    Modules,
    Robot,
    Run,
    Source,
    Use,
    Wall,
    World,
    expand,
    format_world,
    load_checked,
    load_world,
    needs_expansion,
    parse_world,
    read_asset,
    read_text,
    with_settings,
)
from tests.record_ticks import hand_made_ticks, infos


def world_of(tmp_path, files):
    """Write files and return the world of the first of them."""
    for name, text in files.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(text if isinstance(text, bytes) else ("mjsim: 1\n" + text).encode())
    return load_world(tmp_path / next(iter(files)))


def faults_of(tmp_path, files):
    with pytest.raises(WorldError) as caught:
        world_of(tmp_path, files)
    return str(caught.value).replace(f"{tmp_path}/", "").splitlines()


HALL = """\
variables: {width: 4, depth: "${width / 2}"}
name: hall
walls: [{points: [[0, 0], ["${width}", 0]], height: "${depth}"}]
floor: {color: "#111111", friction: 0.5, patches: [{at: [1, 1], size: [1, 1]}]}
run: {seconds: 9, rate_hz: 50, drivers: {a: {avoidance: true}, b: {avoidance: true}}}
robots: [{name: a, at: [1, 1]}, {name: b, at: [2, 1]}]
"""


def test_an_included_file_is_merged_and_the_including_one_is_right(tmp_path):
    world = world_of(
        tmp_path,
        {
            "main.yaml": "include: [parts/hall.yaml]\nvariables: {width: 6}\nwalls: [{points: [[0, 9], [1, 9]]}]\n"
            "floor: {friction: 0.7, patches: [{at: [3, 3], size: ['${depth}', 1]}]}\n"
            "run: {seconds: 5, drivers: {b: {avoidance: false}}}\n",
            "parts/hall.yaml": HALL,
        },
    )
    assert world.name == "hall"
    # The hall is as wide as the including file says, and what it computes from that is known outside.
    assert [wall.points for wall in world.walls] == [((0, 0), (6, 0)), ((0, 9), (1, 9))]
    assert world.walls[0].height == 3
    assert (world.floor.color, world.floor.friction) == ("#111111", 0.7)
    assert [patch.size for patch in world.floor.patches] == [(1, 1), (3, 1)]
    assert (world.run.seconds, world.run.rate_hz) == (5, 50)
    assert {name: driver.avoidance for name, driver in world.run.drivers.items()} == {"a": True, "b": False}


def test_faults_in_included_files_name_that_file_and_the_way_to_it(tmp_path):
    assert faults_of(
        tmp_path,
        {
            "main.yaml": "include:\n  - parts/a.yaml\nlamps: [{at: 3}]\n",
            "parts/a.yaml": "include: [deep/b.yaml]\nwals: []\n",
            "parts/deep/b.yaml": "walls:\n  - {points: [[0, 0], [0, 0]]}\n",
        },
    ) == [
        "main.yaml:4:14: at is 3 m; it must be [x, y]",
        "parts/a.yaml:3:1: unknown key 'wals'; did you mean 'walls'? (included by main.yaml:3:5)",
        "parts/deep/b.yaml:3:14: points[0] and points[1] are both [0, 0]; make them differ"
        " (included by parts/a.yaml:2:11, included by main.yaml:3:5)",
    ]


def test_an_included_file_that_is_not_there_or_no_world_is_told(tmp_path):
    (tmp_path / "up.yaml").write_text("mjsim: 1\n")
    found = faults_of(
        tmp_path,
        {
            "w/main.yaml": "include: [hal.yaml, ../up.yaml, /etc/passwd, list.yaml, broken.yaml, 3, bytes.yaml]\n",
            "w/hall.yaml": "",
            "w/list.yaml": b"[1]",
            "w/broken.yaml": "walls: [",
            "w/bytes.yaml": b"\xff\xfe",
        },
    )
    assert [line.replace("w/", "") for line in found] == [
        "broken.yaml:2:9: this is not YAML: expected the node content, but found '<stream end>';"
        " is the bracket opened at 2:8 closed? (included by main.yaml:2:57)",
        "bytes.yaml:1:1: character U+DCFF is not text; write the file as UTF-8 text (included by main.yaml:2:73)",
        "list.yaml:1:1: this is not a world file; one begins with 'mjsim: 1' (included by main.yaml:2:46)",
        "main.yaml:2:11: no file 'hal.yaml' beside the world file or in assets; did you mean 'hall.yaml'?",
        "main.yaml:2:21: path '../up.yaml' is outside its folder; name a file beside the world file or in assets",
        "main.yaml:2:33: path '/etc/passwd' is outside its folder; name a file beside the world file or in assets",
        "main.yaml:2:70: include names world files, such as include: [hall.yaml]",
    ]


def test_a_link_out_of_the_folder_is_not_followed(tmp_path):
    (tmp_path / "secret.yaml").write_text("mjsim: 1\n")
    (tmp_path / "w").mkdir()
    (tmp_path / "w" / "link.yaml").symlink_to(tmp_path / "secret.yaml")
    (line,) = faults_of(tmp_path, {"w/main.yaml": "include: [link.yaml]\n"})
    assert "path 'link.yaml' is outside its folder" in line


@pytest.mark.slow
def test_loops_and_towers_of_includes_are_refused(tmp_path):
    assert faults_of(tmp_path, {"a.yaml": "include: [b.yaml]\n", "b.yaml": "include: [a.yaml]\n"}) == [
        "b.yaml:2:11: this includes itself: a.yaml > b.yaml > a.yaml; leave one of them out (included by a.yaml:2:11)"
    ]
    tower = {f"{index}.yaml": f"include: [{index + 1}.yaml]\n" for index in range(16)} | {"16.yaml": ""}
    assert world_of(tmp_path, tower).name == "world"
    (line,) = faults_of(tmp_path, {**tower, "16.yaml": "include: [17.yaml]\n", "17.yaml": ""})
    assert line.startswith("16.yaml:2:11: includes are nested more than 16 deep; include fewer files (included by 15")
    wide = {f"{index}.yaml": f"include: [{index + 1}.yaml, {index + 1}.yaml]\n" for index in range(16)}
    lines = faults_of(tmp_path, {**wide, "16.yaml": ""})
    assert "files are included more than 1000 times; include fewer" in lines[0]


def test_pictures_named_in_an_included_file_are_looked_for_beside_it_first(tmp_path):
    picture = read_asset("posters/lion.jpg", Source())
    beacon = "beacons: [{{name: {0}, image: {1}, at: [0, 0]}}]\n"
    world = world_of(
        tmp_path,
        {
            "main.yaml": "include: [parts/a.yaml, parts/b.yaml, parts/c.yaml, parts/d.yaml]\n",
            "parts/a.yaml": beacon.format("a", "mine.jpg"),
            "parts/b.yaml": beacon.format("b", "top.jpg"),
            "parts/c.yaml": beacon.format("c", "posters/lion.jpg"),
            "parts/d.yaml": beacon.format("d", "../other/mine.jpg"),
            "parts/mine.jpg": picture,
            "top.jpg": picture,
            "other/mine.jpg": picture,
        },
    )
    assert [beacon.image for beacon in world.beacons] == [
        "parts/mine.jpg",
        "top.jpg",
        "posters/lion.jpg",
        "other/mine.jpg",
    ]


def test_checks_and_settings_work_on_what_was_expanded(tmp_path):
    files = {
        "main.yaml": "include: [a.yaml]\nrobots: [{name: r, at: [1, 1], repeat: {times: 2, offset: [4, 0]}}]\n",
        "a.yaml": "variables: {w: 3}\nobstacles: [{name: box, box: [1, 1, 1], at: ['${w}', 3]}]\n",
    }
    world = world_of(tmp_path, files)
    assert with_settings(world, ["robots.r-2.at=[5, 5]"]).robots[1].at == (5, 5)
    assert with_settings(world, ["variables.w=6", "run.seconds=3"]).obstacles[0].at == (6, 3)
    with pytest.raises(UsageError, match=r"--set variables\.v=6: no variable 'v'; there are w"):
        with_settings(world, ["variables.v=6"])
    world_of(tmp_path, {**files, "a.yaml": files["a.yaml"].replace("${w}", "${w + 2}").replace("3]", "1]")})
    with pytest.raises(WorldError) as caught:
        load_checked(tmp_path / "main.yaml")
    assert "main.yaml:3:24: robot 'r-2' at [5, 1] starts inside obstacle 'box'" in str(caught.value)
    assert str(caught.value).endswith("(in repetition 2)")


def test_a_text_that_uses_none_of_the_three_is_not_expanded():
    assert not needs_expansion("mjsim: 1\nwalls:\n  - {points: [[0, 0], [4, 0]]}   # $ and { alone\n")
    assert needs_expansion('light: "\\x24{1}"\n')
    assert parse_world('mjsim: 1\nlight: "\\x24{1 + 1}"\n').light == 2


@pytest.mark.slow
def test_expansion_takes_time_in_proportion():
    taken = {2000: [], 8000: []}
    gc.disable()  # what other tests have left would be looked through again and again
    try:
        for times in (2000, 8000) * 3:
            text = f"mjsim: 1\nlamps: [{{at: [0, '${{i / 10}}'], repeat: {{times: {times}}}}}]\n"
            node, _ = read_text(text, file="x.yaml")
            start = time.process_time()
            assert len(expand(node, Source()).node.value["lamps"]) == times
            taken[times].append(time.process_time() - start)
    finally:
        gc.enable()
    assert min(taken[8000]) < 12 * min(taken[2000])  # 4 times, and room for a busy machine


def test_a_recording_holds_the_included_files_and_gives_the_world_from_itself_alone(tmp_path):
    picture = read_asset("posters/lion.jpg", Source())
    world = world_of(
        tmp_path,
        {
            "w/main.yaml": "include: [parts/hall.yaml]\nvariables: {width: 6}\n",
            "w/parts/hall.yaml": HALL + "beacons: [{name: lion, image: lion.jpg, at: [1, '${width}']}]\n",
            "w/parts/lion.jpg": picture,
        },
    )
    with Recorder(tmp_path / "run.mcap", world=world, seed=1, robots=infos(), metadata={}) as recorder:
        recorder.write(next(hand_made_ticks(1)))
    shutil.rmtree(tmp_path / "w")
    again = read_recording(tmp_path / "run.mcap").world
    assert again == world
    assert again.source.text == world.source.text
    assert again.read_asset("parts/lion.jpg") == picture


REUSED = """\
include: [parts/hall.yaml]   # the walls
variables: {width: 6, high: 2}

obstacles:
  - {name: post, cylinder: [0.1, "${high}"], at: [1, 1], repeat: {times: 3, offset: [1, 0]}}   # three of them
  - {name: table, box: [1, "${width / 6}", 0.7], at: ["${width / 2}", 4]}   # in the middle
"""


@pytest.fixture
def reused(tmp_path):
    return world_of(tmp_path, {"main.yaml": REUSED, "parts/hall.yaml": HALL})


def test_a_change_beside_expressions_keeps_all_that_it_does_not_concern(reused):
    post, table = reused.obstacles[:3], reused.obstacles[3]
    lamp = Lamp(at=(1, 2), name="new")
    moved = table.model_copy(update={"at": (3, 5)})
    floor = reused.floor.model_copy(update={"friction": 0.25})
    walls = (*reused.walls, Wall(points=((0, 0), (0, 5))))
    run = reused.run.model_copy(update={"seconds": 77})
    update = {"obstacles": (*post, moved), "lamps": (lamp,), "floor": floor, "walls": walls, "run": run}
    changed = reused.model_copy(update=update)
    text = format_world(changed)
    assert format_world(reused) == reused.source.text
    assert parse_world(text, source=reused.source) == changed
    for kept in ("# the walls", "# three of them", "# in the middle", '"${high}"', '"${width / 6}"', '"${width / 2}"'):
        assert kept in text
    assert "points: [[0, 0], [0, 5]]" in text
    assert "${width}" not in text, "the walls of the hall stay in their own file"


def test_a_change_of_what_stands_elsewhere_is_refused_with_the_place_where_it_stands(reused, tmp_path):
    painted = reused.obstacles[1].model_copy(update={"color": "#000000"})
    post = (reused.obstacles[0], painted, *reused.obstacles[2:])
    hall = "is written in parts/hall.yaml; change it there (included by main.yaml:2:11)"
    wall = reused.walls[0].model_copy(update={"thickness": 0.3})
    for update, line in (
        (
            {"obstacles": post},
            "main.yaml:6:5: obstacles[1] is one repetition of the item in line 6; change it in the text"
            " (in repetition 2)",
        ),
        ({"walls": (wall,)}, f"parts/hall.yaml:4:9: walls[0] {hall}"),
        ({"walls": ()}, f"parts/hall.yaml:4:8: walls {hall}"),
        (
            {"obstacles": reused.obstacles[::-1]},
            "main.yaml:6:5: obstacles[0] is one repetition of the item in line 6; change it in the text"
            " (in repetition 1)",
        ),
    ):
        with pytest.raises(WorldError) as caught:
            format_world(reused.model_copy(update=update))
        assert str(caught.value).replace(f"{tmp_path}/", "") == line


def test_a_text_with_the_signs_of_an_expression_is_written_so_that_it_stays_one():
    use = Use.model_validate({"use": "a:B", "label": "${w}", "other": "$${w}"})
    world = World(robots=(Robot(name="r", at=(0, 0)),), run=Run(drivers={"r": Modules(navigator=use)}))
    text = format_world(world)
    assert parse_world(text) == world
    assert parse_world(text_of(world, {})) == world
