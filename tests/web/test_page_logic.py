"""Geometry, names, texts and state of the page, in the Node that comes with Playwright: its sources as they are."""

import os
from pathlib import Path

import playwright
import pytest

from tests.children import completed

NODE = Path(playwright.__file__).with_name("driver") / ("node.exe" if os.name == "nt" else "node")
FOLDER = Path(__file__).parents[1] / "page"
FILES = sorted(FOLDER.glob("*.test.mjs"))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name.partition(".")[0])
def test_facts_of_the_page_hold_in_node(file):
    """What fails is named in the output: each file has facts of its own."""
    completed([NODE, "--import", (FOLDER / "sources.mjs").as_uri(), file])


def test_there_are_facts_of_the_page():
    assert len(FILES) >= 2
