"""`mjsim fmt`: layout changes, values and comments do not."""

import itertools
import random
from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from mjsim.cli import main
from mjsim.errors import WorldError
from mjsim.world import read_text
from mjsim.world.edit.formatter import format_text
from mjsim.world.yaml import read_commented

WORLDS = sorted((Path(__file__).parents[2] / "worlds").glob("**/*.yaml"))
UNTIDY = """\
# A room.


mjsim:   1
name:  room
variables: { w: 12,   h: "${w / 4}" }   # metres
include: [ hall.yaml ]

walls:   # all of them
# The outer ones.
- closed: true
  points:
  - [0,0]
  - [12, 0]   # a corner
  - [12,8]
  name: outer
- {height: 2.50, points: [[0, 0], [1, 1], [2, 2], [3, 3], [4, 4], [5, 5], [6, 6], [7, 7], [8, 8],
   [9, 9], [10, 10], [11, 11], [12, 12]]}  # long
- points: [[0, 0], [1, 1]]
  color: '#ffffff'
  # - {a: commented out item}

  # and another
beacons:

  - { at: [1, 2], "name": b, heading_deg: 90, repeat: {offset: [1,
      0], times: 3} }
run: {drivers: {a: {navigator: {use: "a:B", zeta: 1, alpha: 2}}}, seconds: 5,
  events: [{light: 0.2, time: 3}, {move: a, time: 4, to: [1, 2]}]}
# The end.
"""

TIDY = """\
# A room.

mjsim: 1
name: room
variables: {w: 12, h: "${w / 4}"}       # metres
include: [hall.yaml]

walls:   # all of them
  # The outer ones.
  - name: outer
    points:
      - [0, 0]
      - [12, 0]  # a corner
      - [12, 8]
    closed: true
  # long
  - points: [[0, 0], [1, 1], [2, 2], [3, 3], [4, 4], [5, 5], [6, 6], [7, 7], [8, 8], [9, 9], [10, 10], [11, 11],
             [12, 12]]
    height: 2.50
  - points: [[0, 0], [1, 1]]
    color: '#ffffff'
    # - {a: commented out item}

    # and another
beacons:
  - {name: b, at: [1, 2], heading_deg: 90, repeat: {times: 3, offset: [1, 0]}}
run: {seconds: 5, drivers: {a: {navigator: {use: "a:B", zeta: 1, alpha: 2}}},
      events: [{time: 3, light: 0.2}, {time: 4, move: a, to: [1, 2]}]}
# The end.
"""


def test_an_untidy_world_is_laid_out_with_all_its_comments():
    assert format_text(UNTIDY, file="room.yaml") == TIDY
    assert format_text(TIDY, file="room.yaml") == TIDY


words = st.sampled_from(
    [
        "1",
        "2.50",
        "-0.0",
        "true",
        "null",
        "~",
        "''",
        '"#no comment"',
        "'it''s'",
        "a b",
        "x#y",
        "0x1F",
        '"${w / 2}"',
        "é",
    ]
)
keys = st.sampled_from(
    ["at", "name", "points", "use", "repeat", "box", "zeta", "'quoted key'", '"at2"', "floor", "run"]
)


def values(depth):
    if depth == 0:
        return words
    inner = values(depth - 1)
    return st.one_of(
        words,
        st.lists(inner, max_size=4),
        st.lists(st.tuples(keys, inner), max_size=4, unique_by=lambda pair: pair[0].strip("'\"")).map(dict),
    )


class Scribe:
    """Writes a value as YAML, its layout and comments drawn at random."""

    def __init__(self, seed):
        self._random = random.Random(seed)
        self._number = itertools.count()

    def chance(self, share=0.3):
        return self._random.random() < share

    def comment(self):
        return f"# {next(self._number)} [{{,: '\"" + " " * self._random.randrange(3)

    def above(self, indent):
        """Return what may stand on lines of its own."""
        lines = []
        while self.chance():
            space = " " * max(indent + self._random.choice([0, 0, 0, 2, -2, 3]), 0)
            lines.append(self._random.choice(["", space + self.comment()]))
        return lines

    def beside(self):
        return " " * self._random.randrange(1, 30) + self.comment() if self.chance() else ""

    def flow(self, value, indent):
        """Return a value in brackets; its lines may break anywhere, beside comments."""
        if isinstance(value, str):
            return f'"{value}"' if set("#,'é") & set(value) and value[0] not in "'\"" else value
        gap = f"{self.beside()}\n{' ' * (indent + 3)}" if self.chance(0.15) else self._random.choice(["", " "])
        pieces = []
        for item in value:
            piece = self.flow(item, indent)
            if isinstance(value, dict):
                piece = f"{item}: {self.flow(value[item], indent)}"
            pieces.append(piece)
        inner = f",{gap or ' '}".join(pieces)
        return f"{{{gap}{inner}{gap}}}" if isinstance(value, dict) else f"[{gap}{inner}{gap}]"

    def block(self, value, indent):
        lines = []
        for item in value:
            lines += self.above(indent)
            key, held = (item, value[item]) if isinstance(value, dict) else ("-", item)
            sign = f"{' ' * indent}{key}{':' if isinstance(value, dict) else ''}"
            if isinstance(held, str) or not held or self.chance():
                lines.append(f"{sign} {self.flow(held, indent)}{self.beside()}")
            else:
                step = self._random.choice([1, 2, 4])
                lines += [sign + self.beside(), *self.block(held, indent + step)]
        return lines

    def text(self, value):
        return "\n".join([*self.block({"mjsim": "1", **value}, 0), *self.above(0)]) + "\n"


@pytest.mark.slow
@settings(
    max_examples=40,
    deadline=None,
    phases=[Phase.explicit, Phase.reuse, Phase.generate],
    suppress_health_check=[HealthCheck.too_slow],
)
@given(st.dictionaries(keys, values(3), max_size=4), st.integers(0, 2**32))
def test_any_layout_keeps_values_and_comments_and_is_final(value, seed):
    text = Scribe(seed).text(value)
    before, problems = read_text(text, file="room.yaml")
    if problems:  # a key twice, once in quotes
        return
    laid = format_text(text, file="room.yaml")
    after, _ = read_text(laid, file="room.yaml")
    assert after.value == before.value
    assert sorted(read_commented(laid)[1]) == sorted(read_commented(text)[1]) == sorted(comments_in(text))
    assert format_text(laid, file="room.yaml") == laid


def comments_in(text):
    """Return the comments that a scribe wrote, found by their sign and number."""
    for line in text.split("\n"):
        if "# " in line:
            yield line[line.index("# ") :].rstrip()


@pytest.mark.parametrize(
    "text",
    [
        "mjsim: 1\nname: &n a\nrun: {drivers: {a: {navigator: {use: 'a:B', n: *n}}}}   # kept\n",
        "# only\n# comments above\n---\nmjsim: 1 # here\n...\n# below\n",
        '{"mjsim": 1, "lamps": [{"at": [1, 2]}]}',
        "mjsim: 1\r\nlamps: []   # none\r\n",
        "mjsim: 1\r\r\r\r\rname: a   # of an old machine\rfloor: {}\r",
        "mjsim: 1\n\u2028\u2028\n\x85\x85\nname: a\n\nfloor: {}\n",
        "mjsim: 1\nname:\n",
        "mjsim: 1\nrun: {drivers: {a: {navigator: {use: 'a:B', text: 'two\n  lines'}}}}\n",
        "mjsim: 1\na:\n  text: |   # several\n    one\n     two # no comment\n  other: >-\n    folded\n    text\n",
        "mjsim: 1\na: [1, # one\n 2] # two\nb: {x: 1,\n # of y\n y: 2}\n",
        "mjsim: 1\na:\n-\n  - 1   # x\n-\n  # of b\n  b: 2\n",
    ],
)
def test_odd_texts_are_laid_out_without_loss(text):
    laid = format_text(text, file="room.yaml")
    assert read_text(laid, file="")[0].value == read_text(text, file="")[0].value
    assert read_commented(laid)[1] == read_commented(text)[1]
    assert format_text(laid, file="room.yaml") == laid


@pytest.mark.slow
@pytest.mark.parametrize("path", WORLDS, ids=lambda path: path.stem)
def test_the_shipped_worlds_are_laid_out(path):
    text = path.read_text(encoding="utf-8")
    assert format_text(text, file=path.name) == text
    assert max(len(line) for line in text.splitlines() if "# " not in line) <= 120


def test_what_an_alias_stands_for_stays_before_it():
    text = "mjsim: 1\nlamps:\n  - {height: &h 2, at: [1, 1], brightness: *h}\n"
    assert format_text(text, file="room.yaml") == text


def test_what_is_no_yaml_or_cannot_be_laid_out_is_refused_in_one_line():
    for text, message in (
        ("mjsim: [", "room.yaml:1:9: this is not YAML"),
        ("a: 1\na: 2\n", "room.yaml:2:1: key 'a' is written twice"),
        ("- 1\n", "room.yaml:1:1: this text cannot be formatted without loss; format it by hand"),
    ):
        with pytest.raises(WorldError) as caught:
            format_text(text, file="room.yaml")
        assert str(caught.value).startswith(message)


def run_fmt(*arguments):
    with pytest.raises(SystemExit) as done:
        main(["fmt", *map(str, arguments)])
    return done.value.code


def test_the_command_writes_what_changes_and_check_only_tells(tmp_path, capsys):
    untidy, tidy, broken = (tmp_path / name for name in ("untidy.yaml", "tidy.yaml", "broken.yaml"))
    untidy.write_text(UNTIDY)
    untidy.chmod(0o640)
    tidy.write_text(TIDY)
    broken.write_text("mjsim: [")
    assert run_fmt("--check", tidy) == 0
    assert run_fmt("--check", untidy, tidy) == 1
    assert capsys.readouterr().out == f"{untidy}\n"
    assert untidy.read_text() == UNTIDY
    assert run_fmt("--check", untidy, broken, tmp_path / "none.yaml") == 2
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 2
    assert said[0].startswith(f"{broken}:1:9: this is not YAML")
    assert said[1].startswith("no file")
    assert run_fmt(untidy, tidy) == 0
    assert capsys.readouterr().out == f"{untidy}\n"
    assert untidy.read_text() == TIDY
    assert untidy.stat().st_mode & 0o777 == 0o640
    assert sorted(path.name for path in tmp_path.iterdir()) == ["broken.yaml", "tidy.yaml", "untidy.yaml"]
