"""Many things are removed from a text in one step, read once."""

import time
from random import Random

import pytest

from mjsim.world import Change, edit_text, parse_world


@pytest.mark.parametrize("seed", range(8))
def test_items_removed_at_once_leave_what_is_left_when_they_go_one_after_the_other(seed):
    chance = Random(seed)
    forms = [
        "  - {{name: b{0}, box: [1, 1, 1], at: [{0}, 0]}}   # beside {0}\n",
        "\n  # above {0}\n  - name: b{0}\n    box: [1, 1, 1]  # in {0}\n    at: [{0}, 0]\n",
    ]
    text = "mjsim: 1\nobstacles:\n" + "".join(chance.choice(forms).format(k) for k in range(8))
    gone = sorted(chance.sample(range(8), chance.randint(2, 8)), reverse=True)
    if seed % 2:  # in any order
        gone = [chance.randrange(8 - k) for k in range(len(gone))]
    steps = [Change("remove", ("obstacles", k)) for k in gone]
    one_by_one = text
    for step in steps:
        one_by_one = edit_text(one_by_one, [step])
    found = edit_text(text, steps)
    assert parse_world(found) == parse_world(one_by_one)
    assert [line for line in found.splitlines() if line] == [line for line in one_by_one.splitlines() if line]


ITEMS = [
    "  - {{name: b{0}, box: [1, 1, 1], at: [{0}, 0], elevation: 0.5}}   # beside {0}\n",
    "\n  # above {0}\n  - name: b{0}\n    elevation: 0.5   # in {0}\n      # and below\n    box: [1, 1, 1]\n"
    "    at: [{0}, 0]\n",
    "  - at: [{0}, 0]\n    elevation: 0.5\n\n    name: b{0}\n    box: [1, 1, 1]\n",
    "  - {{name: b{0}, box: [1, 1, 1],\n     at: [{0}, 0],\n     elevation: 0.5}}\n",
]
IN_BRACKETS = "{{name: b{0}, box: [1, 1, 1], at: [{0}, 0], elevation: 0.5}}"


def a_text(chance):
    """Return a world of eight obstacles, written in many ways."""
    if chance.random() < 0.25:
        return "mjsim: 1\nobstacles: [" + ", ".join(IN_BRACKETS.format(k) for k in range(8)) + "]\n"
    return "mjsim: 1\nobstacles:\n" + "".join(chance.choice(ITEMS).format(k) for k in range(8))


@pytest.mark.parametrize("seed", range(5))
def test_keys_that_many_items_get_and_lose_at_once_are_written_as_one_after_the_other(seed):
    chance = Random(seed)
    text, some = a_text(chance), chance.sample(range(8), chance.randint(2, 8))
    path = {k: ("obstacles", k) for k in some}
    makes = [
        lambda k: [Change("set", (*path[k], "group"), "g")],
        lambda k: [Change("set", (*path[k], "at"), [k, 1]), Change("set", (*path[k], "heading_deg"), 30)],
        lambda k: [Change("set", (*path[k], "heading_deg"), 30), Change("set", (*path[k], "color"), "#123456")],
        lambda k: [
            Change("set", (*path[k], "path", "speed"), 2),
            Change("set", (*path[k], "path", "points"), [[1, 2]]),
        ],
        lambda k: [Change("unset", (*path[k], "elevation"))],
    ]
    for make in makes:
        steps = [step for k in some for step in make(k)]
        one_by_one = text
        for step in steps:
            one_by_one = edit_text(one_by_one, [step])
        assert edit_text(text, steps) == one_by_one


def test_a_thousand_items_get_and_lose_a_key_in_one_reading_of_the_text():
    text = "mjsim: 1\nobstacles:\n" + "".join(ITEMS[0].format(k) for k in range(1000))
    begins = time.process_time()
    with_key = edit_text(text, [Change("set", ("obstacles", k, "group"), "g") for k in range(1000)])
    without = edit_text(with_key, [Change("unset", ("obstacles", k, "group")) for k in range(1000)])
    took = time.process_time() - begins
    assert without == text
    assert took < 4.0  # both take 0.5 s on a quiet machine, and took over two minutes when each was read again
