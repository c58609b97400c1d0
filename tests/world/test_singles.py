"""Items that are repeated or included become items of their own; the world stays as it is."""

import pytest

from mjsim.world import Change, UnwritableError, edit_text, load_world, parse_world
from mjsim.world.files import Source

ROWS = """\
mjsim: 1
variables: {w: 2, paint: "#c8b8a0"}
obstacles:
  - {sphere: 0.2, at: [-3, 0]}
  # A row of desks.
  - {name: desk, box: ["${w}", 0.8, 0.75], at: ["${w - 0.5}", 1],
     color: "${paint}", repeat: {times: 3, offset: [2.4, 0]}} # oak
  - name: chair
    cylinder: [0.25, 0.9]   # with its back
    at: [1.5, 2.5]
    repeat:
      - {times: 2, offset: [0, 1.0]}
      - {times: 2, offset: [2.4, 0]}
  - {name: column, box: [0.3, 0.3, 2.5], at: [9, 7], repeat: {times: 8, turn_deg: 45, about: [7.5, 7]}}
  - {name: "crate-${i}", box: [0.4, 0.4, "${0.2 * (i + 1)}"], at: [0.5, 8], repeat: {times: 4, offset: [0.8, 0]}}
  - {name: post, cylinder: [0.1, 1], at: [20, 8]} # alone
"""


def single(text, *path, source=None):
    return edit_text(text, [Change("single", path)], **({"source": source} if source else {}))


@pytest.mark.parametrize("index", [1, 3, 4, 7, 8, 15, 16, 19])
def test_a_repeated_item_becomes_as_many_and_the_world_stays(index):
    found = single(ROWS, "obstacles", index)
    assert parse_world(found) == parse_world(ROWS)
    assert found.count("repeat") == ROWS.count("repeat") - 1
    for comment in ("# A row of desks.", "# oak", "# with its back", "# alone"):
        assert comment in found
    assert single(found, "obstacles", index) == found  # it is one already


def test_what_says_the_same_for_all_stays_an_expression():
    assert single(ROWS, "obstacles", 2).splitlines()[5:9] == [
        '  - {name: desk-1, box: ["${w}", 0.8, 0.75], at: ["${w - 0.5}", 1],',
        '     color: "${paint}"} # oak',
        '  - {name: desk-2, box: ["${w}", 0.8, 0.75], at: [3.9, 1], color: "${paint}"}',
        '  - {name: desk-3, box: ["${w}", 0.8, 0.75], at: [6.3, 1], color: "${paint}"}',
    ]


def test_repeats_inside_a_repeated_item_are_written_out_with_it():
    text = """\
mjsim: 1
walls:
  - name: bay
    points: [[0, 0], [9, 0]]
    openings:
      - {name: "slit", segment: 0, at: 1, width: "${0.2 + 0.1 * i + 0.1 * j}", repeat: {times: 3, offset: 2}}
    repeat: {times: 2, offset: [0, 3]}
"""
    for path in (("walls", 1), ("walls", 0, "openings", 2)):
        found = single(text, *path)
        assert "repeat" not in found
        assert parse_world(found) == parse_world(text)
    lone = text.replace("    repeat: {times: 2, offset: [0, 3]}\n", "").replace(" + 0.1 * j", "")
    found = single(lone, "walls", 0, "openings", 1)
    assert parse_world(found) == parse_world(lone)
    assert "name: bay" in found


def test_signs_of_expressions_in_texts_stand_for_themselves():
    text = 'mjsim: 1\nbeacons:\n  - {name: a, at: [0, 0], image: "$${x}.png", repeat: {times: 2, offset: [1, 0]}}\n'
    found = single(text, "beacons", 1)
    assert found.count("$${x}.png") == 2


HALL = """\
mjsim: 1
variables: {width: 8, depth: "${width / 2}"}
walls:
  - {name: hall, points: [[0, 0], ["${width}", 0], ["${width}", "${depth}"]]}
floor: {texture: floors/oak.jpg, friction: 0.5}
obstacles: [{name: pole, cylinder: [0.1, 1], at: [1, 1], repeat: {times: 2, offset: [1, 0]}}]
run: {seconds: 7, seed: 3}
"""
CORNER = "mjsim: 1\nobstacles: [{name: plant, cylinder: [0.3, 1], at: [2, 2]}]\n"
MAIN = """\
mjsim: 1   # of two parts
include: [parts/hall.yaml, corner.yaml]   # both measured
variables: {width: 10}
floor: {friction: 0.8}   # polished
obstacles:
  # Ours.
  - {name: box, box: [1, 1, 1], at: ["${depth}", 3]}
run: {seed: 4}
"""


@pytest.fixture
def parts(tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "hall.yaml").write_text(HALL)
    (tmp_path / "corner.yaml").write_text(CORNER)
    path = tmp_path / "main.yaml"
    path.write_text(MAIN)
    return path


@pytest.mark.parametrize(("index", "left"), [(0, []), (1, []), (2, ["parts/hall.yaml"])])
def test_included_files_are_written_into_the_text_and_the_world_stays(parts, index, left):
    before = load_world(parts)
    found = single(MAIN, "obstacles", index, source=Source(file="main.yaml", folder=parts.parent))
    parts.write_text(found)
    after = load_world(parts)
    assert after == before
    assert ("include" in found, "corner.yaml" in found) == (bool(left), False)
    for comment in ("# of two parts", "# polished", "# Ours."):
        assert comment in found
    assert [item.name for item in after.obstacles] == ["pole-1", "pole-2", "plant", "box"]


def test_an_item_of_its_own_stays_as_it_is_and_what_cannot_be_written_is_refused():
    assert single(ROWS, "obstacles", 0) == ROWS
    with pytest.raises(UnwritableError, match="is not there"):
        single(ROWS, "obstacles", 99)
    shared = "mjsim: 1\nobstacles:\n  - &a {name: a, sphere: 0.1, at: [0, 0], repeat: {times: 2, offset: [1, 0]}}\n"
    with pytest.raises(UnwritableError, match="is written once for several places"):
        single(shared, "obstacles", 1)
