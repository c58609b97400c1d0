"""Names of things: letters of any script, in one form, told apart by how they look; and the names that are reserved."""

import unicodedata

import pytest

import mjsim
from mjsim.world import with_settings

KITCHEN = "Küche"
DECOMPOSED = unicodedata.normalize("NFD", KITCHEN)
LETTERS = ["Küche", "机器人", "ロボット", "로봇", "روبوت", "רובוט", "रोबोट", "หุ่นยนต์", "робот", "2号", "_é-1.x"]


def world_of(*names):
    """Return the text of a world with a robot of each name."""
    robots = "".join(f'  - {{name: "{name}", at: [{2 * place}, 0]}}\n' for place, name in enumerate(names))
    return f"mjsim: 1\nrobots:\n{robots}"


def told(text):
    """Return the errors of a text, a line each, without their positions."""
    with pytest.raises(mjsim.WorldError) as caught:
        mjsim.parse_world(text)
    return [problem.message for problem in caught.value.problems]


@pytest.mark.parametrize("name", LETTERS)
def test_a_name_has_letters_of_any_script_and_is_written_back_as_it_was(name):
    world = mjsim.parse_world(world_of(name))
    assert world.robots[0].name == name
    assert mjsim.parse_world(mjsim.format_world(world)) == world


def test_equal_texts_are_one_name_however_their_marks_are_coded():
    text = world_of(DECOMPOSED) + f"run: {{drivers: {{{KITCHEN}: {{}}}}, events: [{{time: 1, shove: {DECOMPOSED}, "
    world = mjsim.parse_world(text + "impulse: [1, 0, 0]}]}\n")
    assert world.robots[0].name == KITCHEN == world.run.events[0].shove
    changed = with_settings(world, [f"robots.{DECOMPOSED}.odometry.scale=1.5"])
    assert changed.robots[0].odometry.scale == 1.5


def test_an_argument_of_a_module_finds_a_name_however_it_is_coded():
    use = f'{{use: "a.py:A", camera: {DECOMPOSED}}}'
    world = mjsim.parse_world(f"{world_of('r')}run: {{drivers: {{r: {{observer: {use}}}}}}}\n")
    assert world.run.drivers["r"].observer.arguments() == {"camera": KITCHEN}


@pytest.mark.parametrize(
    ("name", "point"),
    [("a\\u200db", "200D"), ("a\\u202eb", "202E"), ("a\\ufeff", "FEFF"), ("\\u3164", "3164"), ("a\\ufe0f", "FE0F")],
)
def test_an_invisible_character_is_refused_by_its_number(name, point):
    (line,) = told(world_of(name))
    assert line.endswith(f"has the invisible character U+{point}; write it without")


@pytest.mark.parametrize(
    ("name", "point"), [("🤖", "1F916"), ("a\\ue000", "E000"), ("a\\u0378", "0378"), ("a\\u2028b", "2028")]
)
def test_a_character_that_is_no_letter_or_digit_is_refused_by_its_number(name, point):
    (line,) = told(world_of(name))
    assert line.endswith(f"has U+{point}, which is neither a letter nor a digit; write it without")


def test_a_mark_needs_a_letter_before_it():
    (line,) = told(world_of("\u0301a"))
    assert line.endswith("begins with the mark U+0301; begin with a letter or a digit")


@pytest.mark.parametrize(("one", "other"), [("a1", "\uff41\uff11"), ("first", "\ufb01rst"), ("m2", "m²")])
def test_names_that_look_alike_are_refused_with_both(one, other):
    (line,) = told(world_of(one, other))
    assert line == f"name '{other}' looks like '{one}' of robots[0]; give each item a name that looks different"


def test_one_name_in_two_codings_is_taken_twice():
    assert told(world_of(KITCHEN, DECOMPOSED)) == [f"name '{KITCHEN}' is taken by robots[0]; give each item its own"]


def test_sensors_and_parts_of_mechanisms_that_look_alike_are_refused_too():
    camera = "robots: [{name: r, at: [0, 0], sensors: [{camera: a1}, {lidar: \uff41\uff11}]}]"
    assert told(camera) == [
        "name '\uff41\uff11' looks like 'a1' of another sensor of this robot; give each a name that looks different"
    ]
    bodies = "bodies: [{name: b1, rod: [1, 0.1]}, {name: \uff42\uff11, rod: [1, 0.1]}]"
    (line,) = told(f"mechanisms: [{{name: m, at: [0, 0], {bodies}, joints: [{{revolute: q, of: [ground, b1]}}]}}]")
    assert line == "name '\uff42\uff11' looks like 'b1' of bodies[0]; give each a name that looks different"


def test_letters_of_two_scripts_are_two_names():
    assert len(mjsim.parse_world(world_of("robot", "r\u043ebot")).robots) == 2


def test_a_robot_is_not_called_as_the_figures_of_the_run():
    assert told(world_of("run")) == [
        "'run' is reserved for the statistics of the run, beside those of its robots; give another name"
    ]


@pytest.mark.parametrize("name", ["beacon", "ceiling", "door", "floor", "obstacle", "wall", "world"])
def test_a_robot_is_not_called_as_other_things_in_the_scene(name):
    assert told(world_of(name)) == [f"'{name}' is a reserved name in the scene; give another name"]
