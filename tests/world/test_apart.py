"""One repetition becomes an item of its own; the others stay repeated, and the world stays as it is."""

import numpy as np
import pytest

from mjsim.compile import compile_world
from mjsim.world import Change, UnwritableError, edit_text, parse_world
from tests.world.test_singles import ROWS


def apart(text, *path):
    return edit_text(text, [Change("apart", path)])


def compiled(text):
    """Return names of the bodies of a world; their places [m] and orientations, and those and sizes of shapes."""
    model = compile_world(parse_world(text)).compile()
    names = [model.body(number).name for number in range(model.nbody)]
    return names, [model.body_pos, model.body_quat, model.geom_pos, model.geom_quat, model.geom_size, model.geom_bodyid]


@pytest.mark.parametrize("index", [2, 5, 10, 18, 19])
def test_one_of_a_line_a_grid_and_a_ring_is_taken_out_and_the_bodies_stay(index):
    found = apart(ROWS, "obstacles", index)
    (names, arrays), (others, wanted) = compiled(found), compiled(ROWS)
    assert names == others
    for one, other in zip(arrays, wanted, strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-7)  # rings are rounded to 9 decimals again
    for comment in ("# A row of desks.", "# oak", "# with its back", "# alone"):
        assert comment in found


@pytest.mark.parametrize("index", range(2, 20))  # where the first desk stands is computed
def test_what_is_taken_out_is_moved_alone(index):
    found = apart(ROWS, "obstacles", index)
    assert apart(found, "obstacles", index) == found  # it is one already
    moved = parse_world(edit_text(found, [Change("set", ("obstacles", index, "at"), [50.0, 50.0])])).obstacles
    for number, (before, after) in enumerate(zip(parse_world(ROWS).obstacles, moved, strict=True)):
        assert after.name == before.name
        assert after.at == pytest.approx((50.0, 50.0) if number == index else before.at, abs=1e-8)


def test_the_middle_of_a_row_leaves_a_row_before_and_one_behind():
    text = "mjsim: 1\nobstacles:\n  - {name: d, sphere: 0.1, at: [0, 0], repeat: {times: 5, offset: [1, 0]}} # oak\n"
    assert apart(text, "obstacles", 2).splitlines()[2:] == [
        '  - {name: "d-${i + 1}", sphere: 0.1, at: [0, 0], repeat: {times: 2, offset: [1, 0]}} # oak',
        "  - {name: d-3, sphere: 0.1, at: [2, 0]}",
        '  - {name: "d-${i + 4}", sphere: 0.1, at: [3, 0], repeat: {times: 2, offset: [1, 0]}}',
    ]


def test_what_cannot_stay_repeated_is_refused_and_says_what_can_be_done():
    text = 'mjsim: 1\nobstacles: [{sphere: 0.1, at: ["${i * i}", 0], repeat: {times: 4, offset: [1, 0]}}]\n'
    with pytest.raises(UnwritableError, match="make all of them single"):
        apart(text, "obstacles", 1)
