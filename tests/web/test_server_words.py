"""What the server names by keys is in the table of words, for other languages."""

import re
from pathlib import Path

import mjsim
from mjsim.report import FIGURES
from mjsim.world import EVENT_KINDS

ROOT = Path(mjsim.__file__).parent
TABLE = re.compile(r'^  "([\w.]+)":\s+"(.*)",$', re.MULTILINE)
PLACE = ROOT / "web" / "page" / "src" / "words"
WORDS = dict(TABLE.findall((PLACE / "en_server.ts").read_text("utf-8")))


def test_figures_and_events_of_the_table_are_those_that_there_are():
    figures = {f"figure.{figure.key}": figure.title for figure in FIGURES}
    events = {f"event.{kind}" for kind in (*EVENT_KINDS, "bump", "blocked", "fall", "fault", "found", "lost")}
    assert {key: text for key, text in WORDS.items() if key.startswith("figure.")} == figures
    assert {key for key in WORDS if key.startswith("event.")} == events
