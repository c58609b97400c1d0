"""Each tutorial runs as its notebook in a clean folder; notebooks and all pictures of the docs are those of today."""

import json
import re
import runpy
import shlex
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
SECONDS = re.compile(r"(\bseconds(?:: |=| ))\d+(?=\D)")
"""What a page runs; two seconds show that it can."""
COMMAND = """
import json, os, socket, sys

with socket.socket(socket.AF_UNIX) as wire:
    wire.connect({socket!r})
    said = json.dumps([os.getcwd(), dict(os.environ), sys.argv]).encode()
    socket.send_fds(wire, [len(said).to_bytes(4, "big")], [0, 1, 2])
    wire.sendall(said)
    sys.exit(int(wire.recv(9)))
"""
"""The program `mjsim` of a notebook: has the command run where everything is imported, with its own streams."""
NOTEBOOKS = """
import json, os, socket, sys
import IPython.terminal.ipapp, matplotlib.pyplot, nbformat.v4, pandas, scipy.stats
import mjsim.algorithms.beacon_vision.picture_beacons, mjsim.algorithms.ekf_slam.ekf_slam
import mjsim.cli.program, mjsim.cli.reports, mjsim.cli.run_commands, mjsim.cli.worlds
import mjsim.output.sets, mjsim.record.recording_reader, mjsim.record.recording_writer, mjsim.report.report_page
import mjsim.run.loop, mjsim.sim.simulation, mjsim.world.edit.snippet

def fork(folder, streams, run):
    if (process := os.fork()) == 0:
        os.chdir(folder)
        for number, stream in enumerate(streams):
            os.dup2(stream, number)
        sys.exit(run())
    return os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])

def command(environment, words):
    os.environ.clear()
    os.environ.update(environment)
    sys.argv[:] = words
    return mjsim.cli.program.main()

if hasattr(os, "sched_setaffinity"):
    os.sched_setaffinity(0, [min(os.sched_getaffinity(0))])  # a sweep has one worker
if (server := os.fork()) == 0:
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(sys.argv[1])
        listener.listen()
        while True:
            wire, _ = listener.accept()
            length, streams, *_ = socket.recv_fds(wire, 4, 3)
            folder, *what = json.loads(wire.recv(int.from_bytes(length, "big"), socket.MSG_WAITALL))
            wire.sendall(b"%d" % fork(folder, streams, lambda: command(*what)))
            for each in (wire.detach(), *streams):
                os.close(each)
for line in sys.stdin:
    folder, arguments = json.loads(line)
    said = os.open(os.path.join(folder, "said.txt"), os.O_WRONLY | os.O_CREAT)
    streams = [os.open(os.devnull, os.O_RDONLY), said, said]
    print(fork(folder, streams, lambda: IPython.start_ipython(arguments)), flush=True)
os.kill(server, 9)
"""
"""Runs each notebook that it is told, and each command of one, in a process of its own, which runs nothing else.

They share what was imported before, which would take half of their processor time.
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
def notebooks(tmp_path_factory) -> Iterator[Child]:
    folder = tmp_path_factory.mktemp("bin")
    command = folder / "mjsim"
    (folder / "command.py").write_text(COMMAND.format(socket=str(folder / "socket")))
    # The line that names an interpreter has no path with a space.
    command.write_text(f'#!/bin/sh\nexec {shlex.quote(sys.executable)} -IS "$(dirname "$0")/command.py" "$@"\n')
    command.chmod(0o755)
    environment = MAKER["environment"]()
    environment["PATH"] = f"{folder}:{environment['PATH']}"
    words = [sys.executable, "-c", NOTEBOOKS, folder / "socket"]
    with child(words, env=environment, stdin=subprocess.PIPE) as program:
        yield program


@pytest.mark.slow
@pytest.mark.timeout(100)
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_notebook_runs_from_a_clean_folder(page, tmp_path, notebooks):
    if page.stem in NEEDS_NETWORK:
        from tests.bridge.test_bridge import namespaces_are_allowed  # skips where there is no cyclonedds

        if not namespaces_are_allowed():
            pytest.skip("needs Linux with namespaces for users")
    arguments = MAKER["put"](page, tmp_path)
    notebook = tmp_path / page.with_suffix(".ipynb").name
    notebook.write_text(SECONDS.sub(r"\g<1>2", notebook.read_text(encoding="utf-8")), encoding="utf-8")
    notebooks.say(json.dumps([str(tmp_path), arguments]) + "\n")
    code, said = notebooks.line(within=90), (tmp_path / "said.txt").read_text(encoding="utf-8")
    assert code == "0\n", said + notebooks.rest("stderr", within=1) if not notebooks.runs() else said
    assert "Traceback" not in said
    for path in MAKER["pictures"](page):
        assert (tmp_path / path.name.removeprefix(f"{page.stem}-")).stat().st_size > 5000
