"""Ways and goals that cannot be meant are told; those that can are let be."""

import pytest

from mjsim.world import check_world, parse_world

ROOM = """
mjsim: 1
walls:
  - {{points: [[0, 0], [8, 0], [8, 4], [0, 4]], closed: true, name: hall}}
  - {{points: [[4, 0], [4, 4]], name: middle, openings: [{{name: gate, segment: 0, at: 1, width: 1, door: {{}}}}]}}
obstacles:
  - {{box: [0.5, 0.5, 1], at: [1, 3], name: rack}}
  - {{box: [0.4, 0.4, 0.4], at: [2, 3], name: bin, movable: true}}
  - {{cylinder: [0.2, 1.5], at: [2, 1.5], name: cart{}}}
robots: [{{name: r, at: [6, 2]}}]
run: {{events: [{}]}}
"""


def told(path: str = "", events: str = "") -> list[str]:
    return [problem.message for problem in check_world(parse_world(ROOM.format(path, events)))]


@pytest.mark.parametrize(
    ("points", "doubt"),
    [
        ("[[2, 2.5], [6, 2.5]]", "obstacle 'cart' goes through wall 'middle' on its way to [6, 2.5]; route it around"),
        (
            "[[1, 1.5], [1, 2.7]]",
            "obstacle 'cart' goes through obstacle 'rack' on its way to [1, 2.7]; route it around",
        ),
        ("[[2, 0.2]]", "obstacle 'cart' goes through wall 'hall' on its way to [2, 0.2]; route it around"),
        (
            "[[3.5, 1.5], [6, 1.5], [6, 3]], closed: true",
            "obstacle 'cart' goes through wall 'middle' on its way to [2, 1.5]",
        ),
    ],
)
def test_a_mover_through_fixed_objects_is_reported(points, doubt):
    (message,) = told(f", path: {{points: {points}}}")
    assert message.startswith(doubt)


def test_a_mover_may_go_through_doorways_and_push_what_is_movable():
    assert told(", path: {points: [[6, 1.5], [6, 3]]}") == []
    assert told(", path: {points: [[2, 3]]}") == []


@pytest.mark.parametrize(
    ("event", "doubt"),
    [
        ("move: r, to: [4, 3]", "'r' is placed at [4, 3] inside wall 'middle'; move it to a free place"),
        ("move: bin, to: [1, 2.6], heading_deg: 45", "'bin' is placed at [1, 2.6] inside obstacle 'rack'"),
    ],
)
def test_what_is_put_down_inside_something_is_told(event, doubt):
    (message,) = told(events=f"{{time: 1, {event}}}")
    assert message.startswith(doubt)


def test_what_was_taken_away_is_in_nobodys_way():
    assert told(events="{time: 1, remove: rack}, {time: 2, move: r, to: [1, 3]}") == []
    assert told(events="{time: 2, move: r, to: [4, 1.5]}") == []
