"""The program on the page of sweeps runs."""

import os
import re
import sys
from pathlib import Path

import pytest

from tests.children import completed

PAGE = Path(__file__).parents[2] / "docs" / "sweeps.md"
ROOM = """
mjsim: 1
walls: [{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true}]
robots: [{name: scout, at: [1, 1]}]
"""


def on_one_core():
    """Have a sweep start one worker."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, [min(os.sched_getaffinity(0))])


@pytest.mark.slow
def test_the_program_of_the_page_runs_and_its_folder_holds_what_the_page_lists(tmp_path):
    page = PAGE.read_text(encoding="utf-8")
    (code,) = re.findall("```python\n(.*?)```", page, re.DOTALL)
    (tmp_path / "room.yaml").write_text(ROOM)
    (tmp_path / "program.py").write_text(code)
    # As a program of its own: its workers look for it where it was started.
    done = completed([sys.executable, "program.py"], cwd=tmp_path, preexec_fn=on_one_core)
    assert done.stdout.endswith(" {'robots.scout.odometry.scale': 1.05}\n")
    listed = {
        name.rstrip("/")
        for line in page.splitlines()
        if line.startswith("| `")
        for name in re.findall(r"`([\w./]+)`", line.split("|")[1])
    }
    assert {path.name for path in (tmp_path / "sweep").iterdir()} == listed
