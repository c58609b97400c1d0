"""More mistakes with people, each on one line that says where, what is wrong, and what would be right."""

import pytest

from mjsim.errors import WorldError
from mjsim.world import parse_world

MALFORMED = [
    ("name: a, sex: male, at: [0, 0], elevation: -1", "54: elevation is -1; it must be at least 0"),
    ("name: a, sex: male, at: [0, 0], elevation: high", "54: elevation is 'high'; it must be a number"),
    ("name: a, sex: male, at: [0, 0], elevation: .nan", "54: elevation is nan; it must be a finite number"),
    ("name: a, sex: male, at: [0, 0], elevation: 1e9", "54: elevation is 1000000000.0; it must be at most 1000"),
    ("name: a, sex: male, at: [0, 0], measures: {weight: 0}", "62: weight is 0 kg; of men it lies between 14.4"),
    ("name: a, sex: male, at: [0, 0], measures: {weight: 300}", "62: weight is 300 kg; of men it lies between 14.4"),
    ("name: a, sex: male, at: [0, 0], measures: {stature: 1.2}", "63: stature is 1.2 m; of men it lies between 1.41"),
    ("name: a, sex: male, at: [0, 0], measures: {stature: -1.7}", "63: stature is -1.7 m; of men it lies"),
    ("name: a, sex: male, at: [0, 0], measures: {stature: .nan}", "63: stature is nan; it must be a finite number"),
    ("name: a, sex: male, at: [0, 0], measures: {stature: null}", "63: stature is empty; it must be a number"),
    ("name: a, sex: male, at: [0, 0], measures: {stature: 1.4, sitting_height: 1.0}", "63: stature is"),
    ("name: a, sex: male, at: [0, 0], measures: 3", "53: measures is 3; it must be keys with values"),
    ("name: a, sex: male, at: [0, 0], percentile: [5]", "55: percentile is [5]; it must be a number"),
    ("name: a, sex: male, at: [0, 0], percentile: 99.5", "55: percentile is 99.5; it must be at most 99"),
    ("name: a, sex: male, at: [0, 0], percentile: .inf", "55: percentile is inf; it must be a finite number"),
    ("name: a, sex: male, at: [0, 0], proportion: null", "55: proportion is empty; it must be a number"),
    ("name: a, sex: male, at: [0, 0], heading_deg: north", "56: heading_deg is 'north'; it must be a number"),
    ("name: a, sex: male, at: [0, 0], joints_deg: [1]", "55: joints_deg is [1]; it must be keys with values"),
    ("name: a, sex: male, at: [0, 0], joints_deg: {head_twist: 90}", "68: head_twist is 90 degrees; it"),
    ("name: a, sex: male, at: [0, 0], joints_deg: {head_twist: x}", "68: head_twist is 'x'; it must be a number"),
    ("name: a, sex: male, at: [0, 0], joints_deg: {'': 3}", "60: no joint ''; there are head_bend,"),
    ("name: a, sex: male, at: [0, 0], colors: red", "51: colors is 'red'; it must be keys with values"),
    ("name: a, sex: male, at: [0, 0], colors: {skin: '#12'}", "58: skin is '#12'; it must be a colour"),
    ("name: 3, sex: male, at: [0, 0]", "17: name is 3; it must be text"),
    ("name: '', sex: male, at: [0, 0]", "17: name is ''; it must be a name of letters, digits, '_', '.'"),
    ("name: a, sex: [male], at: [0, 0]", "25: sex is ['male']; it must be 'female' or 'male'"),
    ("name: a, sex: male, at: [0]", "35: at is [0]; it must be [x, y]"),
    ("name: a, sex: male, at: [0, .nan]", "39: at[1] is nan; it must be a finite number"),
    ("name: a, sex: male, at: here", "35: at is 'here'; it must be [x, y]"),
]
"""Text of a person, and the start of what is said from the column on."""
EVENTS = [
    ("remove: a", "3:46: no beacon or obstacle 'a' in this world"),
    ("move: a, to: [1, 1]", "3:44: no robot or movable obstacle 'a' in this world"),
    ("shove: a, impulse: [1, 1, 0]", "3:45: no robot or movable obstacle 'a' in this world"),
]


def said_of(text):
    with pytest.raises(WorldError) as caught:
        parse_world(text, file="w.yaml")
    (line,) = str(caught.value).splitlines()
    return line


@pytest.mark.parametrize(("person", "said"), MALFORMED)
def test_a_malformed_person_is_one_line(person, said):
    assert said_of(f"mjsim: 1\npeople: [{{{person}}}]\n").startswith(f"w.yaml:2:{said}")


@pytest.mark.parametrize(("event", "said"), EVENTS)
def test_people_are_held_and_no_event_moves_them(event, said):
    text = (
        f"mjsim: 1\npeople: [{{name: a, sex: male, at: [0,0]}}]\nrun: {{seconds: 1, events: [{{time: 1, {event}}}]}}\n"
    )
    assert said_of(text).startswith(f"w.yaml:{said}")
