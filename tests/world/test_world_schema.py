"""What editors are told of world files is what the reader says."""

import runpy
from pathlib import Path

import pytest

from mjsim.errors import WorldError
from mjsim.world import editor_schema, load_world, parse_world, read_text

ROOT = Path(__file__).parents[2]
WORLDS = sorted((ROOT / "worlds").rglob("*.yaml"))
FIRST_LINE = "# yaml-language-server: $schema="


@pytest.fixture(scope="module")
def validator():
    jsonschema = pytest.importorskip("jsonschema")
    return jsonschema.Draft202012Validator(editor_schema())


def said(validator, text):
    node, problems = read_text(text, file="world.yaml")
    assert not problems
    return [
        f"{'.'.join(map(str, error.absolute_path))}: {error.message}" for error in validator.iter_errors(node.value)
    ]


def test_the_schema_beside_the_shipped_worlds_is_what_the_program_prints():
    made = runpy.run_path(str(ROOT / "scripts" / "make" / "world_page.py"))["schema_text"]()
    assert (ROOT / "worlds" / "mjsim.schema.json").read_text(encoding="utf-8") == made


@pytest.mark.slow
def test_the_schema_is_one(validator):
    validator.check_schema(validator.schema)


@pytest.mark.parametrize("world", WORLDS, ids=lambda path: path.stem)
def test_every_shipped_world_holds_to_the_schema(validator, world):
    assert said(validator, world.read_text(encoding="utf-8")) == []
    assert load_world(world)


@pytest.mark.parametrize("world", WORLDS, ids=lambda path: path.stem)
def test_every_shipped_world_names_the_schema_on_its_first_line(world):
    first = world.read_text(encoding="utf-8").partition("\n")[0]
    assert first.startswith(FIRST_LINE)
    assert (world.parent / first.removeprefix(FIRST_LINE)).samefile(ROOT / "worlds" / "mjsim.schema.json")


REUSE = """\
include: [hall.yaml]
variables: {w: 3, paint: "#ffffff", push: true, wide: "${w * 2}"}
name: hall-${w}
walls:
  - {points: [[0, "${w}"], ["${wide}", 1]], closed: "${push}", color: "${paint}",
     repeat: {times: "${w}", offset: ["${w / 2}", 0]}}
obstacles: [{name: "a-${i}-${j}", box: [1, "${w}", 1], at: [0, 0], repeat: [{times: 2}, {times: 3, offset: [0, 1]}]}]
robots: [{name: r, at: [0, 0], sensors: [{camera: c, width: "${w * 100}", repeat: {times: 2}}]}]
run: {seconds: "${w}", map: "${paint}", events: [{time: "${i}", light: 0, repeat: {times: 2}}]}
"""


def test_expressions_repeats_includes_and_variables_are_known_to_editors(validator):
    assert said(validator, REUSE) == []


@pytest.mark.parametrize(
    "text",
    [
        "variables: {2w: 3}",
        "variables: [3]",
        "variables: {w: [1]}",
        "include: hall.yaml",
        "lamps: [{at: [0, 0], repeat: {offset: [1, 0]}}]",
        "lamps: [{at: [0, 0], repeat: {times: 2, ofset: [1, 0]}}]",
        "lamps: [{at: [0, 0], repeat: {times: -1}}]",
        "lamps: [{at: [0, 0], repeat: []}]",
        "floor: {repeat: {times: 2}}",
        "light: bright",
        "name: two words",
    ],
)
def test_what_editors_mark_the_reader_refuses(validator, text):
    assert len(said(validator, text)) == 1
    with pytest.raises(WorldError):
        parse_world(text)
