"""Items are taken out of a text that was copied."""

from pathlib import Path

import pytest

from mjsim.errors import UsageError
from mjsim.world import items_in, load_world

GALLERY = Path(__file__).parents[2] / "worlds" / "gallery.yaml"
BOX = {"box": [1, 1, 1], "at": [2, 3]}


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("obstacles:\n  - {box: [1, 1, 1], at: [2, 3]}\n", [("obstacles", BOX)]),
        ("  - {box: [1, 1, 1], at: [2, 3]}   # from a text\n", [("obstacles", BOX)]),
        ("box: [1, 1, 1]\nat: [2, 3]", [("obstacles", BOX)]),
        ("{points: [[0, 0], [1, 0]]}", [("walls", {"points": [[0, 0], [1, 0]]})]),
        ("- {name: r, preset: p, at: [0, 0]}", [("robots", {"name": "r", "preset": "p", "at": [0, 0]})]),
        ("- {name: r1, at: [0, 1]}", [("beacons", {"name": "r1", "at": [0, 1]})]),
        ("floor: {patches: [{size: [1, 2], at: [0, 0], friction: 0.2}]}",
         [("floor", {"size": [1, 2], "at": [0, 0], "friction": 0.2})]),
        ('- {sphere: "${r / 2}", at: [0, 0], repeat: {times: 2, offset: [1, 0]}}',
         [("obstacles", {"sphere": "${r / 2}", "at": [0, 0], "repeat": {"times": 2, "offset": [1, 0]}})]),
    ],
)  # fmt: skip
def test_items_are_told_by_their_list_or_by_their_keys(text, found):
    assert items_in(text) == found


def test_of_a_whole_world_all_items_are_taken():
    world = load_world(GALLERY)
    found = [name for name, _ in items_in(GALLERY.read_text())]
    for name in ("walls", "obstacles", "beacons", "robots"):
        assert found.count(name) == len(getattr(world, name))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "no item of a world; copy items"),
        ("hello", "no item of a world; copy items"),
        ("[", "no item of a world; copy items"),
        ("mjsim: 1\nname: empty\n", "no item of a world; copy items"),
        ("obstacles: []", "no item of a world; copy items"),
        ("- {box: [1, 1, 1], at: [2, 3]}\n- 7", "no item of a world; copy items"),
        ("obstacles: [{bix: [1, 1], at: [2, 3]}]", "is not an item of a world: unknown key 'bix'; did you mean 'box'?"),
        ("walls: [3]", "walls[0] is not an item of a world"),
        ("obstacles: " + "x" * 5_000_001, "5 MB"),
    ],
    ids=range(9),
)  # fmt: skip
def test_what_is_no_item_is_refused_in_a_line(text, said):
    with pytest.raises(UsageError) as caught:
        items_in(text)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)
