"""The pages say what the program does."""

import runpy
from pathlib import Path

ROOT = Path(__file__).parent.parent


def test_the_page_of_the_world_file_is_what_the_schema_says():
    made = runpy.run_path(str(ROOT / "scripts" / "make_world_page.py"))["world_page"]()
    assert (ROOT / "docs" / "world-file.md").read_text(encoding="utf-8") == made
    assert "| `thickness` | number above 0 to 10000 | `0.1` | [m] |" in made


def test_the_schema_beside_the_shipped_worlds_is_what_the_program_prints():
    made = runpy.run_path(str(ROOT / "scripts" / "make_world_page.py"))["schema_text"]()
    assert (ROOT / "worlds" / "mjsim.schema.json").read_text(encoding="utf-8") == made
