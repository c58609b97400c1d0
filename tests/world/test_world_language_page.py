"""The page on the language says what the reader does."""

import re
from pathlib import Path

import pytest

from mjsim.errors import WorldError
from mjsim.world import check_world, editor_schema, load_world, read_text
from mjsim.world.edit.formatter import format_text

PAGE = (Path(__file__).parents[2] / "docs" / "world-language.md").read_text(encoding="utf-8")
EXAMPLES = re.findall(r"(?:^`(\w+\.yaml)`:\n\n)?^```yaml\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)


@pytest.fixture(scope="module")
def worlds(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page")
    for number, (name, text) in enumerate(EXAMPLES):
        (folder / (name or f"{number}.yaml")).write_text(text)
    return [load_world(folder / (name or f"{number}.yaml")) for number, (name, _) in enumerate(EXAMPLES)]


def test_the_examples_are_worlds_that_can_be_meant(worlds):
    assert len(worlds) == 5
    for world in worlds:
        assert check_world(world) == []


def test_the_examples_come_to_what_the_page_says(worlds):
    room, office, hall, main, _ = worlds
    assert (room.obstacles[0].name, room.obstacles[0].box, room.obstacles[0].at) == ("shelf-4", (0.4, 3, 1.8), (5.7, 2))
    names = [item.name for item in office.obstacles]
    assert [name for name in names if name.startswith("desk")] == [f"desk-{k}" for k in range(1, 6)]
    assert "chair-1-1" in names
    assert "chair-3-5" in names
    assert len(names) == 5 + 15 + 8 + 4
    assert {item.name: item.at for item in office.obstacles}["column-3"] == (7.5, 8.5)
    assert (hall.walls[0].points[2], main.walls[0].points[2]) == ((8, 5), (10, 5))
    assert (main.floor.texture, main.floor.friction, main.robots[0].at) == ("floors/oak.jpg", 0.8, (5, 2.5))


@pytest.mark.slow
@pytest.mark.parametrize(("name", "text"), EXAMPLES)
def test_the_examples_are_laid_out_as_fmt_does_and_hold_to_the_schema(name, text):
    jsonschema = pytest.importorskip("jsonschema")
    assert format_text(text, file="example.yaml") == text
    assert list(jsonschema.Draft202012Validator(editor_schema()).iter_errors(read_text(text, file="")[0].value)) == []


MISTAKEN = {
    "room.yaml": """\
mjsim: 1
include: [parts/hall.yaml]
variables: {deep: -3}


lamps:
  - {at: [0, 0], height: "${deep * 2}"}

  - {at: [0, 0], height: "${3 - i}", repeat: {times: 9, offset: [1, 0]}}
""",
    "parts/hall.yaml": "mjsim: 1\n\nwals: []\n",
}


def test_the_error_examples_of_the_page_are_correct(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("parts").mkdir()
    for name, text in MISTAKEN.items():
        Path(name).write_text(text)
    with pytest.raises(WorldError) as caught:
        load_world("room.yaml")
    assert sorted(str(caught.value).splitlines()) == sorted(re.findall(r"^    (\S+:\d+:\d+: .*)$", PAGE, re.MULTILINE))
