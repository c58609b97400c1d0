"""One word has one meaning: those that CONTRIBUTING gives up stand in no name and on no page."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
ROW = re.compile(r"^\| [^|]+ \| [^|]+ \| ((?:`\w+`(?:, )?)+) (?:in constants )?\|$", re.MULTILINE)
"""A row of the list of words, and the words that are not used."""
WORD = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])")


def given_up() -> list[tuple[set[str], bool]]:
    """Return the words of each row, and whether only constants must not have them."""
    rows = ROW.finditer((ROOT / "CONTRIBUTING.md").read_text("utf-8"))
    return [(set(re.findall(r"`(\w+)`", row[1])), "in constants" in row[0]) for row in rows]


def names(tree: ast.Module) -> Iterator[str]:
    """Yield what a module defines: functions, classes, arguments, variables and attributes."""
    for node in ast.walk(tree):
        match node:
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name) | ast.arg(arg=name):
                yield name
            case ast.Name(id=name, ctx=ast.Store()) | ast.Attribute(attr=name, ctx=ast.Store()):
                yield name


@pytest.mark.slow
def test_words_that_are_given_up_stand_in_no_name_and_on_no_page():
    rows = given_up()
    assert len(rows) > 10
    everywhere = set.union(*(words for words, constants in rows if not constants))
    constants = set.union(*(words for words, constants in rows if constants))
    suspicious, found = re.compile("|".join(everywhere | constants), re.IGNORECASE), []
    for path in (path for folder in ("mjsim", "algorithms") for path in (ROOT / folder).rglob("*.py")):
        text = path.read_text("utf-8")
        if not suspicious.search(f"{path.stem} {text}"):
            continue  # parsing all takes seconds
        for name in {path.stem, *names(ast.parse(text))}:
            words = {word.lower() for word in WORD.findall(name)}
            if words & (everywhere | (constants if name.isupper() else set())):
                found.append(f"{path.relative_to(ROOT)}: {name}")
    for page in (ROOT / "docs").rglob("*.md"):
        text = re.sub(r"```.*?```|`[^`]*`|\([^)]*\)", "", page.read_text("utf-8"), flags=re.DOTALL)
        found += [f"{page.name}: {word}" for word in re.findall(r"\b[a-z]+\b", text) if word in everywhere]
    assert not found, "\n".join(found)
