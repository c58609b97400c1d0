"""Events with several targets: read, checked, written within the line, and told as one motion."""

import pytest

import mjsim
from mjsim.errors import WorldError
from mjsim.session import keep_events
from mjsim.world import as_motions, check_world, event_from, event_text, single_targets
from tests.session.test_touch_drags import LIFT

LEAD = {"time": 1.0, "lead": "lift", "joint": "up", "to_deg": 0.5}


def written(event) -> str:
    return LIFT.replace("{seconds: 0.4}", f"{{seconds: 9, events: [{event}]}}")


@pytest.mark.parametrize(
    ("event", "said"),
    [
        (
            "{time: 1, lead: lift, joint: up, to_deg: 0.5, then: [[0.1]]}",
            "this row has 1 numbers; give the time after the event, and the value",
        ),
        (
            "{time: 1, reach: r, tool: [0, 0, 0], then: [[0.1, 1, 1]]}",
            "this row has 3 numbers; give the time after the event, and the 3 numbers of the target",
        ),
        (
            "{time: 1, lead: lift, joint: up, to_deg: 0.5, then: [[0.2, 1], [0.1, 1]]}",
            "time 0.1 s is not after 0.2 s; put the rows in order of time",
        ),
    ],
)
def test_a_row_that_cannot_be_is_named(event, said):
    with pytest.raises(WorldError, match=said.replace("[", r"\[")):
        mjsim.parse_world(written(event))


def test_check_names_the_row_whose_value_is_out_of_range():
    text = written("{time: 1, lead: lift, joint: up, to_deg: 0.5,\n then: [[0.1, 0.6],\n [0.2, 1.7]]}")
    (problem,) = check_world(mjsim.parse_world(text, source=None))
    assert "joint 'up' of mechanism 'lift' cannot go to 1.7; its range is 0 to 1" in str(problem)
    assert problem.line == text[: text.index("[0.2")].count("\n") + 1


def test_targets_are_events_of_their_own_in_a_run_and_one_motion_for_who_reads_them():
    event = event_from({**LEAD, "then": ((0.1, 0.6), (0.3, 0.8))})
    targets = single_targets(event)
    assert [(each.time, each.to_deg, each.then) for each in targets] == [
        (1, 0.5, None),
        (1.1, 0.6, None),
        (1.3, 0.8, None),
    ]
    other = event_from({"time": 1.2, "light": 0.5})
    late = event_from({**LEAD, "time": 5.0})
    assert as_motions([*targets[:2], other, targets[2], late]) == [event, other, late]
    assert event_text(event) == "joint up of lift goes to 0.8, through 3 targets in 0.3 s"


def test_long_motions_are_kept_in_lines_that_fit_and_read_back_equal():
    rows = tuple((round(0.08 * k, 4), round(0.5 + 0.001 * k, 4)) for k in range(1, 100))
    event = event_from({**LEAD, "then": rows})
    for text in (LIFT, LIFT.replace("run: {seconds: 0.4}", "run:\n  seconds: 9\n"), written("{time: 2, light: 0.5}")):
        kept = keep_events(text, [event])
        assert max(map(len, kept.splitlines())) <= 120
        assert mjsim.parse_world(kept).run.events[-1] == event
