"""`include`, `variables` and `repeat`: what a text stands for, what is refused, and where it is said."""

import math
import time

import pytest

from mjsim.errors import WorldError
from mjsim.world import parse_world
from mjsim.world.language import templates


def faults(text, **options):
    with pytest.raises(WorldError) as caught:
        parse_world("mjsim: 1\n" + text, file="room.yaml", **options)
    return str(caught.value).splitlines()


def value_of(expression, variables="{}"):
    world = parse_world(f'mjsim: 1\nvariables: {variables}\nlamps: [{{at: ["${{{expression}}}", 0]}}]\n')
    return world.lamps[0].at[0]


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("1 + 2 * 3", 1 + 2 * 3),
        ("(1 + 2) * 3 - 4 / 8", (1 + 2) * 3 - 4 / 8),
        ("-2 ** 2 + 2 ** -1", -(2**2) + 2**-1),
        ("2 ** 3 ** 2", 2**3**2),
        ("7 // 2 + 7 % 4 + -7 // 2", 7 // 2 + 7 % 4 + -7 // 2),
        ("min(3, 1, 2) + max(1.5, 2) + abs(-4)", 7),
        ("sqrt(9) + floor(2.7) + ceil(2.1) + round(2.567, 2)", 3 + 2 + 3 + 2.57),
        ("cos(60) + sin(90) + tan(45)", 2.5),
        ("cos(90)", 0),
        ("atan2(1, 1) + pi", 45 + math.pi),
        ("1e2 + .5 + 3.", 103.5),
    ],
)
def test_an_expression_comes_to_what_arithmetic_says(expression, value):
    assert value_of(expression) == pytest.approx(value, abs=1e-12)


def test_variables_use_earlier_ones_and_may_be_texts_and_switches():
    world = parse_world(
        "mjsim: 1\n"
        'variables: {w: 12, half: "${w / 2}", paint: "#ff0000", push: true, name: "hall-${half}"}\n'
        "name: ${name}\n"
        'obstacles: [{box: [1, "${half}", 1], at: [0, 0], color: "${paint}", movable: "${push}"}]\n'
    )
    (box,) = world.obstacles
    assert (world.name, box.box, box.color, box.movable) == ("hall-6", (1, 6, 1), "#ff0000", True)


def test_a_whole_result_is_a_whole_number_and_a_doubled_dollar_sign_is_no_expression():
    text = 'mjsim: 1\nrun: {seed: "${6 / 2}", drivers: {a: {navigator: {use: "a:B", text: "$${w}", n: "${2 * 2}"}}}}\n'
    world = parse_world(text + "robots: [{name: a, at: [0, 0]}]\n")
    assert world.run.seed == 3
    assert world.run.drivers["a"].navigator.arguments() == {"text": "${w}", "n": 4}


@pytest.mark.parametrize(
    ("expression", "message"),
    [
        ("1 / 0", "1 / 0 divides by zero"),
        ("9**9**9", "9 ** 387420489 is too large; results are at most 1e+15"),
        ("(0 - 8) ** 0.5", "-8 ** 0.5 is not a number"),
        ("sqrt(0 - 1)", "sqrt(-1) is not a number"),
        ("w + 1", "no variable 'w' before this; there are none"),
        ("sine(3)", "no function 'sine'; did you mean 'sin'?"),
        ("sin(3, 4)", "sin() got 2 values; it takes 1"),
        ("1 +", "'1 +' is not an expression: it ends too early; write for example 'w / 2 + 1'"),
        ("2 w", "'2 w' is not an expression: 'w' is not allowed there; write for example 'w / 2 + 1'"),
        ("1 + * 2", "'1 + * 2' is not an expression: '*' is not allowed there; write for example 'w / 2 + 1'"),
        ("sin(1, )", "'sin(1, )' is not an expression: ')' is not allowed there; write for example 'w / 2 + 1'"),
        (
            "__import__('os')",
            "'__import__('os')' is not an expression: ''' is not allowed in it; use numbers, names, + - * /",
        ),
        ("", "'${}' contains no expression; write a number, a name or arithmetic between the braces"),
        ("i", "'i' has no meaning here; it counts the repetitions of an item with 'repeat'"),
        ("(" * 40 + "1" + ")" * 40, "the expression is nested more than 30 deep; use a variable for a part of it"),
        ("1" + "+1" * 300, "an expression of 601 characters; write at most 400"),
    ],
)
def test_an_expression_that_cannot_be_computed_is_told_at_its_place(expression, message):
    assert faults(f'light: "${{{expression}}}"\n') == [f"room.yaml:2:8: {message}"]


def test_faults_of_variables_and_of_values_that_came_out_of_expressions_have_their_places():
    assert faults(
        "variables: {w: -3, sin: 1, t: [1], 2x: 3}\nlamps:\n"
        '  - {at: [0, 0], height: "${w * 2}"}\n  - {at: [0, 0], color: "x${w}"}\n'
    ) == [
        "room.yaml:2:20: 'sin' has a meaning of its own in expressions; give the variable another name",
        "room.yaml:2:31: variable 't' is not a single value; give a number, a text, true or false",
        "room.yaml:2:36: '2x' is not a variable name; write letters, digits and '_', a letter first",
        "room.yaml:4:26: height is -6 m; it must be above 0",
        "room.yaml:5:25: color is 'x-3'; it must be a colour such as \"#e8e4da\", in quotes",
    ]
    assert faults("lamps: [{at: [${w}, 0]}]\n") == [
        'room.yaml:2:16: this is not YAML: an expression inside brackets has no quotes; write "${...}"'
    ]
    assert faults('light: "${w"\n') == [
        "room.yaml:2:8: '${w' has a '${' without its '}'; close it, or write '$${' for the characters themselves"
    ]


def test_texts_that_double_are_refused():
    doubling = "variables:\n  a0: '" + "x" * 500 + "'\n"
    doubling += "".join(f"  a{k + 1}: '${{a{k}}}${{a{k}}}'\n" for k in range(60))
    line = faults(doubling)[0]
    assert line == "room.yaml:6:7: the result has 4000 characters; it must have at most 2000"


@pytest.mark.slow
def test_expanding_ends_when_its_time_is_over(monkeypatch):
    monkeypatch.setattr(templates, "MAX_TIME", 0.3)
    long = "+".join("i" * 180)
    start = time.process_time()
    found = faults(f"lamps: [{{at: ['${{{long}}}', 0], repeat: {{times: 100000}}}}]\n")
    assert found == ["room.yaml:2:9: expanding takes more than 0.3 s; repeat or include less"]
    assert time.process_time() - start < 1


def test_repeated_items_stand_one_offset_apart_and_are_numbered():
    world = parse_world(
        "mjsim: 1\nobstacles:\n"
        "  - {name: rack, box: [1, 1, 1], at: [0.1, 0], repeat: {times: 3, offset: [0.1, 2]}}\n"
        "  - {sphere: 1, at: [0, 9], path: {points: [[1, 9]]}, repeat: {times: 2, offset: [0, 1]}}\n"
        "walls:\n  - {points: [[0, 0], [1, 0]], repeat: {times: 2, offset: [0, 5]},"
        " openings: [{at: 0.1, width: 0.2, name: 'gap-${j}.${i}', repeat: {times: 2, offset: 0.4}}], name: w}\n"
    )
    assert [(item.name, item.at) for item in world.obstacles] == [
        ("rack-1", (0.1, 0)),
        ("rack-2", (0.2, 2)),
        ("rack-3", (0.3, 4)),
        (None, (0, 9)),
        (None, (0, 10)),
    ]
    assert world.obstacles[4].path.points == ((1, 10),)
    assert [wall.name for wall in world.walls] == ["w-1", "w-2"]
    assert world.walls[1].points == ((0, 5), (1, 5))
    gaps = [(opening.name, opening.at) for wall in world.walls for opening in wall.openings]
    assert gaps == [("gap-0.0", 0.1), ("gap-1.0", 0.5), ("gap-0.1", 0.1), ("gap-1.1", 0.5)]


def test_repeats_within_each_other_make_grids_and_number_what_is_inside():
    world = parse_world(
        "mjsim: 1\n"
        "beacons: [{name: b, at: [0, 0], center: '${1 + i + j / 10}',"
        " repeat: [{times: 2, offset: [0, 3]}, {times: 3, offset: [1, 0]}]}]\n"
        "walls:\n  - points: [[0, 9], [4, 9]]\n    repeat: {times: 2, offset: [0, 1]}\n    openings:\n"
        "      - {name: door, at: 0.1, width: 0.2}\n"
        "      - {name: window, at: 0.5, width: 0.2, sill: 1, repeat: {times: 2, offset: 1}}\n"
        "robots: [{name: r, at: [1, 1], sensors: [{lidar: scan, repeat: {times: 2}}],"
        " repeat: {times: 2, offset: [1, 0]}}]\n"
    )
    assert [(beacon.name, beacon.at, beacon.center) for beacon in world.beacons] == [
        (f"b-{row + 1}-{column + 1}", (column, 3 * row), 1 + row + column / 10)
        for row in range(2)
        for column in range(3)
    ]
    names = [opening.name for wall in world.walls for opening in wall.openings]
    assert names == ["door-1", "window-1-1", "window-1-2", "door-2", "window-2-1", "window-2-2"]
    assert [[sensor.lidar for sensor in robot.sensors] for robot in world.robots] == [["scan-1", "scan-2"]] * 2


def test_a_ring_turns_items_about_its_middle():
    world = parse_world(
        "mjsim: 1\nobstacles:\n"
        "  - {name: column, box: [1, 1, 2], at: [13, 5], heading_deg: 90,"
        " repeat: {times: 8, turn_deg: 45, about: [8, 5]}}\n"
        "walls: [{points: [[13, 5], [14, 5]], repeat: {times: 4, turn_deg: 90, about: [8, 5]}}]\n"
    )
    for index, item in enumerate(world.obstacles):
        angle = math.radians(45 * index)
        assert item.at == pytest.approx((8 + 5 * math.cos(angle), 5 + 5 * math.sin(angle)), abs=1e-9)
        assert math.cos(math.radians(item.heading_deg) - angle) == pytest.approx(0, abs=1e-9)
    assert world.walls[1].points == ((8, 10), (8, 11))


def test_an_opening_with_a_foreign_name_inside_a_repeated_wall_is_told():
    wall = "{points: [[0, 0], [4, 0]], repeat: {times: 2}, openings: [{at: 1, width: 1, lidar: x}]}"
    assert faults(f"walls: [{wall}]\n") == [
        "room.yaml:2:85: unknown key 'lidar'; there are at, door, head, name, segment, sill, width"
    ]


def test_keys_of_a_users_module_are_its_own():
    text = "run: {drivers: {a: {navigator: {use: 'a:B', image: 'x.png', steps: [{repeat: 2, to: '${1 + 1}'}]}}}}\n"
    world = parse_world("mjsim: 1\nrobots: [{name: a, at: [0, 0]}]\n" + text)
    assert world.run.drivers["a"].navigator.arguments() == {"image": "x.png", "steps": [{"repeat": 2, "to": 2}]}


@pytest.mark.parametrize(
    ("item", "fault"),
    [
        ("{times: -1}", "34: times is -1; it must be at least 0"),
        ("{times: 2, ofset: [1, 0]}", "37: unknown key 'ofset'; did you mean 'offset'?"),
        ("{times: 2, offset: 1}", "26: offset is 1; it must be [x, y] as 'at' has"),
        ("{times: 2, turn_deg: 9}", "47: turn_deg needs the middle of the ring; add about: [x, y]"),
        ("7", "26: repeat is 7; it must be keys with values"),
        ("[]", "26: repeat is a list of 0; it must be one repeat or 2 to 3"),
        ("{times: '${n}'}", "34: no variable 'n' before this; there are none"),
        ("{offset: [1, 0]}", "26: key 'times' is missing; add it: number of copies, including the first"),
        ("{times: 100001}", "34: times is 100001; it must be at most 100000"),
        ("[{times: 100000}, {times: 2}]", "5: repeating produces more than 100000 items; repeat less"),
    ],
)
def test_an_impossible_repeat_is_an_error_at_its_place(item, fault):
    column, _, message = fault.partition(": ")
    assert faults("lamps:\n" + f"  - {{at: [1, 1], repeat: {item}}}\n") == [f"room.yaml:3:{column}: {message}"]


def test_what_is_wrong_with_some_repetitions_is_told_once_and_with_which():
    assert faults(
        "lamps:\n  - {at: [0, 0], hight: 2, repeat: {times: 50, offset: [0, 1]}}\n"
        '  - {at: [0, 0], height: "${3 - i}", repeat: {times: 9, offset: [0, 1]}}\n'
        "  - {name: a-2, at: [0, 0]}\n  - {name: a, at: [5, 0], repeat: {times: 3, offset: [0, 1]}}\n"
        "  - {at: [9000, 0], repeat: [{times: 2, offset: [0, 1]}, {times: 2, offset: [2000, 0]}]}\n"
    ) == [
        "room.yaml:3:18: unknown key 'hight'; did you mean 'height'?",
        "room.yaml:4:26: height is 0 m; it must be above 0 (in repetition 4)",
        "room.yaml:6:12: name 'a-2' is taken by lamps[59]; give each item its own (in repetition 2)",
        "room.yaml:7:11: at[0] is 11000.0 m; it must be at most 10000 (in repetition 1, 2)",
    ]


@pytest.mark.slow
def test_thousands_of_faults_of_one_repeat_are_one_line_and_found_soon():
    text = "beacons: [{name: b, at: [0, 0], on: nobody, widht: 3, repeat: {times: 5000}}]\n"
    start = time.process_time()
    assert faults(text)[-1].startswith("room.yaml:2:45: unknown key 'widht'; did you mean 'width'?")
    assert time.process_time() - start < 10
