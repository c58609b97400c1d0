"""Files that a module needs on another machine: its imports beside the world, packages under development, and data."""

import pytest

from mjsim.errors import UsageError
from mjsim.modules.python import needed_files
from mjsim.modules.python.needed_files import python_files
from mjsim.world import Source, Use

FILES = {
    "w/own.py": "import helper, dev_single\nfrom dev_pack import sub\nimport numpy\nfrom . import near\n",
    "w/helper.py": "TABLE = 'lookup.csv'\nimport os\n",
    "w/near.py": "",
    "w/unused.py": "",
    "w/lookup.csv": "1,2\n",
    "w/maps/own.csv": "3,4\n",
    "w/world.yaml": "",
    "site/dev_pack/__init__.py": "",
    "site/dev_pack/sub.py": "import dev_single\nfrom ..other import what\n",  # above the package, which Python refuses
    "site/dev_pack/notes.txt": "",
    "site/dev_single.py": "",
    "site/other.py": "",
    "secret.csv": "",
}


@pytest.fixture
def source(tmp_path, monkeypatch):
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    monkeypatch.syspath_prepend(tmp_path / "site")
    return Source(file="world.yaml", folder=tmp_path / "w")


USE = Use(use="own.py:Own", tables=["maps/own.csv", "../secret.csv", "missing.csv", "text"])


def test_imports_are_followed_and_keep_their_places(source):
    found = python_files([USE], source)
    beside = {"own.py", "helper.py", "near.py", "lookup.csv", "maps/own.csv"}
    installed = {"modules/dev_pack/__init__.py", "modules/dev_pack/sub.py", "modules/dev_single.py"}
    assert found.keys() == beside | installed
    assert found["maps/own.csv"] == b"3,4\n"
    code = python_files([USE], source, data=False)
    assert code.keys() == {name for name in found if name.endswith(".py")}


@pytest.mark.parametrize(("limit", "value"), [("MAX_FILES", 3), ("MAX_TOTAL", 30)])
def test_more_files_than_a_run_should_need_are_refused(source, monkeypatch, limit, value):
    monkeypatch.setattr(needed_files, limit, value)
    with pytest.raises(UsageError, match=r"modules of 'world\.yaml' have over"):
        python_files([USE], source)
