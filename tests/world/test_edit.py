"""A world is changed in its own text: what changes is written, every other character stays."""

import copy
import difflib
import re
from pathlib import Path
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mjsim.web.worlds.items import scene_of
from mjsim.world import Change, Source, UnwritableError, World, edit_text, parse_world, read_text
from mjsim.world.edit.edited_text import same
from tests.odd_texts import COMMENT, OddText, random_value

WORLDS = Path(__file__).parents[2] / "worlds"
SOURCE = Source(file="room.yaml", folder=WORLDS)
NAMES = ("gallery", "empty", "corridor", "arena", "sensors", "cloister", "maze", "ramps", "dark")
TEXTS = {name: (WORLDS / f"{name}.yaml").read_text(encoding="utf-8") for name in (*NAMES, "office", "warehouse")}
ROOM = """\
mjsim: 1   # the version

# What stands around.
walls:
  - points: [[0, 0], [6, 0],
             [6, 4.0], [0, 4]]   # counter-clockwise
    closed: true
  - {points: [[1, 1], [2, 1]]}   # a screen

obstacles: []   # none yet
"""


def edited(text, *changes):
    return edit_text(text, [Change(*change) for change in changes], source=SOURCE)


def comments(text):
    return re.findall(r"(?:^|\s)(#[^\n]*)", text)


def changed_lines(before, after):
    """Return the lines that are gone, and those that are new."""
    told = list(difflib.ndiff(before.splitlines(), after.splitlines()))
    return [line[2:] for line in told if line[:2] == "- "], [line[2:] for line in told if line[:2] == "+ "]


def places(value, path=()):
    """Yield the paths of all keys and items."""
    pairs = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for step, item in pairs:
        yield (*path, step)
        yield from places(item, (*path, step))


def at(value, path):
    for step in path:
        value = value[step]
    return value


def after(value, change):
    """Return a plain value with a change, worked out without any text."""
    value = copy.deepcopy(value)
    path = change.path
    holder = at(value, path[:-1])
    if change.op == "set":
        holder[path[-1]] = change.value
    elif change.op == "add" and isinstance(path[-1], int):
        holder.insert(path[-1], change.value)
    elif change.op == "add":
        holder.setdefault(path[-1], []).append(change.value)
    else:
        del holder[path[-1]]
    return value


def any_change(random, value):
    """Return some change of a plain value."""
    paths = [path for path in places(value) if path != ("mjsim",)]
    op = random.choice(["set", "key", "add", "before", "out"])
    lists = [path for path in paths if isinstance(at(value, path), list)]
    if op == "key" or not paths:
        holders = [path for path in ((), *paths) if isinstance(at(value, path), dict)]
        return Change("set", (*random.choice(holders), "new"), random_value(random, 1))
    if op in ("add", "before") and lists:
        path = random.choice(lists)
        index = random.randint(0, len(at(value, path)))
        last = path if op == "add" and isinstance(path[-1], str) else (*path, index)
        return Change("add", last, random_value(random, 1))
    path = random.choice(paths)
    if op == "out":
        return Change("remove" if isinstance(path[-1], int) else "unset", path)
    return Change("set", path, random_value(random, random.choice([0, 2])))


@pytest.mark.slow
@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.randoms(use_true_random=False))
def test_whatever_is_changed_in_whatever_layout_the_text_says_it_and_keeps_its_comments(random):
    value = {"mjsim": 1, **{f"q{k}": random_value(random) for k in range(random.randint(1, 4))}}
    text = OddText(random, value).text
    node, _ = read_text(text, file="x")
    change = any_change(random, value)
    new = edit_text(text, [change])
    assert same(node.value, value)
    assert same(read_text(new, file="x")[0].value, after(value, change))
    if change.op == "add" or change.path[-1] == "new":
        assert COMMENT.findall(new) == COMMENT.findall(text)
        gone, _ = changed_lines(text, new)
        assert len(gone) <= 1


def change_of_world(draw, world):
    """Draw a change that somebody makes with the mouse: something is moved, turned, painted, added or removed."""
    kinds = [kind for kind in ("walls", "obstacles", "beacons", "robots") if getattr(world, kind)]
    kind = draw(st.sampled_from(kinds))
    index = draw(st.integers(0, len(getattr(world, kind)) - 1))
    item = getattr(world, kind)[index]
    number = draw(st.integers(-40, 40)) / 8
    op = draw(st.sampled_from(["move", "value", "add", "remove"]))
    if op == "remove" and kind != "robots":
        return Change("remove", (kind, index))
    if op == "add":
        new = {"box": [0.5, abs(number) + 0.5, 1.0], "at": [number, 2.0], "heading_deg": 30.0}
        return Change("add", ("obstacles",), new)
    if op == "value":
        keys = {"walls": "height", "obstacles": "elevation", "beacons": "width", "robots": "proximity_range"}
        return Change("set", (kind, index, keys[kind]), abs(number) + 1.0)
    if kind == "walls":
        x, y = item.points[1]
        return Change("set", (kind, index, "points", 1), [round(x + number, 4), round(y + 0.01, 4)])
    return Change("set", (kind, index, "at"), [round(item.at[0] + number, 4), round(item.at[1], 4)])


def world_after(world, change):
    """Return the world with a change, by its models."""
    tree = world.model_dump(exclude_unset=True)
    for kind in ("walls", "obstacles"):
        tree[kind] = [*tree.get(kind, ())]
        for item in tree[kind]:
            item.update({"points": [*item["points"]]} if kind == "walls" else {})
    changed = World.model_validate(after(_lists(tree), change), context={"source": SOURCE})
    changed._source = world.source
    return changed


def _lists(value):
    if isinstance(value, dict):
        return {key: _lists(item) for key, item in value.items()}
    return [_lists(item) for item in value] if isinstance(value, (list, tuple)) else value


def check_a_change(data, name):
    text = TEXTS[name]
    world = parse_world(text, source=SOURCE)
    change = change_of_world(data.draw, world)
    try:
        wanted = world_after(world, change)
    except ValueError:
        return  # No such world: a wall without length, a driver without its robot.
    try:
        new = edit_text(text, [change], source=SOURCE)
    except UnwritableError:
        raw, _ = read_text(text, file="x")
        items = {tuple(item["path"]): item for item in scene_of(world, raw)["items"]}
        item = items[change.path[:2]]
        assert item["fixed"] or item["computed"]
        return
    assert parse_world(new, source=SOURCE) == wanted
    gone, come = changed_lines(text, new)
    if change.op == "set":
        assert len(gone) <= 1
        assert comments(new) == comments(text)
    elif change.op == "add":
        assert (gone, len([line for line in come if line.strip()])) in (([], 1), ([], 2))
        assert comments(new) == comments(text)
    else:
        assert [line for line in come if line.strip()] in ([], [f"{change.path[0]}: []"])
    assert edit_text(text, [], source=SOURCE) == text


@pytest.mark.slow
@settings(max_examples=12, deadline=None, derandomize=True)
@given(st.data())
def test_a_changed_text_reads_as_the_world_with_that_change_and_all_else_stays(data):
    check_a_change(data, data.draw(st.sampled_from(("empty", "dark"))))


@pytest.mark.slow
@settings(max_examples=16, deadline=None, derandomize=True)
@given(st.data())
def test_shipped_worlds_are_changed_where_they_can_be(data):
    check_a_change(data, data.draw(st.sampled_from(sorted(TEXTS))))


@pytest.mark.slow
def test_every_comment_is_kept_through_fifty_edits():
    random, text, added = Random(7), TEXTS["gallery"], 0
    before, world = comments(text), parse_world(text, source=SOURCE)
    for _ in range(50):
        kind = random.choice(["obstacles", "beacons", "robots"])
        index = random.randrange(len(getattr(world, kind)))
        place = [round(random.uniform(0.0, 9.0), 2), round(random.uniform(0.0, 9.0), 2)]
        ways = [
            Change("set", (kind, index, "at"), place),
            Change("set", (kind, index, "heading_deg"), random.randint(-179, 180)),
            Change("unset", (kind, index, "heading_deg")),
            Change("add", ("obstacles",), {"box": [1, 1, 1], "at": place}),
            Change("set", ("floor", "friction"), round(random.uniform(0.1, 2.0), 3)),
            Change("set", ("run", "seconds"), random.randint(1, 99)),
        ]
        if added:
            ways.append(Change("remove", ("obstacles", len(world.obstacles) + added - 1)))
        change = random.choice(ways)
        try:
            text = edit_text(text, [change], source=SOURCE)
        except UnwritableError:
            continue
        added += {"add": 1, "remove": -1}.get(change.op, 0)
        assert comments(text) == before
    assert len(parse_world(text, source=SOURCE).obstacles) == len(world.obstacles) + added
    assert len(changed_lines(TEXTS["gallery"], text)[1]) > 10


def test_moving_a_thing_changes_its_numbers_and_nothing_else():
    new = edited(TEXTS["gallery"], ("set", ("obstacles", 3, "at"), [8.4, 5.125]))
    assert new == TEXTS["gallery"].replace("at: [8.4, 5.6]", "at: [8.4, 5.125]")
    assert edited(TEXTS["gallery"], ("set", ("obstacles", 3, "at"), [8.4, 5.6])) == TEXTS["gallery"]


def test_computed_numbers_are_written_short_and_typed_ones_as_they_are():
    new = edited(ROOM, ("set", ("walls", 1, "height"), 0.1 + 0.2), ("set", ("walls", 1, "thickness"), 0.09751))
    assert "- {points: [[1, 1], [2, 1]], height: 0.3, thickness: 0.09751}   # a screen" in new
    assert "height: 0.00001235" in edited(ROOM, ("set", ("walls", 1, "height"), 0.0000123456789))


def test_the_corner_of_a_wall_is_put_in_and_taken_out_in_its_line():
    more = edited(ROOM, ("set", ("walls", 0, "points"), [[0, 0], [3, -1], [6, 0], [6, 4], [0, 4]]))
    assert "- points: [[0, 0], [3, -1], [6, 0],\n             [6, 4.0], [0, 4]]   # counter-clockwise" in more
    assert edited(more, ("remove", ("walls", 0, "points", 1))) == ROOM


def test_what_is_added_looks_like_its_neighbours():
    new = edited(ROOM, ("add", ("walls",), {"points": [[0, 2], [3, 2]], "height": 1.0}))
    assert "  # a screen\n  - {points: [[0, 2], [3, 2]], height: 1}\n\nobstacles" in new
    new = edited(ROOM, ("add", ("obstacles",), {"box": [1, 1, 1], "at": [3, 3]}))
    assert "obstacles:   # none yet\n  - {box: [1, 1, 1], at: [3, 3]}\n" in new
    robot = {"name": "scout", "preset": "pioneer3dx", "at": [1, 1], "sensors": [{"camera": "front"}]}
    new = edited(ROOM, ("add", ("robots",), robot))
    assert new.endswith(
        "\nrobots:\n  - name: scout\n    preset: pioneer3dx\n    at: [1, 1]\n    sensors:\n      - {camera: front}\n"
    )


def test_a_long_wall_fills_lines_with_its_corners():
    new = edited(ROOM, ("add", ("walls",), {"points": [[k + 0.25, 10 + k % 2] for k in range(20)]}))
    assert max(map(len, new.splitlines())) <= 120
    assert "  - points: [[0.25, 10], [1.25, 11], " in new
    assert "\n             [9.25, 11], " in new
    assert len(parse_world(new).walls[2].points) == 20


def test_a_second_opening_of_a_long_line_stands_below_it_and_not_at_its_end():
    wall = "walls:\n  - {points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true, height: 2.5, "
    text = f"mjsim: 1\n{wall}openings: [{{segment: 0, at: 1, width: 1}}]}}\n"
    more = [{"segment": number, "at": 3, "width": 1.2, "sill": 0.9, "head": 2} for number in (1, 2)]
    for opening in more:
        text = edit_text(text, [Change("add", ("walls", 0, "openings"), opening)])
    first, *others = text.splitlines()[2:]
    assert first.endswith(", openings: [{segment: 0, at: 1, width: 1},")
    assert others == [
        "        {segment: 1, at: 3, width: 1.2, sill: 0.9, head: 2},",
        "        {segment: 2, at: 3, width: 1.2, sill: 0.9, head: 2}]}",
    ]


def test_keys_come_where_people_look_for_them_with_those_around_them():
    new = edited(TEXTS["gallery"], ("set", ("robots", 0, "body", "color"), "#2a5fa8"))
    assert '0.02}}\n    body: {color: "#2a5fa8"}\n    odometry:' in new
    assert edited(new, ("unset", ("robots", 0, "body", "color"))) == TEXTS["gallery"]
    new = edited(ROOM, ("set", ("walls", 1, "name"), "screen"))
    assert "- {name: screen, points:" in new


def test_what_goes_takes_its_own_comments_along_and_no_others():
    new = edited(ROOM, ("remove", ("walls", 1)))
    assert new == ROOM.replace("  - {points: [[1, 1], [2, 1]]}   # a screen\n", "")
    new = edited(ROOM, ("remove", ("walls", 0)))
    assert "# What stands around.\nwalls:\n  - {points: [[1, 1], [2, 1]]}   # a screen\n" in new
    new = edited(ROOM, ("remove", ("walls", 0)), ("remove", ("walls", 0)))
    assert "# What stands around.\nwalls: []\n\nobstacles" in new
    new = edited(ROOM, ("unset", ("obstacles",)))
    assert new == ROOM.removesuffix("\nobstacles: []   # none yet\n")


def test_a_door_stays_when_its_last_key_goes_and_empty_noise_does_not():
    text = "mjsim: 1\nwalls:\n  - {points: [[0, 0], [4, 0]], openings: [{at: 1, width: 1, door: {hinge: right}}]}\n"
    assert "door: {}}" in edited(text, ("unset", ("walls", 0, "openings", 0, "door", "hinge")))
    text = "mjsim: 1\nrobots:\n  - name: scout\n    at: [1, 1]\n    drive: {noise: {turn: 0.1}}\n"
    assert edited(text, ("unset", ("robots", 0, "drive", "noise", "turn"))).endswith("    at: [1, 1]\n")


def test_a_robot_with_another_name_keeps_what_stands_under_the_old_one():
    new = edited(
        TEXTS["empty"], ("rename", ("run", "drivers", "scout"), "rover"), ("set", ("robots", 0, "name"), "rover")
    )
    gone, come = changed_lines(TEXTS["empty"], new)
    assert [line.strip() for line in come] == ["- name: rover", "rover:"]
    assert [line.strip() for line in gone] == ["- name: scout", "scout:"]


def test_many_things_change_in_one_step():
    moves = [("set", ("obstacles", k, "at"), [k + 0.5, 1.0]) for k in range(6)]
    new = edited(TEXTS["gallery"], *moves, ("remove", ("obstacles", 5)), ("remove", ("obstacles", 0)))
    world = parse_world(new)
    assert [item.at for item in world.obstacles] == [(k + 0.5, 1.0) for k in range(1, 5)]
    twice = edited(ROOM, ("set", ("walls", 0, "points", 0), [1, 1]), ("set", ("walls", 0, "points"), [[0, 0], [9, 9]]))
    assert parse_world(twice).walls[0].points == ((0.0, 0.0), (9.0, 9.0))


def test_ends_of_lines_stay_as_they_are():
    new = edited(ROOM.replace("\n", "\r\n"), ("add", ("obstacles",), {"sphere": 0.2, "at": [1, 1]}))
    assert new.count("\n") == new.count("\r\n") == ROOM.count("\n") + 1


@pytest.mark.slow
def test_what_is_not_written_here_once_is_refused_in_a_line(tmp_path):
    (tmp_path / "hall.yaml").write_text(
        "walls: [{points: [[0, 0], [4, 0]]}]\nfloor: {friction: 0.5}\nradio: {range: 3}\n"
    )
    text = """\
mjsim: 1
include: [hall.yaml]
variables: {w: 3}
walls:
  - {points: [[0, 1], ["${w}", 1]], height: &h 2, color: "#112233"}
  - {points: [[0, 2], [1, 2]], height: *h, repeat: {times: 2, offset: [0, 1]}}
robots: [{name: scout, preset: pioneer3dx, at: [1, 5]}]
"""
    source = Source(file="room.yaml", folder=tmp_path)

    def refused(*change):
        with pytest.raises(UnwritableError) as caught:
            edit_text(text, [Change(*change)], source=source)
        return str(caught.value)

    assert refused("set", ("walls", 0, "height"), 3) == "walls[0] is written in hall.yaml; change it there"
    assert refused("remove", ("walls", 0)) == "walls[0] is written in hall.yaml; change it there"
    assert refused("set", ("walls", 1, "points", 1), [4, 1]) == (
        "walls[1].points[1][0] is computed by ${w}; change it in the text"
    )
    assert refused("set", ("walls", 3, "height"), 3) == (
        "walls[3] is one repetition of the item in line 6; change it in the text"
    )
    assert refused("set", ("walls", 1, "height"), 3).startswith("walls[1].height is written once for several places")
    assert refused("set", ("radio", "loss"), 0.1) == "radio is written in hall.yaml; change it there"
    assert refused("unset", ("floor", "friction")) == "floor.friction is written in hall.yaml; change it there"
    assert refused("set", ("walls", 9, "height"), 3).startswith("walls[9] is not there")
    assert refused("set", ("robots", 0, "sensors", 0, "width"), 3).startswith("robots[0].sensors[0].width is not there")
    assert refused("set", ("walls", 1, "height"), float("nan")).startswith("walls[1].height cannot be written")

    def kept(*change):
        return parse_world(edit_text(text, [Change(*change)], source=source), source=source)

    # Beside the same number an expression stays, and what is merged key by key is added to.
    assert kept("set", ("walls", 1, "points", 1), [3, 1.5]).walls[1].points[1] == (3.0, 1.5)
    assert kept("set", ("floor", "color"), "#000000").floor.friction == 0.5
    assert kept("set", ("walls", 1, "points", 1, 0), "${w + 1}").walls[1].points[1] == (4.0, 1.0)
    assert len(kept("add", ("walls",), {"points": [[7, 7], [8, 8]]}).walls) == 5


def test_a_text_that_is_no_yaml_is_not_changed():
    with pytest.raises(UnwritableError, match="the text cannot be edited here: it is not YAML"):
        edited("mjsim: 1\nwalls: [", ("set", ("name",), "x"))


def test_a_text_that_stands_for_more_than_there_is_room_for_is_refused_at_once():
    laughs = "mjsim: 1\na: &a0 [x, x]\n" + "".join(f"b{k}: &a{k + 1} [*a{k}, *a{k}, *a{k}]\n" for k in range(30))
    for text in (laughs, "mjsim: 1\nname: " + "[" * 2000, "mjsim: 1\nname: " + "[" * 600 + "]" * 600):
        with pytest.raises(UnwritableError):
            edited(text, ("set", ("name",), "x"))


def test_a_text_with_a_mistake_is_changed_where_it_is_right():
    new = edited(ROOM.replace("closed: true", "closed: perhaps"), ("set", ("walls", 1, "height"), 1.0))
    assert "[2, 1]], height: 1}" in new


@pytest.mark.parametrize("op", ["set", "unset", "add", "remove", "rename", "single", "apart"])
@pytest.mark.parametrize("path", [("walls",), ("walls", 0), ("walls", 0, "height"), ("walls", 0, "points", 0)])
def test_what_stands_under_a_key_that_is_written_twice_is_not_changed(op, path):
    text = "mjsim: 1\nwalls:\n  - {points: [[0, 0], [1, 0]], height: 2}\nwalls: []\n"
    with pytest.raises(UnwritableError, match=r"^walls is written twice; remove one of them in the text$"):
        edit_text(text, [Change(op, path, "one" if op == "rename" else [1.0] if op == "add" else 1.0)])
