"""The pages say what the program does."""

import doctest
import fnmatch
import functools
import importlib
import itertools
import re
import runpy
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
import yaml

import mjsim
from mjsim.modules import ROLES
from mjsim.run import drivers_of
from mjsim.world import EVENT_KINDS, check_world

ROOT = Path(__file__).parent.parent


PAGES = sorted(
    [
        *(ROOT / "docs").rglob("*.md"),
        *(ROOT / f"{name}.md" for name in ("README", "CHANGELOG", "CONTRIBUTING", "SECURITY")),
        *(ROOT / "scripts").glob("**/*.md"),
    ]
)
GENERATED = {"world-file.md", "worlds.md", "robots.md"}
"""Pages of reference that `scripts/make` writes; the head of that of robots is beside its script, and counted."""
TABLE = re.compile(r"<!-- (\w+): begin -->.*?<!-- \1: end -->", re.DOTALL)
"""A table in a page that `scripts/make` writes."""
FENCED = re.compile(r"^ *(```+)[^`\n]*\n.*?^ *\1$", re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_prose_is_wrapped_at_120_columns(page):
    # What cannot be wrapped is left out: code, tables, pictures and a code span or a link that is long by itself.
    text = FENCED.sub(lambda block: "\n" * block[0].count("\n"), page.read_text(encoding="utf-8"))
    long = [
        f"{page.name}:{number}: {line[:60]}..."
        for number, line in enumerate(text.splitlines(), start=1)
        if len(line) > 120
        and not line.startswith(("|", "    "))
        and not re.fullmatch(r" *(?:- )?(!\[[^]]*\]\([^)]*\)|`[^`]*`|\S+)[.,;:]?", line)
    ]
    assert long == []


TREE = re.compile(r"^```\{toctree\}\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@functools.cache
def anchors(page: Path) -> set[str]:
    """Return what links may point to in a page: its headings as GitHub writes them, the second of a name as NAME-1."""
    found: set[str] = set()
    for heading in re.findall("^#+ (.*)$", FENCED.sub("", page.read_text(encoding="utf-8")), re.MULTILINE):
        shown = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading)
        name = re.sub(r"[^\w\- ]", "", shown.lower()).replace(" ", "-")
        again = (f"{name}-{count}" for count in itertools.count(1))
        while name in found:
            name = next(again)
        found.add(name)
    return found


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_of_a_page_lead_somewhere(page):
    # The head of the page of robots is read as part of docs/robots.md.
    folder = ROOT / "docs" if page.name == "robots_head.md" else page.parent
    text = re.sub("`[^`]*`", "", FENCED.sub("", page.read_text(encoding="utf-8")))
    dead = []
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if re.match("[a-z]+:", target):
            continue
        name, _, anchor = target.partition("#")
        to = (folder / name).resolve() if name else page
        if not to.exists() or (anchor and to.suffix == ".md" and anchor not in anchors(to)):
            dead.append(target)
    assert dead == []


def test_every_page_is_once_in_the_table_of_contents_of_the_site():
    pages = {
        page.relative_to(ROOT / "docs").with_suffix("").as_posix() for page in PAGES if ROOT / "docs" in page.parents
    }
    listed = ["index"]
    for name in listed:
        text = (ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8")
        for entry in itertools.chain(*(re.findall(r"^[\w/*-]+$", tree, re.M) for tree in TREE.findall(text))):
            listed += fnmatch.filter(sorted(pages), entry)
    assert sorted(listed) == sorted(pages)


def test_pages_outside_the_generated_reference_stay_short():
    pages = [page for page in PAGES if page.parent.name in ("docs", "make", "reference", "tutorials")]
    texts = {str(page): TABLE.sub("", page.read_text("utf-8")) for page in pages if page.name not in GENERATED}
    words = {name: len(re.findall(r"\S*\w\S*", text)) for name, text in texts.items()}  # not bars of tables
    assert sum(words.values()) <= 45_000, words


def test_the_changelog_and_the_citation_are_of_this_version():
    version = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["version"]
    newest, date = re.findall(r"^## \[(.+)\] - (.+)$", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.M)[0]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    assert [newest, date] == [version, str(citation["date-released"])]
    assert citation["version"] == version


def test_the_examples_in_docstrings_print_what_they_say():
    modules = ["mjsim.geometry", "mjsim.interface.values", "mjsim.interface.readings"]
    found = [doctest.testmod(importlib.import_module(name)) for name in modules]
    assert [each.failed for each in found] == [0, 0, 0]
    assert all(each.attempted for each in found)


@pytest.mark.slow
def test_every_public_class_has_an_example_that_runs(tmp_path, monkeypatch, capfd):
    examples = ROOT / "docs" / "site" / "examples.py"
    headings = re.findall("^# %% (.+)$", examples.read_text("utf-8"), re.M)
    named = {name for heading in headings for name in heading.split(", ")}
    public = {name: getattr(mjsim, name) for name in mjsim.__all__}
    classes = {name for name, kind in public.items() if isinstance(kind, type) and ">>>" not in (kind.__doc__ or "")}
    assert named == classes
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(examples))
    assert capfd.readouterr().err == ""


@pytest.mark.slow
@pytest.mark.timeout(300)  # it imports all of mjsim, and writes 50 pages on a loaded machine
def test_the_site_builds_without_a_warning(tmp_path):
    sphinx = [sys.executable, "-m", "sphinx", "--fail-on-warning", "--keep-going", "--quiet", "-d", tmp_path / "trees"]
    built = subprocess.run([*sphinx, ROOT / "docs", tmp_path / "site"], capture_output=True, text=True, timeout=280)
    assert (built.returncode, built.stderr) == (0, "")
    # It works offline: nothing is loaded from elsewhere.
    pages = (tmp_path / "site").rglob("*.html")
    loaded = [re.findall(r'<(?:script|link|img)[^>]* (?:src|href)="https?:', page.read_text("utf-8")) for page in pages]
    assert len(loaded) > 40
    assert not any(loaded)
    reference = (tmp_path / "site" / "reference" / "python.html").read_text("utf-8")
    assert 'src="../../versions.js"' in reference  # the list of versions lies beside their folders
    assert "mjsim.Estimate.joint_covariance" in reference
    assert reference.count(">Example<") == (ROOT / "docs" / "site" / "examples.py").read_text("utf-8").count("# %% ")


def test_every_script_that_a_page_names_is_there():
    named = {name for page in PAGES for name in re.findall(r"scripts/\w+/\w+\.\w+", page.read_text(encoding="utf-8"))}
    assert len(named) > 10
    assert [name for name in sorted(named) if not (ROOT / name).is_file()] == []


@pytest.mark.slow
def test_the_page_of_the_world_file_is_what_the_schema_says():
    made = runpy.run_path(str(ROOT / "scripts" / "make" / "world_page.py"))["world_page"]()
    assert (ROOT / "docs" / "world-file.md").read_text(encoding="utf-8") == made
    assert "| `thickness` | number above 0 to 10000 | `0.1` | [m] |" in made


def test_the_page_of_what_changes_runs(capsys):
    page = (ROOT / "docs" / "changing-worlds.md").read_text(encoding="utf-8")
    (text,), (code,) = (re.findall(f"```{kind}\n(.*?)```", page, re.DOTALL) for kind in ("yaml", "python"))
    world = mjsim.parse_world(text)
    assert check_world(world) == []
    names = {"world": world}
    exec(code, names)
    sim = names["sim"]
    assert sim.door_angle("gate") > 1.1
    assert sim.truth("scout").x == 6.0
    # The cart has waited at its start, and come to its first stop.
    assert "Pose(x=7.0, y=1.0" in capsys.readouterr().out


def test_the_page_of_signals_runs(capsys):
    page = (ROOT / "docs" / "signals.md").read_text(encoding="utf-8")
    (text,), (code,) = (re.findall(f"```{kind}\n(.*?)```", page, re.DOTALL) for kind in ("yaml", "python"))
    world = mjsim.parse_world(text)
    assert check_world(world) == []
    with mjsim.Simulation(world) as sim:
        mjsim.run(sim, seconds=0.2)
    exec(code, {})
    assert capsys.readouterr().out.endswith("False\n")


def test_the_page_of_modules_runs_and_has_every_role(tmp_path, monkeypatch, capsys):
    page = (ROOT / "docs" / "modules.md").read_text(encoding="utf-8")
    told = {row[0]: set(re.findall(r"`(\w+)\(", row[1])) for row in re.findall(r"^\| `(\w+)` \| (.*) \|$", page, re.M)}
    assert told == {role: set(methods) for role, methods in ROLES.items()}
    blocks = re.findall(r"```python\n(.*?)```\n\n((?:    [^\n]*\n)+)", page, re.DOTALL)
    assert len(blocks) == page.count("```python")
    monkeypatch.chdir(tmp_path)
    for code, printed in blocks:
        exec(compile(code, "example.py", "exec"), {"__name__": "example"})
        assert capsys.readouterr().out == re.sub("^    ", "", printed, flags=re.M)


def test_every_module_that_the_page_of_algorithms_names_is_there():
    page = (ROOT / "docs" / "algorithms.md").read_text(encoding="utf-8")
    tables = [line for line in page.splitlines() if line.startswith("| `")]
    named = [
        (line.split("`")[1].split(":")[0], name)
        for line in tables
        for name in re.findall(r"`(?:\w+:)?([A-Z]\w+)`", line.split("|")[1])
    ]
    assert len(named) >= 18
    for module, name in named:
        assert isinstance(getattr(importlib.import_module(f"mjsim.algorithms.{module}"), name), type)
    (text,) = re.findall("```yaml\n(.*?)```", page, re.DOTALL)
    for use in re.findall(r'use: "(.*?):(.*?)"', text):
        assert hasattr(importlib.import_module(use[0]), use[1])


@pytest.mark.slow
def test_the_page_of_the_laboratory_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (code,) = re.findall("```python\n(.*?)```", (ROOT / "docs" / "control-lab.md").read_text("utf-8"), re.DOTALL)
    exec(code, {})
    assert (tmp_path / "bode.svg").stat().st_size > 5000


@pytest.mark.slow
def test_the_page_of_arms_runs():
    page = (ROOT / "docs" / "arms.md").read_text(encoding="utf-8")
    for code in re.findall("```python\n(.*?)```", page, re.DOTALL):
        if not code.startswith("#!"):
            exec(code, {})
    text, _ = re.findall("```yaml\n(.*?)```", page, re.DOTALL)
    world = mjsim.parse_world(f"mjsim: 1\n{text}")
    assert check_world(world) == []
    assert world.robots[0].arms[0].arm.n == 6


@pytest.mark.slow
@pytest.mark.parametrize(
    "robot",
    [
        pytest.param(
            "first",
            marks=pytest.mark.skipif(
                not (shutil.which("octave-cli") or shutil.which("octave")),
                reason="no Octave here; type: sudo apt-get install --no-install-recommends octave",
            ),
        ),
        "second",
    ],
)
def test_a_function_and_a_program_of_the_page_of_arms_move_one_step_by_step(tmp_path, robot):
    page = (ROOT / "docs" / "arms.md").read_text(encoding="utf-8")
    (function,) = re.findall("```matlab\n(.*?)```", page, re.DOTALL)
    (program,) = re.findall("```python\n(#!.*?)```", page, re.DOTALL)
    _, text = re.findall("```yaml\n(.*?)```", page, re.DOTALL)
    (tmp_path / "towards.m").write_text(function)
    (tmp_path / "towards").write_text(program)
    (tmp_path / "towards").chmod(0o755)
    # The other robot stands, and its module is not made: it may need Octave.
    kept = [line for line in text.splitlines() if f"{robot}: " in line or "navigator" not in line]
    (tmp_path / "two.yaml").write_text("\n".join(kept))
    world = mjsim.load_world(tmp_path / "two.yaml")
    assert check_world(world) == []
    with mjsim.Simulation(world) as sim:
        track = mjsim.run(sim, drivers={robot: drivers_of(world)[robot]}).joints[f"{robot}/arm"]
    np.testing.assert_allclose(track.goal[:4, 0], [0.0, 0.02, 0.04, 0.06], atol=1e-12)
    np.testing.assert_allclose(track.goal[-1], 0.2, atol=1e-12)
    np.testing.assert_allclose(track.positions[-1], 0.2, atol=0.02)


def test_the_page_about_the_studio_does_what_it_says(capsys, monkeypatch):
    monkeypatch.chdir(ROOT)
    page = (ROOT / "docs" / "studio.md").read_text(encoding="utf-8")
    served, edits = re.findall("```python\n(.*?)```", page, re.DOTALL)
    exec(served, {})
    assert capsys.readouterr().out.startswith("http://127.0.0.1:")
    exec(edits, {})


PLACES = """
mjsim: 1
walls:
  - points: [[-6, -6], [6, -6], [6, 6], [-6, 6]]
    closed: true
    openings: [{name: DOOR, segment: 0, at: 1, width: 0.9, door: {}}]
obstacles: [{name: NAME, box: [0.4, 0.4, 0.4], at: [3, 3], movable: true}]
beacons: [{name: BEACON, at: [5.9, 0]}]
lamps: [{name: LAMP, at: [0, 0]}]
robots:
  - {name: ROBOT, base: fixed, at: [0, 0], arms: [{name: ARM, preset: puma560}]}
  - {name: R, at: [-3, -3]}
people: [{name: PERSON, sex: male, percentile: 50, at: [-3, 3]}]
mechanisms:
  - name: MECHANISM
    at: [4, -4]
    elevation: 2
    bodies: [{name: rod, rod: [0.5, 0.05]}]
    joints: [{revolute: JOINT, of: [ground, rod], axis: [0, 1, 0]}]
run: {events: [EVENTS]}
"""


@pytest.mark.slow
def test_every_event_of_the_page_is_one_and_every_kind_of_event_is_on_it():
    page = (ROOT / "docs" / "changing-worlds.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `\{.*$", page, re.MULTILINE)
    events = [event for row in rows for event in re.findall(r"`(\{\w+: [A-Zlr\d][^`]*\})`", row)]
    assert {event[1:].partition(":")[0] for event in events} == set(EVENT_KINDS)
    listed = ", ".join(event.replace("{", "{time: 1, ", 1) for event in events).replace("lamp: NAME", "lamp: LAMP")
    listed = listed.replace("[x, y, z]", "[-2.6, 3.2, 1.1]").replace("[x, y]", "[2, 2]")
    world = mjsim.parse_world(PLACES.replace("EVENTS", listed))
    assert len(world.run.events) == len(events) >= 16
    assert check_world(world) == []
