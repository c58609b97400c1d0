"""What the server says and the page shows as its own words is in the table of words, for other languages."""

import ast
import re
from pathlib import Path

import pytest

import mjsim
from mjsim.report import FIGURES
from mjsim.world import EVENT_KINDS

ROOT = Path(mjsim.__file__).parent
TABLE = re.compile(r'^  "([\w.]+)":\s+"(.*)",$', re.MULTILINE)
PLACE = ROOT / "web" / "page" / "src" / "words"
WORDS, SAID = (dict(TABLE.findall((PLACE / name).read_text("utf-8"))) for name in ("en_server.ts", "en_said.ts"))
KNOWN = {re.sub(r"\{\w+\}", "{}", text) for text in SAID.values()}
ELSEWHERE = (
    *(
        "report/comparison.py",
        "report/consistency.py",
        "report/comparison_tables.py",
        "report/labels.py",
        "report/paired.py",
    ),
    *("run/loop.py", "run/pilot.py", "session/gate.py", "session/session.py", "world/items/timeline/arm_events.py"),
    *("world/check/lead_checks.py", "world/check/mover_checks.py", "world/files/within.py"),
    *("world/items/timeline/events.py",),
    *("world/edit/apart.py", "world/edit/changes.py", "world/edit/edited_text.py", "world/edit/singles.py"),
)
"""Other modules whose sentences the page shows."""
NOT_MET = {
    *("send this as application/json", "{}: {}{}", "size is {}; it must be a number of pixels"),
    *("{} is {}; it must be a number", "{} is {}; it must be from {} to {}", "no {}[{}] in this text; there are {}"),
    *("'{}' is not the id of a draft; see the list", "no pictures of kind '{}'; there are {}"),
    *("'{}' is not the name of a tab; it has 16 digits, 0 to f", "a newer view was asked for", "this {}"),
    *("'{}' is not in 'out'; only files in it can be downloaded", "mjsim has no module '{}'"),
    "path '{}' is a pipe or a device; name a file",
    *("'{}{}' cannot be written: {}", "line {}: {}{}"),
}
"""Of requests that the page never makes, and what other sentences stand in."""


def template(node):
    """Return a text of a program with {} for its values."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(part.value if isinstance(part, ast.Constant) else "{}" for part in node.values)
    return None


def test_each_refusal_of_the_server_is_in_the_table():
    files = [path for path in (ROOT / "web").rglob("*.py") if "RefusedError(" in path.read_text("utf-8")]
    calls = [
        node for path in files for node in ast.walk(ast.parse(path.read_text("utf-8"))) if isinstance(node, ast.Call)
    ]
    refused = [call for call in calls if getattr(call.func, "id", "") == "RefusedError" and len(call.args) > 1]
    texts = {template(call.args[1]) for call in refused} - {None}
    assert len(texts) > 35
    assert texts - KNOWN - NOT_MET == set()


def test_each_event_of_a_robot_is_in_the_table():
    texts = {
        template(node.args[2])
        for name in ("run/loop.py", "run/pilot.py")
        for node in ast.walk(ast.parse((ROOT / name).read_text("utf-8")))
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "RobotEvent"
    } - {None}
    assert len(texts) == 6
    assert texts - KNOWN == set()


@pytest.mark.slow
def test_the_sentences_of_the_table_are_those_of_the_server():
    """One that was reworded would never be found."""
    own = [
        path
        for path in (ROOT / "web").rglob("*.py")
        if re.search(r"Error\(|SEATED =|def _held", path.read_text("utf-8"))
    ]
    nodes = [
        node for path in (*own, *map(ROOT.joinpath, ELSEWHERE)) for node in ast.walk(ast.parse(path.read_text("utf-8")))
    ]
    program = "\n".join(node.value for node in nodes if isinstance(node, ast.Constant) and isinstance(node.value, str))
    parts = {part.strip() for text in SAID.values() for part in re.split(r"\{\w+\}", text.replace('\\"', '"'))}
    assert {part for part in parts if part not in program} == set()


def test_figures_and_events_of_the_table_are_those_that_there_are():
    figures = {f"figure.{figure.key}": figure.title for figure in FIGURES}
    events = {f"event.{kind}" for kind in (*EVENT_KINDS, "bump", "blocked", "fall", "fault", "found", "lost")}
    assert {key: text for key, text in WORDS.items() if key.startswith("figure.")} == figures
    assert {key for key in WORDS if key.startswith("event.")} == events
