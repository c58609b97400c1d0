"""The page of people: its tables are those of the package."""

import runpy
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def test_the_tables_of_the_page_are_as_they_are_now():
    script = runpy.run_path(str(ROOT / "scripts" / "make" / "people_page.py"))
    text = (ROOT / "docs" / "people.md").read_text(encoding="utf-8")
    assert script["page"](text) == text, "run scripts/make/people_page.py"
