"""docs/architecture.md and CONTRIBUTING.md say what is there."""

import re
import runpy
from pathlib import Path

import pytest

import mjsim

ROOT = Path(mjsim.__file__).parent.parent
PAGES = ["CONTRIBUTING.md", "docs/architecture.md"]
DRAWING = runpy.run_path(str(ROOT / "scripts" / "make" / "architecture_picture.py"))


def test_an_arrow_that_others_stand_for_is_left_out():
    assert DRAWING["essential"]({"a": {"b", "c"}, "b": {"c"}, "c": set()}) == {"a": {"b"}, "b": {"c"}, "c": set()}


@pytest.mark.parametrize("page", PAGES)
def test_every_file_that_a_page_names_is_there(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    named = re.findall(r"`((?:mjsim|algorithms|worlds|scripts|docs|tests)/[\w./*-]*|[\w]+/[\w/]+\.py)[^`]*`", text)
    assert named
    for name in named:
        pattern = re.sub(r"[A-Z]{4,}", "*", name).rstrip("/")  # KIND, NAME and the like: some such file is there
        assert any(next(folder.glob(pattern), None) for folder in (ROOT, ROOT / "mjsim")), name
