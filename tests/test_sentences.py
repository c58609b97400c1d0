"""Sentences of mjsim are English text that keeps its template and values, for a page in another language."""

import ast
import copy
import pickle
import re
import string
from pathlib import Path

import pytest

import mjsim
from mjsim.errors import UsageError, WorldError, did_you_mean, file_meant
from mjsim.sentences import Sentence, number_of, sentences_in, with_sentences

ROOT = Path(mjsim.__file__).parent
COUNT = "{count:.2f} of {all} in '{{}}'"


def test_a_sentence_is_text_with_its_template_and_values():
    made = Sentence(COUNT, 2 / 3, Sentence("{number} runs", 5))
    assert made == "0.67 of 5 runs in '{}'"
    assert made.template == "{count} of {all} in '{{}}'"
    assert made.values == {"count": "0.67", "all": "5 runs"}
    assert [each.template for each in sentences_in({"told": [made], "rows": [[1, 2]]})] == [
        made.template,
        "{number} runs",
    ]


@pytest.mark.parametrize("given", [(), (1,), (1, 2, 3)])
def test_each_name_of_a_template_has_one_value(given):
    with pytest.raises(ValueError, match="zip"):
        Sentence(COUNT, *given)


def test_a_name_that_is_written_in_part_is_meant_before_one_that_differs_in_a_letter():
    presets = ("turtlebot3_burger", "turtlebot3_waffle", "turtlebot4")
    assert did_you_mean("turtlebot3", presets) == "; did you mean 'turtlebot3_waffle'?"
    assert did_you_mean("r", [""]) == "; there are none"
    assert did_you_mean("turtlebot5", presets) == "; did you mean 'turtlebot4'?"


@pytest.mark.parametrize(
    ("missing", "said"),
    [
        ("nothere.urdf", "; name a robot"),
        ("rovr.urdf", "; did you mean 'rover.urdf.xacro'?"),
        ("gone/rover.urdf", "; name a robot"),
        ("scout.xacro", "; did you mean 'Scout2.XACRO'?"),
    ],
)
def test_a_missing_file_is_likened_to_files_of_the_kinds_that_are_read(tmp_path, missing, said):
    for name in ("note.md", "rover.txt", "rover.urdf.xacro", "Scout2.XACRO"):
        (tmp_path / name).touch()
    assert file_meant(tmp_path / missing, (".urdf", ".xacro"), otherwise="a robot") == said


def test_copies_and_errors_keep_template_and_values():
    made = Sentence("no robot '{robot}'{meant}", "rover", did_you_mean("rover", ["scout", "rover2"]))
    within = Sentence("--set {problem}", UsageError(made)).values["problem"]
    for other in (copy.deepcopy(made), pickle.loads(pickle.dumps(made)), str(ValueError(made)), within):
        assert other == "no robot 'rover'; did you mean 'rover2'?"
        assert other.template == made.template
        assert other.values == made.values


def test_a_wrong_world_is_told_with_templates_and_values():
    text = "mjsim: 1\nrobots:\n  - {name: r, preset: pioneer3dx, at: [1, 1], body: {height: -2}}\n"
    with pytest.raises(WorldError) as caught:
        mjsim.parse_world(text, file="room.yaml")
    told = with_sentences({"error": str(caught.value)})
    assert told["error"] == str(caught.value) == str(caught.value.problems[0])
    template, values = told["sentences"][caught.value.problems[0].message]
    assert template == "{name} is {value}; {right}"
    assert values == {"name": "height", "value": "-2 m", "right": "it must be above 0"}
    assert told["sentences"]["it must be above 0"] == ["it must be {word} {bound}", {"word": "above", "bound": "0"}]


@pytest.mark.slow
def test_what_is_wrong_with_a_file_that_another_process_reads_is_told_with_its_template(tmp_path):
    (tmp_path / "odd.obj").write_text("v 0 0 0\n")
    mesh = "<visual><geometry><mesh filename='odd.obj'/></geometry></visual>"
    (tmp_path / "odd.urdf").write_text(f"<robot name='odd'><link name='all'>{mesh}</link></robot>")
    (tmp_path / "room.yaml").write_text("mjsim: 1\nobstacles: [{model: odd.urdf, at: [1, 1]}]\n")
    with pytest.raises(WorldError) as caught:
        mjsim.load_world(tmp_path / "room.yaml")
    (found,) = {each.template for each in sentences_in([each.message for each in caught.value.problems])}
    assert found == "'{path}' cannot be read as a mesh: it has {count} corners; export it again"


def of_errors(tree):
    """Yield what the errors, problems and events that a module makes are given."""
    for node in ast.walk(tree):
        called = getattr(node, "func", None)
        name = getattr(called, "id", getattr(called, "attr", ""))
        if isinstance(node, ast.Call) and re.search(r"(Error|Fault|Event|Problem|Defect|Unfit)$|^fault$", name):
            yield from (*node.args, *(keyword.value for keyword in node.keywords))


@pytest.mark.slow
def test_what_the_server_and_a_world_are_refused_with_are_sentences_and_no_finished_text():
    parts = (
        *("web", "world", "session", "models", "compile", "mechanics", "record", "sim", "modules", "guarded", "people"),
        *("run", "report", "video", "output", "safety"),
    )
    files = [path for part in parts for path in (ROOT / part).rglob("*.py")]
    finished = [
        f"{path.relative_to(ROOT)}:{text.lineno}"
        for path in files
        for text in of_errors(ast.parse(path.read_text("utf-8")))
        if isinstance(text, ast.JoinedStr) and " " in ast.unparse(text)
    ]
    assert [place for place in finished if not place.startswith(NOT_ON_THE_PAGE)] == []


NOT_ON_THE_PAGE = (
    *("guarded/plain_values.py", "guarded/limits.py", "guarded/request.py"),  # from program to program
    *("web/run/requests.py", "web/server/answers.py"),  # requests that the page never makes, in pydantic's words
    *("web/server/local.py", "web/server/session_keys.py", "web/studio.py"),  # on the terminal, before there is a page
)


@pytest.mark.slow
def test_each_template_of_the_source_names_as_many_values_as_it_is_given():
    calls = [
        (path, node)
        for path in ROOT.rglob("*.py")
        if "Sentence(" in (text := path.read_text("utf-8"))
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("Sentence", "_fault") and node.args
    ]
    assert len(calls) > 800
    for path, call in calls:
        template, *given = call.args
        if isinstance(template, ast.Constant):
            fields = {field[1:] for field in string.Formatter().parse(template.value) if field[1] is not None}
            names = {name for name, _, _ in fields}
            assert all(name.isidentifier() for name in names), f"{path}:{call.lineno}"
            assert len(fields) == len(names), f"{path}:{call.lineno}: a name with two formats"
            while any(packed := [isinstance(each, ast.Starred) and hasattr(each.value, "elts") for each in given]):
                place = packed.index(True)
                given[place : place + 1] = given[place].value.elts
            if not any(isinstance(each, ast.Starred) for each in given):
                assert len(names) == len(given), f"{path}:{call.lineno}"


@pytest.mark.parametrize(
    "text",
    [
        *("0 walls", "1 wall", "2 bodies", "2 rays", "3 boxes", "2 people", "1 person"),
        *("2 parts of a mesh", "1 part of a mesh", "5 frames called like a sensor", "2 lines without a second face"),
    ],
)
def test_a_number_has_its_noun_in_the_singular_or_plural(text):
    singular = {"bodies": "body", "boxes": "box", "people": "person"}
    number, noun, *rest = text.split()
    one = noun if number == "1" else singular.get(noun, noun.removesuffix("s"))
    assert number_of(int(number), " ".join([one, *rest])) == text
