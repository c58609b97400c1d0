"""What programs and functions of Octave show becomes the same values as that of Python, or one line."""

import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from mjsim.interface import ShownGrid, ShownLines, ShownPoints, ShownText
from mjsim.modules.covariances import Unfit
from mjsim.modules.foreign.shown import shown_of

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
        ([1], "item 1 of est.show that is no object"),
        ([{}], "item 1 of est.show with none of points, lines, grid, text; it must have one"),
        ([{"points": [], "grid": []}], "with points and grid of points, lines"),
        ([{"points": [], "colour": "red"}], "with the key 'colour'; did you mean 'color'"),
        ([{"grid": [[0]]}], "lacks the key 'resolution'"),
        ([{"points": [["a", "b"]]}], "item 1 of est.show which is not right"),
        ([{"points": []}] * 65, "a show of 65 items; there must be at most 64"),
        ("hello", "est.show that is no object"),
    ],
)
def test_what_is_wrong_is_one_line(answer, why):
    with pytest.raises(Unfit, match=why):
        shown_of(answer)
