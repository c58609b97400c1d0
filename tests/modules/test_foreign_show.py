"""What programs and functions of Octave show becomes the same values as that of Python, or one line."""

import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import mjsim
from mjsim.errors import ModuleFault
from mjsim.interface import ShownGrid, ShownLines, ShownPoints, ShownText
from mjsim.modules.covariances import Unfit
from mjsim.modules.foreign.shown_values import shown_of
from mjsim.world import Source, parse_world

DOCS = Path(__file__).parents[2] / "docs"


def test_the_example_of_the_docs_follows_the_schema_and_becomes_values():
    text = (DOCS / "programs.md").read_text()
    begin = text.index('{"pose":[0,0,0],"covariance":[[0.01,0,0],[0,0.01,0],[0,0,0.001]],\n')
    answer = json.loads(text[begin : text.index("\n\n", begin)])
    definitions = json.loads((DOCS / "programs.schema.json").read_text())["$defs"]
    schema = {"$defs": definitions, "$ref": "#/$defs/answers/properties/update"}
    validator = jsonschema.Draft202012Validator(schema)
    validator.validate(answer)
    assert not validator.is_valid({**answer, "show": [{"points": [], "text": "both"}]})
    points, lines, grid, note = shown_of(answer["show"])
    assert isinstance(points, ShownPoints)
    assert (points.name, points.size, len(points.points)) == ("particles", 0.03, 2)
    assert isinstance(lines, ShownLines)
    assert (lines.name, lines.frame) == ("lines", "estimate")
    assert isinstance(grid, ShownGrid)
    np.testing.assert_array_equal(grid.cells, [[0, 1], [np.nan, 0.5]])
    assert isinstance(note, ShownText)


def test_one_item_needs_no_list_and_nothing_is_nothing():
    assert shown_of(None) == ()
    (item,) = shown_of({"points": [1.0, 2.0]})
    assert item.points.tolist() == [[1.0, 2.0, 0.0]]


@pytest.mark.parametrize(
    ("answer", "why"),
    [
        ([1], "item 1 of est.show that is not an object"),
        ([{}], "item 1 of est.show with none of points, lines, grid, text; it must have one"),
        ([{"points": [], "grid": []}], "with points and grid of points, lines"),
        ([{"points": [], "colour": "red"}], "with the key 'colour'; did you mean 'color'"),
        ([{"grid": [[0]]}], "lacks the key 'resolution'"),
        ([{"points": [["a", "b"]]}], "item 1 of est.show that is not valid"),
        ([{"points": []}] * 65, "a show of 65 items; there must be at most 64"),
        ("hello", "est.show that is not an object"),
    ],
)
def test_what_is_wrong_is_one_line(answer, why):
    with pytest.raises(Unfit, match=why):
        shown_of(answer)


PLANNER = """#!/bin/sh
while read -r line; do
    case $line in
        '{"call":"start"'*) echo '{}' ;;
        *) echo '{"forward": 0.3, "show": [SHOWN]}' ;;
    esac
done
"""
HALL = """
mjsim: 1
walls: [{points: [[0, 0], [8, 0], [8, 6], [0, 6]], closed: true}]
robots: [{name: r, preset: pioneer3dx, at: [1, 3]}]
run: {seconds: 0.2, drivers: {r: {navigator: {use: "exec:./planner.sh"}}}}
"""


def planned(folder, shown):
    """Return the way of a robot whose navigator is a program that shows something."""
    program = folder / "planner.sh"
    program.write_text(PLANNER.replace("SHOWN", shown))
    program.chmod(0o755)
    with mjsim.Simulation(parse_world(HALL, source=Source(file="hall.yaml", folder=folder))) as sim:
        return mjsim.run(sim).robots["r"]


def test_a_program_that_navigates_shows_its_way_beside_what_it_commands(tmp_path):
    track = planned(tmp_path, '{"name": "way", "lines": [[1, 3], [4, 3]], "frame": "estimate"}')
    assert track.command[-1, 0] == 0.3
    (way,) = track.shown[-1]
    assert isinstance(way, ShownLines)
    assert (way.name, way.frame, way.points.tolist()) == ("way", "estimate", [[1, 3, 0], [4, 3, 0]])
    definitions = json.loads((DOCS / "programs.schema.json").read_text())["$defs"]
    schema = {"$defs": definitions, "$ref": "#/$defs/answers/properties/command"}
    validator = jsonschema.Draft202012Validator(schema)
    assert validator.is_valid({"forward": 0.3, "show": [{"points": []}]})
    assert not validator.is_valid({"forward": 0.3, "show": [{"points": [], "text": "both"}]})


def test_what_a_program_that_navigates_shows_wrongly_is_one_line(tmp_path):
    with pytest.raises(ModuleFault, match=r"^navigator planner\.sh of robot 'r' .*returned item 1 of cmd\.show"):
        planned(tmp_path, "{}")
