"""What tests of the command line share."""

from pathlib import Path

import pytest

from tests.cli.shell import FORWARD, ROOM


@pytest.fixture
def room(tmp_path, monkeypatch):
    """A folder with a world and its navigator, which is the working one."""
    monkeypatch.chdir(tmp_path)
    Path("room.yaml").write_text(ROOM)
    Path("forward.py").write_text(FORWARD)
    return tmp_path
