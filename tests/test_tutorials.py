"""Each tutorial runs as its notebook in a clean folder; notebooks and all pictures of the docs are those of today."""

import json
import runpy
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.children import Child, child

ROOT = Path(__file__).parent.parent
MAKER = runpy.run_path(str(ROOT / "scripts" / "make" / "tutorials.py"))
PAGES = sorted(MAKER["FOLDER"].glob("*.md"))
PICTURES = runpy.run_path(str(ROOT / "scripts" / "make" / "pictures.py"))
NEEDS_NETWORK = {"ros2"}
"""Tutorials that run in a private network, which not every machine allows."""
NOTEBOOKS = """
import json, os, sys
import IPython.terminal.ipapp, matplotlib.pyplot, mjsim.algorithms.ekf_slam.ekf_slam
import mjsim.cli.program, mjsim.record.recording_reader, mjsim.report.plots, mjsim.run.loop, mjsim.sim.simulation

for line in sys.stdin:
    folder, arguments = json.loads(line)
    if (process := os.fork()) == 0:
        os.chdir(folder)
        for stream, file, how in ((0, os.devnull, os.O_RDONLY), (1, "said.txt", os.O_WRONLY | os.O_CREAT)):
            os.dup2(os.open(file, how), stream)
        os.dup2(1, 2)
        sys.exit(IPython.start_ipython(arguments))
    print(os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]), flush=True)
"""
"""Runs each notebook that it is told in a process of its own, which runs nothing else.

They share what was imported before, which would take a fourth of their processor time.
"""


def test_there_are_as_many_as_the_list_names():
    listed = (ROOT / "docs" / "tutorials.md").read_text(encoding="utf-8")
    assert len(PAGES) >= 7
    assert all(f"tutorials/{page.name}" in listed for page in PAGES)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_notebook_is_that_of_the_page(page):
    made = MAKER["notebook"](page.read_text(encoding="utf-8"))
    assert page.with_suffix(".ipynb").read_text(encoding="utf-8") == made, "run scripts/make/tutorials.py"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_pictures_are_those_of_the_code_of_the_page(page):
    made, text = json.loads(MAKER["SOURCES"].read_text(encoding="utf-8")), page.read_text(encoding="utf-8")
    assert made[page.stem] == MAKER["digest"](text), "run scripts/make/tutorials.py --pictures"
    assert all(path.is_file() for path in MAKER["pictures"](page))


def test_pictures_and_film_of_the_docs_are_no_older_than_their_scripts_and_worlds():
    assert [path.name for path in PICTURES["stale"]()] == [], "run scripts/make/pictures.py"


def test_pictures_are_stale_after_a_change_of_a_world_that_their_script_names(tmp_path, monkeypatch):
    script = tmp_path / "one_picture.py"
    script.write_text('load_world("gallery")')
    world = tmp_path / "worlds" / "gallery.yaml"
    world.parent.mkdir()
    world.write_text("mjsim: 1\n")
    monkeypatch.setitem(PICTURES["digest"].__globals__, "ROOT", tmp_path)
    before = PICTURES["digest"](script)
    (world.parent / "office.yaml").write_text("mjsim: 1\n")
    assert PICTURES["digest"](script) == before
    world.write_text("mjsim: 1\nname: other\n")
    assert PICTURES["digest"](script) != before


@pytest.fixture(scope="module")
def notebooks() -> Iterator[Child]:
    with child([sys.executable, "-c", NOTEBOOKS], env=MAKER["environment"](), stdin=subprocess.PIPE) as program:
        yield program


@pytest.mark.slow
@pytest.mark.timeout(100)
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_notebook_runs_from_a_clean_folder(page, tmp_path, notebooks):
    if page.stem in NEEDS_NETWORK:
        from tests.bridge.test_bridge import namespaces_are_allowed  # skips where there is no cyclonedds

        if not namespaces_are_allowed():
            pytest.skip("needs Linux with namespaces for users")
    notebooks.say(json.dumps([str(tmp_path), MAKER["put"](page, tmp_path)]) + "\n")
    code, said = notebooks.line(within=90), (tmp_path / "said.txt").read_text(encoding="utf-8")
    assert code == "0\n", said + notebooks.rest("stderr", within=1) if not notebooks.runs() else said
    assert "Traceback" not in said
    for path in MAKER["pictures"](page):
        assert (tmp_path / path.name.removeprefix(f"{page.stem}-")).stat().st_size > 5000
