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
FILE = re.compile(r"(?:worlds|assets|algorithms|docs|scripts|tests)/[\w./-]+\.\w+")
"""Files of the repository."""


def commands(page: Path) -> list[list[str]]:
    """Return the words of each command of a page, without comments and what a shell does around it."""
    text = re.sub(r"\\\n\s*", " ", page.read_text(encoding="utf-8"))
    lines = [next(filter(None, match.groups())) for match in SPAN.finditer(text)]
    return [shlex.split(re.split(r"\s[|;&>]|;", line)[0], comments=True)[1:] for line in lines]


@pytest.fixture(scope="module")
def known():
    return get_command(app(COMMANDS)).commands


def fault_of(words: list[str], known) -> str | None:
    """Return what cannot be typed in a command."""
    if words[0] not in known:
        return "no such command"
    options = {name for each in known[words[0]].params for name in (*each.opts, *each.secondary_opts)}
    for word in words[1:]:
        name = word.partition("=")[0]
        if re.fullmatch(r"--?[a-zA-Z][\w-]*", name) and name not in options | {"--help"}:
            return f"no option {name}"
        if FILE.fullmatch(word) and not (ROOT / word).exists():
            return f"no file {word}"
    places = [word for word in words[1:] if not word.startswith("-")]
    named = places[0] if places and words[0] in WORLDS else ""
    if re.fullmatch(r"[a-z][a-z0-9-]*", named):
        if named not in shipped_worlds():
            return f"no world {named}"
        # Reading these worlds takes seconds.
        text = next((ROOT / "worlds").rglob(f"{named}.yaml")).read_text(encoding="utf-8").partition("\nplants:")[2]
        plants = re.findall(r"name: ([\w-]+)", text)
        if words[0] == "lab" and len(places) > 1 and words[2] == places[1] and places[1] not in (*plants, "PLANT"):
            return f"no plant {places[1]}"
    return None


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_the_commands_of_a_page_exist_with_their_options_worlds_plants_and_files(page, known):
    faults = {" ".join(words): fault_of(words, known) for words in commands(page)}
    assert {line: fault for line, fault in faults.items() if fault} == {}


@pytest.mark.parametrize(
    ("line", "fault"),
    [
        ("mjsim rnu office", "no such command"),
        ("mjsim run office --sede 3", "no option --sede"),
        ("mjsim run ofice", "no world ofice"),
        ("mjsim lab lab-3-margins moter -o out", "no plant moter"),
        ("mjsim check worlds/nowhere.yaml", "no file worlds/nowhere.yaml"),
    ],
)
def test_a_command_of_a_page_that_cannot_be_typed_is_found(line, fault, tmp_path, known):
    page = tmp_path / "page.md"
    for text in (f"```sh\n{line}\n```\n", f"Type `{line}` once.\n", f"| a | `{line}` |\n"):
        page.write_text(text)
        assert [fault_of(words, known) for words in commands(page)] == [fault]


def test_pages_show_many_commands():
    assert sum(len(commands(page)) for page in PAGES) > 100
