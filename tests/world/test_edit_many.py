"""Many things are removed from a text in one step, read once."""

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
    steps = [Change("remove", ("obstacles", k)) for k in gone]
    one_by_one = text
    for step in steps:
        one_by_one = edit_text(one_by_one, [step])
    found = edit_text(text, steps)
    assert parse_world(found) == parse_world(one_by_one)
    assert [line for line in found.splitlines() if line] == [line for line in one_by_one.splitlines() if line]
