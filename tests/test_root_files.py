"""Files that a user keeps in the root of a clone are none of the checks' business."""

import shutil
import sys
from pathlib import Path

import mjsim
from tests.children import completed

ROOT = Path(mjsim.__file__).parents[1]
USERS = ("my_slam.py", "room/helper.py", "out/run/plot.py", "conftest.py", "mine/tests/test_slam.py")
OWN = ("mjsim/errors.py", "mjsim/world/__init__.pyi", "algorithms/waypoints.py", "tests/test_cli.py", "setup.py")


def test_linters_look_at_the_own_folders_alone(tmp_path):
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    for name in (*USERS, *OWN):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    words = [sys.executable, "-m", "ruff", "check", "--show-files", "--no-cache"]
    shown = completed(words, cwd=tmp_path).stdout.splitlines()
    assert sorted(Path(line).relative_to(tmp_path).as_posix() for line in shown) == sorted(OWN)
