"""Every command that a page shows can be typed: its options exist, and the shipped worlds that it names too."""

import re
import shlex
from pathlib import Path

import pytest
from typer.main import get_command

from mjsim.cli.program import COMMANDS, app
from mjsim.world import shipped_worlds

ROOT = Path(__file__).parent.parent
PAGES = [*sorted((ROOT / "docs").rglob("*.md")), ROOT / "README.md"]
SPAN = re.compile(r"`(mjsim [a-z][^`\n]*)`|^ *(?:\$ )?(mjsim [a-z][^\n`]*)$", re.MULTILINE)
WORLDS = {"run", "lab", "show", "compile", "ergonomics", "bridge", "sweep"}
"""Commands whose first argument is a world."""


def commands(page: Path) -> list[list[str]]:
    """Return the words of each command of a page, without comments and what a shell does around it."""
    text = re.sub(r"\\\n\s*", " ", page.read_text(encoding="utf-8"))
    lines = [next(filter(None, match.groups())) for match in SPAN.finditer(text)]
    return [shlex.split(re.split(r"\s[|;&>]|;", line)[0], comments=True)[1:] for line in lines]


@pytest.fixture(scope="module")
def known():
    return get_command(app(COMMANDS)).commands


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_the_commands_of_a_page_exist_with_their_options_and_worlds(page, known):
    wrong = []
    for words in commands(page):
        if words[0] not in known:
            wrong.append(" ".join(words))
            continue
        options = {name for each in known[words[0]].params for name in (*each.opts, *each.secondary_opts)}
        given = [word.partition("=")[0] for word in words[1:] if re.fullmatch(r"--?[a-zA-Z][\w-]*(=.*)?", word)]
        named = words[1] if len(words) > 1 and words[0] in WORLDS else ""
        is_shipped = not re.fullmatch(r"[a-z][a-z0-9-]*", named) or named in shipped_worlds()
        if not is_shipped or {*given} - options - {"--help"}:
            wrong.append(" ".join(words))
    assert wrong == []


def test_pages_show_many_commands():
    assert sum(len(commands(page)) for page in PAGES) > 100
